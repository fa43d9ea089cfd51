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

"""The action `~/simulate_flips`: kicks out of every pose, beside the drops."""

import math
from itertools import pairwise

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal

from ros_pose_stats import simulate_flips

from ..harness.client import until
from ..harness.goals import Goals
from ..harness.jobs import known_part
from ..harness.parts import WEDGE, library_part

SUCCEEDED = GoalStatus.STATUS_SUCCEEDED
CANCELED = GoalStatus.STATUS_CANCELED
ABORTED = GoalStatus.STATUS_ABORTED
KICK = 0.012
MANY = 500_000
"""Flips of a pose that take minutes: whoever asks for them cancels them."""


@pytest.fixture
def goals(cell):
    goals_of_cell = Goals(cell, "simulate_flips")
    yield goals_of_cell
    goals_of_cell.close()


def notes_of(result):
    return [(note.code, note.text, note.acts) for note in result.warnings]


def matrix(values):
    size = math.isqrt(len(values))
    return np.reshape(values, (size, size))


def test_the_matrix_is_the_library_s(goals, cell):
    part_id = known_part(cell)
    status, result = goals.send(
        part_id=part_id, kick_height=KICK, drops=300, seed=3
    ).result()
    assert (status, result.success, result.message) == (SUCCEEDED, True, "")
    expected = simulate_flips(library_part(WEDGE), KICK, 300, seed=3)
    np.testing.assert_allclose(matrix(result.transition), expected.transition, 1e-12)
    np.testing.assert_allclose(
        matrix(result.standard_error), expected.standard_error, 1e-12
    )
    assert list(result.flips) == [300] * len(expected.poses)
    assert list(result.unsettled) == expected.unsettled.tolist()
    assert (result.part_id, result.part_digest, result.kick_height, result.seed) == (
        part_id,
        expected.part_digest,
        KICK,
        3,
    )
    assert result.restitution == 0.5
    assert notes_of(result) == [tuple(warning) for warning in expected.warnings]


def test_an_absurd_kick_is_warned_of_with_a_code(goals, cell):
    _, result = goals.send(part_id=known_part(cell), kick_height=2.0, drops=1).result()
    assert result.message == ""
    assert [code for code, _, acts in notes_of(result) if acts] == ["HEIGHT_SUSPECT"]


def test_the_node_s_number_is_shared_out_and_no_kick_leaves_all_as_it_is(goals, cell):
    _, result = goals.send(part_id=known_part(cell), kick_height=0.0).result()
    assert set(result.flips) == {10_000 // len(result.flips)} and result.seed > 0
    np.testing.assert_array_equal(matrix(result.transition), np.eye(len(result.flips)))


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"part_id": "nobody"}, "'nobody'"),
        ({"drops": 10_000_000}, "max_drops"),
        ({"kick_height": -1.0}, "flip_height is 0"),
        ({"kick_height": math.nan}, "a kick_height"),
    ],
)
def test_a_refused_goal_is_aborted_with_the_reason(goals, cell, fields, words):
    fields = {"part_id": known_part(cell), "kick_height": KICK, **fields}
    status, result = goals.send(**fields).result()
    assert (status, result.success, list(result.flips)) == (ABORTED, False, [])
    assert words in result.message and "\n" not in result.message


def test_feedback_rises_and_a_cancelled_goal_has_what_was_done(goals, cell):
    goal = goals.send(part_id=known_part(cell), kick_height=KICK, drops=MANY, seed=5)
    until(lambda: len(goal.feedback) > 2)
    assert goal.cancel().return_code == CancelGoal.Response.ERROR_NONE
    status, result = goal.result()
    assert (status, result.success) == (
        CANCELED,
        False,
    ) and "cancelled" in result.message
    feedback = goal.feedback
    assert {report.flips_total for report in feedback} == {MANY * len(result.flips)}
    assert all(b.flips_done > a.flips_done for a, b in pairwise(feedback))
    assert feedback[-1].flips_done <= sum(result.flips)
    assert max(result.flips) - min(result.flips) <= 1  # out of all poses in turn
    np.testing.assert_allclose(matrix(result.transition).sum(axis=1), 1.0, rtol=1e-12)
