"""Scenes and mass properties at the ends of what may be asked for."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, resting_poses, shapes, simulate

from ..bodies import random_polyhedron
from .dropping import alike, counts, dropped


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 3))


@pytest.mark.parametrize(("restitution", "drops"), [(0.0, 4000), (0.95, 200), (0.99, 40)])
def test_dull_and_lively_plates(part, restitution, drops):
    found = simulate(part, drops, restitution, 1)
    assert (sum(counts(found)), found.unsettled) == (drops, 0)


def test_restitutions_that_end_no_drop_are_reported(part):
    found = simulate(part, 4, 1.0 - 1e-9, 1)
    assert (found.drops, found.unsettled) == (4, 4)
    assert np.isnan([pose.probability for pose in found.poses]).all()
    assert np.isnan(found.expected_error)
    assert any(text.startswith("UNSETTLED: 4 of 4") for text in found.warnings)


@pytest.mark.parametrize("radii", [1e-9, 0.3, 1.0, 1.0 + 1e-12, 2.0, 5.0, 100.0, 1e4])
def test_drop_heights(part, radii):
    radius = resting_poses(part).body.radius
    for restitution in (0.0, 0.6):
        found = simulate(part, 200, restitution, 1, drop_height=radii * radius)
        assert (sum(counts(found)), found.unsettled) == (200, 0)
        assert found.drop_height == radii * radius
        touching = any(text.startswith("RELEASED_TOUCHING") for text in found.warnings)
        assert touching == (radii < 1.0)


def test_released_touching_is_released_at_rest_on_the_plate(part):
    """All heights too low to fit are one and the same release, counted in the warning."""
    radius = resting_poses(part).body.radius
    low, lower = (simulate(part, 300, 0.4, 2, drop_height=h * radius) for h in (0.2, 0.1))
    assert counts(low) == counts(lower)
    assert any("in 300 of 300 drops" in text for text in low.warnings)
    middle = simulate(part, 300, 0.4, 2, drop_height=0.8 * radius)
    text, = (text for text in middle.warnings if text.startswith("RELEASED_TOUCHING"))
    assert 0 < int(text.split()[2]) < 300


def test_energy_is_never_above_that_of_the_release(part):
    found = dropped(part, 0.9, 500, height=resting_poses(part).body.radius * 3.0)
    assert found.energy_left.max() < 3.0 + 1e-12
    assert found.energy_left.min() > 0.0


@pytest.mark.parametrize("center", [(0.99, 0.99, 0.99), (0.999, 0.0, 0.0), (0.9, 0.99, -0.5)])
def test_centre_of_mass_far_off_the_centroid(center):
    cube = part_from_mesh(*shapes.box(2.0, 2.0, 2.0), center_of_mass=center)
    for restitution in (0.0, 0.2, 0.5, 0.8):
        found = simulate(cube, 400, restitution, 1)
        assert found.unsettled == 0
        lowest = min(pose.height for pose in found.poses)
        low = sum(pose.count for pose in found.poses if pose.height < lowest + 0.02)
        assert low > 200


@pytest.mark.parametrize("moments", [(1.0, 1.0, 1e-3), (1e-2, 1.0, 1.0), (1.0, 1.0, 2.0),
                                     (0.5, 0.5, 1.0), (30.0, 30.0, 30.0)])
def test_uneven_inertia(moments):
    body = part_from_mesh(*random_polyhedron(9, 3), mass=1.0, inertia=np.diag(moments))
    for restitution in (0.0, 0.5):
        assert simulate(body, 200, restitution, 1).unsettled == 0


@pytest.mark.parametrize("moments", [(1e-6, 1.0, 1.0), (1.0, 1e-9, 1.0), (1e-12, 1e-12, 1e-12)])
def test_nearly_no_inertia_is_reported_not_hidden(moments):
    """Corners off the axis of a rod take as many impacts as the ratio of masses: too many."""
    body = part_from_mesh(*random_polyhedron(9, 3), mass=1.0, inertia=np.diag(moments))
    for restitution in (0.0, 0.5):
        found = simulate(body, 20, restitution, 1)
        assert sum(counts(found)) + found.unsettled == 20
        warned = any(text.startswith("UNSETTLED") for text in found.warnings)
        assert warned == (found.unsettled > 0)


def test_a_rod_of_no_width_to_speak_of():
    """Inertia of a line of points: the least moment is 3e-10 of the others."""
    rod = part_from_mesh(*shapes.box(1000.0, 1.0, 1.0), mass=1.0,
                         inertia=np.diag((1e-9, 1.0, 1.0)) * 1000.0**2 / 12.0)
    found, other = (simulate(rod, 200, r, 1, cluster_tolerance=0.0) for r in (0.0, 0.5))
    assert (found.unsettled, other.unsettled) == (0, 0)
    assert sum(counts(found)[:4]) == 200


def test_shares_do_not_hang_on_mass_and_gravity_free_units(part):
    """Ten times the mass with ten times the inertia is the same body."""
    heavy = part_from_mesh(part.vertices, part.triangles, center_of_mass=part.center_of_mass,
                           mass=10.0, inertia=10.0 * part.inertia)
    assert alike(simulate(part, 2000, 0.3, 1), simulate(heavy, 2000, 0.3, 1)) > 1e-4
