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

"""Counted flips beside the model's: closed forms, redrawn rows, poses that look
alike.
"""

import math

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import (
    FeederCell,
    PoseStatsError,
    estimate,
    learn_flips,
    part_from_mesh,
    plan_feeding,
    simulate_flips,
)

KICKS = 0.1, 0.3, 0.9


@pytest.fixture(scope="module")
def kicks():
    """Of a body of several poses and no symmetry."""
    part = part_from_mesh(*random_polyhedron(8, 21))
    return [simulate_flips(part, kick, 2000, seed=3) for kick in KICKS]


def drawn(rows, flips, seed):
    random = np.random.default_rng(seed)
    return np.array([random.multinomial(flips, row / row.sum()) for row in rows])


def test_a_row_is_the_mean_of_a_dirichlet(kicks):
    """(s t + c) / (s + n), with t the model's row out of n + 1/2 flips, the half spread
    evenly.
    """
    counts = drawn(kicks[1].transition, 40, 1)
    poses = len(kicks[1].poses)
    learnt = learn_flips(kicks[1:2], counts, "slow")
    row = (kicks[1].counts + 0.5 / poses) / 2000.5
    flips = learnt.counts.sum(axis=1)[0]
    assert 43.0 <= flips <= 340.0
    expected = ((flips - 40.0) * row + counts) / flips
    np.testing.assert_allclose(learnt.transition, expected, rtol=1e-12)
    np.testing.assert_allclose(learnt.counts, flips * learnt.transition, rtol=1e-12)
    error = np.sqrt(learnt.transition * (1.0 - learnt.transition) / (flips + 1.0))
    np.testing.assert_allclose(learnt.standard_error, error, rtol=1e-9)
    assert (learnt.feeder_setting, learnt.counted_flips) == ("slow", 40 * poses)


def test_the_kick_is_the_one_that_was_counted(kicks):
    for kick in kicks:
        flips = learn_flips(kicks, drawn(kick.transition, 100, 2))
        assert flips.kick_height == kick.kick_height


def test_it_is_nearer_than_model_and_counts_where_the_cell_is_off(kicks):
    """Rows that scatter about the model's as a Dirichlet of 40 flips, of which 40 are
    counted.

    The posterior's expected square error is half of either alone, less what its
    strength costs.
    """
    random = np.random.default_rng(4)
    errors = []
    for _ in range(60):
        truth = np.array(
            [random.dirichlet(40.0 * row + 1e-9) for row in kicks[1].transition]
        )
        counts = drawn(truth, 40, random.integers(2**31))
        flips = learn_flips(kicks, counts).transition
        errors.append(
            [
                np.mean((matrix - truth) ** 2)
                for matrix in (flips, kicks[1].transition, counts / 40.0)
            ]
        )
    learned, model, counted = np.mean(errors, axis=0)
    assert learned < 0.75 * min(model, counted)


def test_poses_that_look_alike_share_their_counts():
    """A camera names either of a box's two equal faces; groups are known by all flips
    of both.
    """
    flips = simulate_flips(
        part_from_mesh(*shapes.box(1.0, 2.0, 3.0)), 0.9, 2000, seed=3
    )
    first_counts, both_counts = np.zeros((2, 6, 6), np.int64)
    first_counts[0, [0, 2]] = 400, 200
    both_counts[[0, 0, 1, 1], [0, 2, 1, 3]] = 250, 50, 150, 150
    first, second = (
        learn_flips([flips], counts) for counts in (first_counts, both_counts)
    )
    np.testing.assert_allclose(first.transition, second.transition, rtol=1e-9)
    between_groups = first.transition.reshape(3, 2, 3, 2).sum(axis=3)
    np.testing.assert_allclose(between_groups[:, 0], between_groups[:, 1], rtol=1e-9)
    # Poses of a group share its error, as they share what is known of it.
    share = between_groups[0, 0, 1]
    group_count = 2.0 * first.counts[0].sum()
    assert first.standard_error[0, 2:4].sum() == pytest.approx(
        math.sqrt(share * (1.0 - share) / (group_count + 1.0)), rel=1e-6
    )
    # 600 flips of both poses together, and at most 300 of the model out of each.
    assert between_groups[0, 0, 1] == pytest.approx(1.0 / 3.0, abs=0.15)
    assert 2.0 * first.counts[:2].sum(axis=1) == pytest.approx(first.counts[:2].sum())


def test_flips_of_two_parts_are_not_one_feeders(kicks):
    other_part = part_from_mesh(*random_polyhedron(8, 22))
    flips = simulate_flips(other_part, 0.1, 20, seed=3)
    cell = FeederCell(60.0, (0.3, 0.2))
    for call in (
        lambda: learn_flips([*kicks, flips], np.zeros((1, 1), int)),
        lambda: plan_feeding(estimate(other_part, "split"), [0], cell, kicks),
    ):
        with pytest.raises(PoseStatsError, match="results of one part"):
            call()


@pytest.mark.parametrize(
    ("wanted_poses", "cell"),
    [
        ([True, False], {}),
        ([1.0], {}),
        ([math.nan], {}),
        ([], {}),
        ([0], {"rate": "60"}),
        ([0], {"plate": (0.3,)}),
        ([0], {"plate": 0.3}),
        ([0], {"plate": (1e200, 0.3)}),
        ([0], {"clearance": None}),
    ],
)
def test_what_is_no_feeder_is_refused(kicks, wanted_poses, cell):
    dropped = estimate(part_from_mesh(*random_polyhedron(8, 21)), "split")
    feeder = FeederCell(**{"rate": 60.0, "plate": (0.3, 0.2), **cell})
    with pytest.raises(PoseStatsError):
        plan_feeding(dropped, wanted_poses, feeder, kicks)
