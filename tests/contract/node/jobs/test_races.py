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

"""Jobs, goals and cancels that meet at bad moments: every job ends, once."""

import signal
from concurrent.futures import ThreadPoolExecutor
from random import Random

import pytest
from action_msgs.msg import GoalStatus
from ros_pose_stats_msgs.msg import JobStatus

from ..harness.client import CANCELLED, DONE, until, wait_for
from ..harness.goals import Goals
from ..harness.jobs import LONG, cancelled, get, known_part, start
from ..harness.listed import UNFINISHED, recorded_of, rows

ENDS = {JobStatus.DONE: DONE, JobStatus.CANCELLED: CANCELLED}


def assert_each_ended_once(client, node, part_id):
    """Every job of a part, as it was accepted, in the bag and to whoever asks."""

    def told():
        ended = {}
        accepted = set()
        for event in recorded_of(node, "job_events", part_id):
            if event.status.state == JobStatus.QUEUED:
                accepted.add(event.status.job_id)
            elif event.status.state in ENDS:
                ended.setdefault(event.status.job_id, []).append(
                    ENDS[event.status.state]
                )
        return ended if accepted == ended.keys() else None

    ended = until(told, "the ends of all jobs in the bag")
    assert ended.keys() == {
        row.job_id for row in rows(client) if row.part_id == part_id
    }
    for job_id, states in ended.items():
        assert states == [get(client, job_id).status.state]
    return ended


@pytest.mark.parametrize("length", [1, LONG])
def test_a_cancel_at_once_after_the_acceptance(cell, shared_node, length):
    """It meets the beginning of the job, or its end."""
    part_id = known_part(cell)
    goals = Goals(cell)
    for seed in range(1, 16):
        goal = goals.send(part_id=part_id, drops=length, seed=seed)
        goal.cancel()
        status, result = goal.result()
        if status == GoalStatus.STATUS_CANCELED:
            assert get(cell, result.job_id).status.state == CANCELLED
        else:
            assert (length, status) == (1, GoalStatus.STATUS_SUCCEEDED), result.message
            assert get(cell, result.job_id).status.state == DONE
    goals.close()
    assert len(assert_each_ended_once(cell, shared_node, part_id)) == 15


def test_random_requests_goals_and_cancels_from_several_clients(tuned, node):
    tuned.set(max_queued_jobs=6)
    part_id = known_part(tuned)
    goals = Goals(tuned)
    futures = []

    def act(chance, mine):
        request = {
            "part_id": part_id,
            "seed": chance.randrange(1, 40),
            "drops": chance.choice((1, 300, 3000, LONG)),
        }
        match chance.choice(("start", "start", "goal", "cancel", "cancel", "list")):
            case "start":
                answer = wait_for(tuned.send("start_drop_simulation", **request))
                assert answer.success or "max_queued_jobs" in answer.message
                mine += [answer.job_id] * answer.success
            case "goal":
                futures.append(goals.send(**request))
                if chance.random() < 0.7:
                    futures[-1].cancel()
            case "cancel" if mine:
                tuned.call("cancel_drop_simulation", job_id=chance.choice(mine))
            case _:
                rows(tuned)

    def work(seed):
        chance = Random(seed)
        mine = []
        for _ in range(50):
            act(chance, mine)

    with ThreadPoolExecutor(3) as pool:
        list(pool.map(work, range(3)))
    for row in reversed(rows(tuned)):
        if row.state in UNFINISHED:
            tuned.call("cancel_drop_simulation", job_id=row.job_id)
    statuses = {goal.result()[0] for goal in futures}
    assert GoalStatus.STATUS_CANCELED in statuses and statuses <= {
        GoalStatus.STATUS_CANCELED,
        GoalStatus.STATUS_SUCCEEDED,
        GoalStatus.STATUS_ABORTED,
    }
    goals.close()
    until(lambda: all(row.state not in UNFINISHED for row in rows(tuned)))
    assert len(assert_each_ended_once(tuned, node, part_id)) > 20


def test_flips_end_with_the_node(node_of, client_of):
    """Whoever waits for them is told, however many signals come.

    A handler must not wait for a lock that the wait which it interrupts holds.
    """
    node = node_of().ready()
    client = client_of()
    goals = Goals(client, "simulate_flips")
    part_id = known_part(client)
    goal = goals.send(part_id=part_id, kick_height=0.012, drops=500_000)
    goal.first_feedback()
    for number in 100 * [signal.SIGINT, signal.SIGTERM]:
        node.send(number)
    status, result = goal.result()
    assert status == GoalStatus.STATUS_ABORTED and "the node ended" in result.message
    goals.close()
    assert node.ended() == 0
    node.assert_sound()


@pytest.mark.long
def test_the_newest_thousand_that_have_ended_are_kept(tuned):
    """A long one is not forgotten at its end because many came and went meanwhile."""
    part_id = known_part(tuned)
    long = start(tuned, part_id, LONG)
    jobs = [start(tuned, part_id, 100, seed=seed) for seed in range(1, 11)]
    for job_id in jobs:
        cancelled(tuned, job_id)
    for seed in range(1, 1001):
        jobs.append(start(tuned, part_id, 100, seed=seed))
        tuned.good("cancel_drop_simulation", job_id=jobs[-1])
    job_ids = [row.job_id for row in rows(tuned)]
    assert job_ids == [long, *jobs[-1000:]]
    assert f"'{jobs[0]}'" in tuned.refused("get_drop_simulation", job_id=jobs[0])
    cancelled(tuned, long)
    assert get(tuned, long).status.state == CANCELLED
    assert len(rows(tuned)) == 1000
