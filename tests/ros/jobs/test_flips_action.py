"""The action `~/simulate_flips`."""

from __future__ import annotations

import math
import signal
from itertools import pairwise

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal

from ros_pose_stats import simulate_flips

from ..harness.client import RUNNING, until
from ..harness.goals import Goals
from ..harness.jobs import LONG, get, known_part, reached, start
from ..harness.parts import WEDGE, library_part

SUCCEEDED, CANCELED, ABORTED = (
    GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED)
KICK = 0.012
MANY = 500_000
"""Flips of a pose that take minutes: whoever asks for them cancels them."""


@pytest.fixture
def goals(cell):
    found = Goals(cell, "simulate_flips")
    yield found
    found.close()


def matrix(values):
    size = math.isqrt(len(values))
    return np.reshape(values, (size, size))


class TestSuccess:
    def test_the_matrix_is_the_library_s(self, goals, cell):
        part_id = known_part(cell)
        status, result = goals.send(part_id=part_id, kick_height=KICK, drops=300, seed=3).result()
        assert (status, result.success, result.message) == (SUCCEEDED, True, "")
        expected = simulate_flips(library_part(WEDGE), KICK, 300, seed=3)
        np.testing.assert_array_equal(matrix(result.transition), expected.transition)
        np.testing.assert_array_equal(matrix(result.standard_error), expected.standard_error)
        assert list(result.flips) == [300] * len(expected.poses)
        assert list(result.unsettled) == expected.unsettled.tolist()
        assert (result.part_id, result.part_digest, result.kick_height, result.seed) == (
            part_id, expected.part_digest, KICK, 3)
        assert result.restitution == 0.5

    def test_the_node_s_number_is_shared_out(self, goals, cell):
        _, result = goals.send(part_id=known_part(cell), kick_height=KICK).result()
        poses = len(result.flips)
        assert set(result.flips) == {10_000 // poses} and result.seed > 0

    def test_no_kick_leaves_all_as_it_is(self, goals, cell):
        _, result = goals.send(part_id=known_part(cell), kick_height=0.0, drops=50).result()
        np.testing.assert_array_equal(matrix(result.transition), np.eye(len(result.flips)))

    def test_feedback_rises(self, goals, cell):
        goal = goals.send(part_id=known_part(cell), kick_height=KICK, drops=MANY)
        until(lambda: len(goal.feedback) > 2)
        goal.cancel()
        _, result = goal.result()
        told = goal.feedback
        assert {one.flips_total for one in told} == {MANY * len(result.flips)}
        assert all(b.flips_done > a.flips_done for a, b in pairwise(told))
        assert told[-1].flips_done <= sum(result.flips)


class TestRefusals:
    @pytest.mark.parametrize(("asked", "said"), [
        ({"part_id": "nobody"}, "'nobody'"),
        ({"drops": 10_000_000}, "max_drops"),
        ({"kick_height": -1.0}, "flip_height is 0"),
        ({"kick_height": math.nan}, "a kick_height in metres"),
    ])
    def test_aborted_with_the_reason(self, goals, cell, asked, said):
        asked = {"part_id": known_part(cell), "kick_height": KICK, **asked}
        status, result = goals.send(**asked).result()
        assert (status, result.success, list(result.flips)) == (ABORTED, False, [])
        assert said in result.message and "\n" not in result.message

    def test_a_full_queue(self, goals, cell):
        part_id = known_part(cell)
        first = goals.send(part_id=part_id, kick_height=KICK, drops=MANY, seed=1)
        first.first_feedback()
        waiting = [goals.send(part_id=part_id, kick_height=KICK, drops=MANY, seed=seed)
                   for seed in range(2, 18)]
        status, result = goals.send(part_id=part_id, kick_height=KICK, seed=99).result()
        assert status == ABORTED and "max_queued_jobs" in result.message
        for goal in (*reversed(waiting), first):
            goal.cancel()
            assert goal.result()[0] == CANCELED


class TestEnds:
    def test_cancelled_has_what_was_done(self, goals, cell):
        goal = goals.send(part_id=known_part(cell), kick_height=KICK, drops=MANY, seed=5)
        goal.first_feedback()
        assert goal.cancel().return_code == CancelGoal.Response.ERROR_NONE
        status, result = goal.result()
        assert (status, result.success) == (CANCELED, False)
        assert "cancelled" in result.message
        # Flips go out of all poses in turn.
        assert max(result.flips) > 0 and np.ptp(np.array(result.flips, dtype=int)) <= 1
        np.testing.assert_allclose(matrix(result.transition).sum(axis=1), 1.0, rtol=1e-12)

    def test_the_node_s_time_is_kept(self, node_of, client_of):
        node_of(max_job_seconds=1.0).ready()
        client = client_of()
        goals = Goals(client, "simulate_flips")
        status, result = goals.send(part_id=known_part(client), kick_height=KICK,
                                    drops=MANY).result()
        goals.close()
        assert (status, result.success) == (SUCCEEDED, True)
        assert result.message.startswith("TIME_LIMIT") and 0 < max(result.flips) < MANY

    def test_drops_go_on_beside_it(self, goals, cell):
        part_id = known_part(cell)
        job_id = start(cell, part_id, LONG)
        reached(cell, job_id, RUNNING)
        status, _ = goals.send(part_id=part_id, kick_height=KICK, drops=2000).result()
        before = get(cell, job_id)
        assert status == SUCCEEDED and before.state == RUNNING and before.drops_done > 0

    def test_ends_with_the_node(self, node_of, client_of):
        node = node_of().ready()
        client = client_of()
        goals = Goals(client, "simulate_flips")
        goal = goals.send(part_id=known_part(client), kick_height=KICK, drops=MANY)
        goal.first_feedback()
        node.send(signal.SIGINT)
        status, result = goal.result()
        goals.close()
        assert status == ABORTED and "the node ended" in result.message
        assert max(result.flips) > 0 and node.ended() == 0
