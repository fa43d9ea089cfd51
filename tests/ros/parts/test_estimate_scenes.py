"""Scenes and mass properties of the service `~/estimate`."""

from __future__ import annotations

import math

import pytest
from geometry_msgs.msg import Inertia, Vector3

from ros_pose_stats import estimate

from ..harness.jobs import finished, known_part, start
from ..harness.parts import WEDGE, flat, library_part, new_id, probabilities


class TestScene:
    def test_request_before_part_before_node(self, cell):
        part_id = known_part(cell, restitution=0.3, drop_height=2.0)
        def scene(**request):
            estimated = cell.good("estimate", part_id=part_id, **request).statistics
            simulated = finished(cell, start(cell, part_id, 50, **request)).statistics
            assert estimated.restitution == simulated.restitution
            return simulated.restitution, simulated.drop_height
        assert scene() == (0.3, 2.0)
        assert scene(restitution=0.1) == (0.1, 2.0)
        assert scene(drop_height=5.0) == (0.3, 5.0)
        assert scene(restitution=0.0, drop_height=4.0) == (0.0, 4.0)

    def test_a_carried_part_brings_its_wishes(self, cell):
        part = flat(WEDGE, new_id(), restitution=0.3)
        assert cell.good("estimate", part=part).statistics.restitution == 0.3
        assert cell.good("estimate", part=part, restitution=0.4).statistics.restitution == 0.4

    @pytest.mark.parametrize("restitution", [-1.0, -0.001, -math.inf])
    def test_negative_is_the_nodes(self, cell, restitution):
        found = cell.good("estimate", part_id=known_part(cell),
                          restitution=restitution).statistics
        assert found.restitution == 0.5

    @pytest.mark.parametrize("restitution", [1.0, 1.5, math.nan, math.inf])
    def test_restitution_out_of_range(self, cell, restitution):
        message = cell.refused("estimate", part_id=known_part(cell), restitution=restitution)
        assert str(restitution) in message and "below 1" in message

    @pytest.mark.parametrize("height", [0.0, math.nan, math.inf])
    def test_drop_height_out_of_range(self, cell, height):
        message = cell.refused("estimate", part_id=known_part(cell), drop_height=height)
        assert str(height) in message and "above 0 m" in message

    def test_a_part_whose_wishes_are_out_of_range(self, cell):
        part_id = new_id()
        assert "1.0" in cell.refused("estimate", part=flat(WEDGE, part_id, restitution=1.0))
        assert part_id in cell.refused("estimate", part_id=part_id)  # not remembered

    @pytest.mark.parametrize("target", [-0.1, 1.0, math.nan])
    def test_a_target_out_of_range(self, cell, target):
        assert str(target) in cell.refused("estimate", part_id=known_part(cell),
                                           target_error=target)

    def test_a_target_that_is_missed_is_said(self, cell):
        part_id = known_part(cell)
        found = cell.good("estimate", part_id=part_id, target_error=1e-6).statistics
        assert any(one.startswith("TARGET_MISSED: ") for one in found.warnings)
        again = cell.good("estimate", part_id=part_id).statistics
        assert not any(one.startswith("TARGET_MISSED: ") for one in again.warnings)


class TestMassProperties:
    def test_unit(self, cell):
        vertices, triangles = WEDGE
        part = flat((1000.0 * vertices, triangles), new_id(), unit=0.001)
        found = cell.good("estimate", part=part).statistics
        assert found.radius == pytest.approx(estimate(library_part(WEDGE)).radius, rel=1e-12)

    def test_mass_center_and_inertia_are_used(self, cell):
        inertia = Inertia(m=0.4, com=Vector3(x=0.02, y=0.012, z=0.006), ixx=3e-5, iyy=4e-5,
                          izz=5e-5, ixy=1e-6, ixz=-2e-6, iyz=5e-7)
        tensor = [[3e-5, 1e-6, -2e-6], [1e-6, 4e-5, 5e-7], [-2e-6, 5e-7, 5e-5]]
        expected = estimate(library_part(
            WEDGE, mass=0.4, center_of_mass=(0.02, 0.012, 0.006), inertia=tensor))
        found = cell.good("estimate", part=flat(WEDGE, new_id(), inertia=inertia)).statistics
        assert found.part_digest == expected.part_digest
        assert probabilities(found.poses) == probabilities(expected.poses)

    def test_the_center_is_in_metres_whatever_the_unit(self, cell):
        vertices, triangles = WEDGE
        inertia = Inertia(m=1.0, com=Vector3(x=0.02, y=0.012, z=0.006))
        part = flat((1000.0 * vertices, triangles), new_id(), unit=0.001, inertia=inertia)
        found = cell.good("estimate", part=part).statistics
        expected = estimate(library_part(WEDGE, mass=1.0, center_of_mass=(0.02, 0.012, 0.006)))
        assert probabilities(found.poses) == pytest.approx(probabilities(expected.poses))

    @pytest.mark.parametrize("inertia", [
        Inertia(ixx=1e-5, iyy=1e-5, izz=1e-5), Inertia(com=Vector3(x=0.01)),
        Inertia(m=-1.0), Inertia(m=math.nan), Inertia(m=1.0, com=Vector3(x=9.0)),
        Inertia(m=1.0, com=Vector3(x=math.nan)), Inertia(m=1.0, ixx=-1.0, iyy=1.0, izz=1.0),
        Inertia(m=1.0, com=Vector3(x=0.02, y=0.012, z=0.006), ixx=1.0, iyy=1e-3, izz=1e-3)],
        ids=["no mass", "centre without mass", "negative", "nan", "outside", "centre nan",
             "negative inertia", "no body"])
    def test_impossible_ones_are_refused(self, cell, inertia):
        assert cell.refused("estimate", part=flat(WEDGE, new_id(), inertia=inertia))
