"""The action `~/simulate_drops`."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal

from ros_pose_stats import simulate

from ..harness.client import CANCELLED, DONE, QUEUED, RUNNING, until
from ..harness.goals import Goals
from ..harness.jobs import LONG, get, known_part, reached, start
from ..harness.parts import WEDGE, counts, flat, library_part, nested, new_id, whole

SUCCEEDED, CANCELED, ABORTED = (
    GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED)


@pytest.fixture
def goals(cell):
    found = Goals(cell)
    yield found
    found.close()


class TestSuccess:
    def test_counts_are_those_of_the_library(self, goals, cell):
        part_id = known_part(cell)
        status, result = goals.send(part_id=part_id, drops=1000, seed=3).result()
        assert (status, result.success, result.message) == (SUCCEEDED, True, "")
        expected = simulate(library_part(WEDGE), 1000, seed=3)
        assert counts(result.statistics.poses) == counts(expected.poses)

    def test_result_is_what_get_says(self, goals, cell):
        _, result = goals.send(part_id=known_part(cell), drops=500).result()
        answer = get(cell, result.job_id)
        assert (answer.state, whole(answer.statistics)) == (DONE, whole(result.statistics))

    def test_a_part_may_be_carried(self, goals, cell):
        part_id = new_id()
        status, result = goals.send(part=nested(WEDGE, part_id), drops=100).result()
        assert (status, result.statistics.part_id) == (SUCCEEDED, part_id)
        assert cell.good("get_statistics", part_id=part_id).statistics

    def test_feedback_rises(self, goals, cell):
        goal = goals.send(part_id=known_part(cell), drops=LONG, seed=2, max_seconds=1.5)
        status, result = goal.result()
        assert status == SUCCEEDED
        told = goal.feedback
        assert len(told) > 2
        assert {one.job_id for one in told} == {result.job_id}
        assert {one.drops_total for one in told} == {LONG}
        assert all(b.drops_done > a.drops_done for a, b in pairwise(told))
        assert 0.0 < told[-1].expected_error < told[0].expected_error
        assert all(np.isfinite(one.drops_per_second) and one.drops_per_second > 0.0
                   for one in told[1:])


class TestRefusals:
    @pytest.mark.parametrize(("asked", "said"), [
        ({"part_id": "nobody"}, "'nobody'"),
        ({"drops": 10_000_001}, "10000001"),
        ({"restitution": 1.5}, "1.5"),
        ({"target_error": 2.0}, "2.0"),
    ])
    def test_aborted_with_the_reason(self, goals, cell, asked, said):
        if "part_id" not in asked:
            asked = {**asked, "part_id": known_part(cell)}
        status, result = goals.send(**asked).result()
        assert (status, result.success, result.job_id) == (ABORTED, False, "")
        assert said in result.message and "\n" not in result.message

    def test_a_full_queue(self, goals, cell):
        part_id = known_part(cell)
        reached(cell, start(cell, part_id, LONG, seed=1), RUNNING)
        for seed in range(2, 18):
            start(cell, part_id, LONG, seed=seed)
        status, result = goals.send(part_id=part_id, drops=LONG, seed=99).result()
        assert status == ABORTED and "max_queued_jobs" in result.message

    def test_a_bad_mesh(self, goals):
        vertices, triangles = WEDGE
        status, result = goals.send(part=flat((vertices, triangles + 5), new_id()),
                                    drops=100).result()
        assert status == ABORTED and "vert" in result.message


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
        assert get(cell, result.job_id).state == CANCELLED

    def test_queued_while_another_runs(self, goals, cell):
        part_id = known_part(cell)
        other = start(cell, part_id, LONG)
        goal = goals.send(part_id=part_id, drops=777)
        assert len(goal.cancel().goals_canceling) == 1
        status, result = goal.result()
        assert (status, result.statistics.drops) == (CANCELED, 0)
        assert get(cell, other).state == RUNNING

    def test_a_queued_goal_sent_as_one(self, goals, cell):
        part_id = known_part(cell)
        running = goals.send(part_id=part_id, drops=LONG, seed=1)
        running.first_feedback()
        waiting = [goals.send(part_id=part_id, drops=LONG, seed=seed) for seed in range(2, 7)]
        for goal in waiting:
            goal.cancel()
            assert goal.result()[0] == CANCELED
        assert not running.ended
        running.cancel()
        assert running.result()[0] == CANCELED

    def test_at_once_after_acceptance(self, goals, cell):
        """Cancels that meet the job at its beginning."""
        part_id = known_part(cell)
        for seed in range(1, 21):
            goal = goals.send(part_id=part_id, drops=LONG, seed=seed)
            goal.cancel()
            status, result = goal.result()
            assert status == CANCELED, result.message
            assert get(cell, result.job_id).state == CANCELLED

    def test_through_the_service_aborts_with_the_message(self, goals, cell):
        goal = goals.send(part_id=known_part(cell), drops=LONG)
        cell.good("cancel_drop_simulation", job_id=goal.first_feedback().job_id)
        status, result = goal.result()
        assert status == ABORTED and "cancelled" in result.message
        assert result.statistics.drops > 0

    def test_of_an_ended_goal_changes_nothing(self, goals, cell):
        goal = goals.send(part_id=known_part(cell), drops=100)
        status, result = goal.result()
        assert len(goal.cancel().goals_canceling) == 0
        assert (status, get(cell, result.job_id).state) == (SUCCEEDED, DONE)


class TestSharing:
    def test_identical_goals_have_one_job_and_both_get_the_result(self, goals, cell):
        part_id = known_part(cell)
        blocker = start(cell, part_id, LONG)
        asked = {"part_id": part_id, "drops": 5000, "seed": 4}
        twins = [goals.send(**asked) for _ in range(2)]
        job_id = start(cell, **asked)
        assert get(cell, job_id).state == QUEUED
        cell.good("cancel_drop_simulation", job_id=blocker)
        (first, one), (second, other) = (goal.result() for goal in twins)
        assert (first, second) == (SUCCEEDED, SUCCEEDED)
        assert whole(one) == whole(other) and one.job_id == job_id

    def test_a_goal_that_joins_a_running_job_gets_feedback_and_result(self, goals, cell):
        asked = {"part_id": known_part(cell), "drops": LONG, "seed": 4, "max_seconds": 2.0}
        first = goals.send(**asked)
        job_id = first.first_feedback().job_id
        second = goals.send(**asked)
        assert second.first_feedback().job_id == job_id
        assert first.result() == second.result()

    def test_a_cancel_through_one_ends_the_job_of_both(self, goals, cell):
        asked = {"part_id": known_part(cell), "drops": LONG, "seed": 4}
        first, second = (goals.send(**asked) for _ in range(2))
        first.first_feedback()
        second.cancel()
        (one, aborted), (other, canceled) = first.result(), second.result()
        assert (one, other) == (ABORTED, CANCELED)
        assert "cancelled" in aborted.message
        assert whole(aborted.statistics) == whole(canceled.statistics)

    @pytest.mark.long
    def test_many_goals_end_each_in_its_own_way(self, goals, cell):
        part_id = known_part(cell)
        sent = [goals.send(part_id=part_id, drops=2000, seed=seed) for seed in range(1, 13)]
        for goal in sent[6::2]:
            goal.cancel()
        for place, goal in enumerate(sent):
            status, result = goal.result()
            wanted = {SUCCEEDED} if place < 6 or place % 2 else {CANCELED, SUCCEEDED}
            assert status in wanted, (place, result.message)
            until(lambda result=result: get(cell, result.job_id).state >= DONE)
