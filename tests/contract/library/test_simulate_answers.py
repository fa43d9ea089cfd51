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

"""Numbers that a run of drops reports: their formulas, their order, and what is never
hidden.
"""

import math

import numpy as np
import pytest
from scipy.stats import beta

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import part_from_mesh, resting_poses, simulate
from tests.answers import by_index

RESTITUTION = 0.3


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 3))


@pytest.fixture(scope="module")
def unlucky():
    """A run of 200 drops, five of which start balanced on an edge of a cube and stay
    there.
    """
    starts = np.random.default_rng(1).standard_normal((200, 3))
    starts[::40] = (1.0, 1.0, 0.0)
    return simulate(
        part_from_mesh(*shapes.box(2.0, 2.0, 2.0)), restitution=0.0, starts=starts
    )


@pytest.mark.parametrize("drops", [0, 1, 10, 1000])
def test_probabilities_and_errors_by_the_formulas_of_the_contract(part, unlucky, drops):
    """Jeffreys' intervals of 90 %, and errors that are not 0 where a pose was never
    met.
    """
    statistics = simulate(part, drops, RESTITUTION, 2) if drops else unlucky
    count = by_index(statistics, "count")
    settled = statistics.drops - statistics.unsettled
    assert count.sum() == settled
    assert by_index(statistics, "probability").tolist() == (count / settled).tolist()
    q = (count + 0.5) / (settled + 0.5 * len(count))
    errors = np.sqrt(q * (1.0 - q) / settled)
    assert by_index(statistics, "standard_error") == pytest.approx(errors, rel=1e-12)
    assert statistics.expected_error == pytest.approx(
        math.sqrt((errors**2).mean()), rel=1e-12
    )
    a = count + 0.5
    b = settled - count + 0.5
    low = np.where(count == 0, 0.0, beta.ppf(0.05, a, b))
    high = np.where(count == settled, 1.0, beta.ppf(0.95, a, b))
    assert by_index(statistics, "probability_low") == pytest.approx(low, abs=1e-9)
    assert by_index(statistics, "probability_high") == pytest.approx(high, abs=1e-9)
    assert errors.max() < statistics.largest_error < 4.0 * errors.max()


def test_all_poses_the_most_probable_first(part):
    statistics = simulate(part, 50, RESTITUTION, 2)
    ranks = [(-pose.probability, pose.index) for pose in statistics.poses]
    assert ranks == sorted(ranks)
    assert {pose.index for pose in statistics.poses} == set(
        range(len(resting_poses(part).poses))
    )
    assert 0 in by_index(statistics, "count")
    assert (statistics.method, statistics.seed, statistics.restitution) == (
        "simulation",
        2,
        RESTITUTION,
    )
    assert statistics.part_digest == part.digest and statistics.plate_error == 0.05
    assert statistics.drop_height == pytest.approx(20.0 * statistics.radius)


def test_unsettled_drops_are_never_hidden(unlucky):
    assert (unlucky.drops, unlucky.unsettled) == (200, 5)
    (warning,) = (
        warning for warning in unlucky.warnings if warning.code == "UNSETTLED"
    )
    assert "5 of 200" in warning.text


@pytest.mark.parametrize(
    "surface",
    [shapes.cylinder(32, 1.0, 1.0), shapes.box(1.0, 0.001, 0.002)],
    ids=["cylinder", "needle"],
)
def test_counts_of_gathered_faces_add(surface):
    """The very same drops, each in the pose that its face is a member of."""
    part = part_from_mesh(*surface)
    by_face, gathered = (
        simulate(part, 300, 0.1, 1, cluster_tolerance=tolerance, round_sides=0)
        for tolerance in (0.0, 0.005)
    )
    assert len(gathered.poses) < len(by_face.poses)
    count = by_index(by_face, "count")
    for pose in gathered.poses:
        assert pose.count == count[list(pose.members)].sum()
    assert any(warning.code == "CLUSTERED" for warning in gathered.warnings)


def test_like_poses_are_told_as_a_group():
    """A hexagonal prism: six sides alike, and two ends."""
    statistics = simulate(part_from_mesh(*shapes.prism(6, 0.01, 0.016)), 300, seed=1)
    groups = {}
    for pose in statistics.poses:
        groups.setdefault(pose.group, []).append(pose)
    assert sorted(map(len, groups.values())) == [2, 6]
    for poses in groups.values():
        assert {pose.group_size for pose in poses} == {len(poses)}
        for pose in poses:
            assert pose.group_probability == pytest.approx(
                sum(member.count for member in poses) / 300, abs=1e-12
            )
