# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Scenes and mass properties at the ends of what may be asked for."""

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import part_from_mesh, resting_poses, simulate
from tests.answers import codes, counts


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 3))


@pytest.fixture(scope="module")
def radius(part):
    return resting_poses(part).body.radius


@pytest.mark.parametrize(
    ("restitution", "drops"), [(0.0, 2000), (0.95, 100), (0.99, 30)]
)
def test_dull_and_lively_plates(part, restitution, drops):
    statistics = simulate(part, drops, restitution, 1)
    assert (sum(counts(statistics)), statistics.unsettled) == (drops, 0)


def test_a_restitution_that_ends_no_drop_is_reported(part):
    statistics = simulate(part, 2, 1.0 - 1e-9, 1)
    assert (statistics.drops, statistics.unsettled) == (2, 2)
    assert np.isnan([pose.probability for pose in statistics.poses]).all()
    assert np.isnan(statistics.expected_error)
    assert "UNSETTLED: 2 of 2" in "\n".join(map(str, statistics.warnings))


@pytest.mark.parametrize("radii", [1e-9, 1.0, 1.0 + 1e-12, 2.0, 1e4])
def test_drop_heights(part, radius, radii):
    for restitution in (0.0, 0.6):
        statistics = simulate(part, 100, restitution, 1, drop_height=radii * radius)
        assert (sum(counts(statistics)), statistics.unsettled) == (100, 0)
        assert statistics.drop_height == radii * radius
        assert ("RELEASED_TOUCHING" in codes(statistics)) == (radii < 1.0)


def test_too_low_to_fit_is_at_rest_on_the_plate(part, radius):
    """All such heights are one and the same release, counted in the warning."""
    low, lower = (
        simulate(part, 300, 0.4, 2, drop_height=h * radius) for h in (0.2, 0.1)
    )
    assert counts(low) == counts(lower)
    assert any("in 300 of 300 drops" in warning.text for warning in low.warnings)
    middle = simulate(part, 300, 0.4, 2, drop_height=0.8 * radius)
    (warning,) = (
        warning for warning in middle.warnings if warning.code == "RELEASED_TOUCHING"
    )
    assert 0 < int(warning.text.split()[1]) < 300


@pytest.mark.parametrize(
    "center", [(0.99, 0.99, 0.99), (0.999, 0.0, 0.0), (0.9, 0.99, -0.5)]
)
def test_centre_of_mass_far_off_the_centroid(center):
    cube = part_from_mesh(*shapes.box(2.0, 2.0, 2.0), center_of_mass=center)
    for restitution in (0.0, 0.5, 0.8):
        statistics = simulate(cube, 300, restitution, 1)
        assert statistics.unsettled == 0
        lowest = min(pose.height for pose in statistics.poses)
        assert (
            sum(pose.count for pose in statistics.poses if pose.height < lowest + 0.02)
            > 150
        )


@pytest.mark.parametrize(
    "moments",
    [
        (1.0, 1.0, 1e-3),
        (1.0, 1.0, 2.0),
        (30.0, 30.0, 30.0),
        (1e-6, 1.0, 1.0),
        (1e-6, 1e-6, 1e-6),
    ],
)
def test_uneven_inertia_and_nearly_none(moments):
    """Corners off the axis of a rod take as many impacts as the ratio of masses: too
    many.
    """
    body = part_from_mesh(*random_polyhedron(9, 3), mass=1.0, inertia=np.diag(moments))
    for restitution in (0.0, 0.5):
        statistics = simulate(body, 20, restitution, 1)
        assert sum(counts(statistics)) + statistics.unsettled == 20
        assert ("UNSETTLED" in codes(statistics)) == (statistics.unsettled > 0)
        assert statistics.unsettled == 0 or min(moments) < 1e-3


def test_a_rod_of_no_width_to_speak_of():
    """Inertia of a line of points: the least moment is 3e-10 of the others."""
    rod = part_from_mesh(
        *shapes.box(1000.0, 1.0, 1.0),
        mass=1.0,
        inertia=np.diag((1e-9, 1.0, 1.0)) * 1000.0**2 / 12.0,
    )
    for restitution in (0.0, 0.5):
        statistics = simulate(rod, 100, restitution, 1, cluster_tolerance=0.0)
        assert statistics.unsettled == 0 and sum(counts(statistics)[:4]) == 100


def test_no_drop_goes_on_for_ever(part, radius):
    """From such a height the energy falls by a little each time, for hours."""
    statistics = simulate(
        part, restitution=0.99, starts=[(0.3, 0.2, 0.1)], drop_height=1e160 * radius
    )
    assert (statistics.drops, statistics.unsettled) == (1, 1)
