"""The service `~/estimate`."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import estimate, shapes
from tests.bodies import METHODS

from ..harness.jobs import known_part
from ..harness.parts import WEDGE, flat, library_part, mesh, nested, new_id, probabilities, whole

SPHERE_POINTS = 5100


def expected_of(part_id, method="split", **scene):
    return estimate(library_part(WEDGE, part_id), method, **scene)


class TestParts:
    @pytest.mark.parametrize("make", [flat, nested])
    def test_a_carried_part_is_estimated_and_remembered(self, cell, make):
        part_id = new_id()
        found = cell.good("estimate", part=make(WEDGE, part_id)).statistics
        assert found.part_id == part_id
        assert found.part_digest == library_part(WEDGE).digest
        again = cell.good("estimate", part_id=part_id).statistics
        assert whole(again) == whole(found)

    def test_a_nameless_part_is_named_by_its_digest(self, cell):
        found = cell.good("estimate", part=flat(WEDGE)).statistics
        assert found.part_id == f"mesh_{found.part_digest[:12]}"
        assert cell.good("estimate", part_id=found.part_id).statistics

    def test_the_name_beside_a_nameless_part_is_its_name(self, cell):
        part_id = new_id()
        found = cell.good("estimate", part_id=part_id, part=flat(WEDGE)).statistics
        assert found.part_id == part_id

    def test_the_same_name_twice_is_one_name(self, cell):
        part_id = new_id()
        found = cell.good("estimate", part_id=part_id, part=flat(WEDGE, part_id)).statistics
        assert found.part_id == part_id

    def test_two_different_names_are_refused(self, cell):
        message = cell.refused("estimate", part_id="one", part=flat(WEDGE, "other"))
        assert "'one'" in message and "'other'" in message

    def test_unknown_part(self, cell):
        assert "'nobody'" in cell.refused("estimate", part_id="nobody")

    def test_no_part(self, cell):
        assert "part_id" in cell.refused("estimate")

    def test_both_mesh_and_flat_arrays(self, cell):
        part = flat(WEDGE, new_id(), mesh=mesh(WEDGE))
        message = cell.refused("estimate", part=part)
        assert "both" in message and "exactly one" in message

    @pytest.mark.parametrize("lacking", ["vertices", "triangles"])
    def test_half_a_mesh(self, cell, lacking):
        part = flat(WEDGE, new_id())
        setattr(part, lacking, [])
        assert cell.refused("estimate", part=part)

    def test_numbers_that_are_no_points(self, cell):
        part = flat(WEDGE, new_id())
        part.vertices = list(part.vertices)[:-1]
        message = cell.refused("estimate", part=part)
        assert "three" in message and str(3 * len(WEDGE[0]) - 1) in message

    def test_a_nested_mesh_of_more_than_10000_triangles(self, cell):
        ball = shapes.hull_mesh(shapes.sphere_points(SPHERE_POINTS, 1))
        assert len(ball[1]) > 10_000
        message = cell.refused("estimate", part=nested(ball, new_id()))
        assert str(len(ball[1])) in message and "10000" in message
        assert "publish it on ~/part_mesh or use the flat arrays" in message

    @pytest.mark.parametrize("unit", [0.0, -1.0, math.nan, math.inf])
    def test_a_unit_that_is_none(self, cell, unit):
        assert str(unit) in cell.refused("estimate", part=flat(WEDGE, new_id(), unit=unit))

    def test_a_name_that_nobody_can_read(self, cell):
        assert "201" in cell.refused("estimate", part=flat(WEDGE, "x" * 201))
        assert "printable" in cell.refused("estimate", part=flat(WEDGE, "a\nb"))

    def test_names_in_any_script(self, cell):
        found = cell.good("estimate", part=flat(WEDGE, "Winkel 4×5 – 支架")).statistics
        assert found.poses[0].pose_id.startswith("Winkel 4×5 – 支架/")

    @pytest.mark.parametrize("value", [math.nan, math.inf])
    def test_a_vertex_nowhere(self, cell, value):
        vertices = WEDGE[0].copy()
        vertices[2, 1] = value
        assert cell.refused("estimate", part=flat((vertices, WEDGE[1]), new_id()))

    def test_a_refused_mesh_is_refused_again(self, cell):
        part = flat((WEDGE[0], WEDGE[1][:1]), new_id())
        assert cell.refused("estimate", part=part) == cell.refused("estimate", part=part)


class TestValues:
    @pytest.mark.parametrize("method", METHODS)
    def test_are_those_of_the_library(self, cell, method):
        part_id = known_part(cell)
        found = cell.good("estimate", part_id=part_id, method=method).statistics
        expected = expected_of(part_id, method)
        assert found.method == method
        assert probabilities(found.poses) == probabilities(expected.poses)
        assert [pose.index for pose in found.poses] == [pose.index for pose in expected.poses]
        np.testing.assert_equal(found.expected_error, expected.expected_error)
        np.testing.assert_equal(found.drop_height, expected.drop_height)

    def test_everything_else_too(self, cell):
        part_id = known_part(cell)
        found = cell.good("estimate", part_id=part_id).statistics
        expected = expected_of(part_id)
        for name in ("part_id", "part_digest", "radius", "restitution", "cluster_tolerance",
                     "drops", "unsettled", "seed", "plate_error", "version"):
            assert getattr(found, name) == getattr(expected, name), name
        assert tuple(found.warnings) == expected.warnings
        assert (found.header.frame_id, found.plate, found.job_id) == ("plate", "", "")
        assert found.final and found.revision > 0 and found.header.stamp.sec > 0
        for pose, twin in zip(found.poses, expected.poses, strict=True):
            assert pose.pose_id == f"{part_id}/{pose.index}"
            for name in ("index", "group", "height", "top", "margin", "barrier", "spread",
                         "count"):
                assert getattr(pose, name) == getattr(twin, name), name

    def test_an_unknown_method(self, cell):
        message = cell.refused("estimate", part_id=known_part(cell), method="guess")
        assert "'guess'" in message and "combined" in message and "auto" in message

    @pytest.mark.parametrize("method", ["simulation", "hybrid"])
    def test_what_needs_drops_is_no_estimator(self, cell, method):
        message = cell.refused("estimate", part_id=known_part(cell), method=method)
        assert f"got '{method}'" in message
        assert "auto with a target_error" in message and "start a drop simulation" in message
