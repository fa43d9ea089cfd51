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

"""The action `~/simulate_drops`: feedback, result and cancel."""

import math
from itertools import pairwise

import pytest
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal

from ros_pose_stats import simulate

from ..harness.client import CANCELLED, DONE, QUEUED, RUNNING, until
from ..harness.goals import Goals
from ..harness.jobs import LONG, get, known_part, reached, start
from ..harness.parts import WEDGE, counts, library_part, nested, new_id, whole

SUCCEEDED = GoalStatus.STATUS_SUCCEEDED
CANCELED = GoalStatus.STATUS_CANCELED
ABORTED = GoalStatus.STATUS_ABORTED


@pytest.fixture
def goals(cell):
    goals_of_cell = Goals(cell)
    yield goals_of_cell
    goals_of_cell.close()


class TestSuccess:
    def test_the_result_is_that_of_the_library_and_what_get_says(self, goals, cell):
        part_id = new_id()
        status, result = goals.send(
            part=nested(WEDGE, part_id), drops=1000, seed=3
        ).result()
        assert (status, result.success, result.message) == (SUCCEEDED, True, "")
        expected = simulate(library_part(WEDGE), 1000, seed=3)
        assert counts(result.statistics.poses) == counts(expected.poses)
        answer = get(cell, result.job_id)
        assert (answer.status.state, whole(answer.statistics)) == (
            DONE,
            whole(result.statistics),
        )
        assert cell.good("get_statistics", part_id=part_id).statistics

    def test_feedback_rises(self, goals, cell):
        goal = goals.send(part_id=known_part(cell), drops=LONG, seed=2)
        until(lambda: len(goal.feedback) > 3)
        goal.cancel()
        _, result = goal.result()
        feedback = goal.feedback
        assert {report.job_id for report in feedback} == {result.job_id}
        assert {report.drops_total for report in feedback} == {LONG}
        assert all(b.drops_done > a.drops_done for a, b in pairwise(feedback))
        assert feedback[-1].drops_done <= result.statistics.drops
        assert 0.0 < feedback[-1].expected_error < feedback[0].expected_error
        assert all(0.0 < report.drops_per_second < math.inf for report in feedback[1:])


class TestRefusals:
    @pytest.mark.parametrize(
        ("fields", "words"),
        [
            ({"part_id": "nobody"}, "'nobody'"),
            ({"drops": 10_000_001}, "10000001"),
            ({"restitution": 1.5}, "1.5"),
            ({"target_error": 2.0}, "2.0"),
        ],
    )
    def test_aborted_with_the_reason(self, goals, cell, fields, words):
        status, result = goals.send(**{"part_id": known_part(cell), **fields}).result()
        assert (status, result.success, result.job_id) == (ABORTED, False, "")
        assert words in result.message and "\n" not in result.message


class TestCancel:
    def test_running_has_the_statistics_so_far(self, goals, cell):
        goal = goals.send(part_id=known_part(cell), drops=LONG, seed=5)
        goal.first_feedback()
        assert goal.cancel().return_code == CancelGoal.Response.ERROR_NONE
        status, result = goal.result()
        assert (status, result.success) == (CANCELED, False)
        assert "cancelled" in result.message
        expected = simulate(library_part(WEDGE), result.statistics.drops, seed=5)
        assert counts(result.statistics.poses) == counts(expected.poses)
        assert get(cell, result.job_id).status.state == CANCELLED

    def test_queued_ends_alone(self, goals, cell):
        part_id = known_part(cell)
        running = goals.send(part_id=part_id, drops=LONG, seed=1)
        running.first_feedback()
        for seed in range(2, 5):
            goal = goals.send(part_id=part_id, drops=LONG, seed=seed)
            assert len(goal.cancel().goals_canceling) == 1
            status, result = goal.result()
            assert (status, result.statistics.drops) == (CANCELED, 0)
        assert not running.ended


class TestSharing:
    def test_identical_goals_have_one_job_and_all_get_the_result(self, goals, cell):
        part_id = known_part(cell)
        blocker = start(cell, part_id, LONG)
        fields = {"part_id": part_id, "drops": 5000, "seed": 4}
        twins = [goals.send(**fields) for _ in range(2)]
        job_id = start(cell, **fields)
        assert get(cell, job_id).status.state == QUEUED
        cell.good("cancel_drop_simulation", job_id=blocker)
        (first, first_status), (second, second_status) = (
            goal.result() for goal in twins
        )
        assert (first, second, first_status.job_id) == (SUCCEEDED, SUCCEEDED, job_id)
        assert whole(first_status) == whole(second_status)

    def test_a_goal_that_joins_a_running_job_gets_feedback_and_result(
        self, goals, cell
    ):
        fields = {"part_id": known_part(cell), "drops": LONG, "seed": 4}
        job_id = start(cell, **fields)
        reached(cell, job_id, RUNNING)
        first, second = (goals.send(**fields) for _ in range(2))
        assert first.first_feedback().job_id == second.first_feedback().job_id == job_id
        second.cancel()  # ends the job of both
        (first_result, aborted), (second_result, canceled) = (
            first.result(),
            second.result(),
        )
        assert (first_result, second_result) == (ABORTED, CANCELED)
        assert "cancelled" in aborted.message
        assert whole(aborted.statistics) == whole(canceled.statistics)
