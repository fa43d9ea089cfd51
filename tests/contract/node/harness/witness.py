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

"""Clients that keep the node busy and remember what it told them."""

import random
import threading

from rclpy.action import ActionClient
from ros_pose_stats_msgs.action import SimulateDrops
from ros_pose_stats_msgs.msg import JobStatus

from .bags import message_of, on_topic, values_of
from .client import DONE, until
from .parts import WEDGE, flat, whole

NAMES = [f"part_{letter}" for letter in "abcd"]
GLANCE = 0.002


class Told:
    """What clients have been told; everything in it must outlive the node."""

    def __init__(self):
        self.answers = []
        self.accepted = set()
        self.ends = {}

    def answer(self, statistics):
        """A result in full."""
        assert not any(
            warning.code == "NOT_RECORDED" for warning in statistics.warnings
        )
        self.answers.append(whole(statistics))

    def end(self, job_id, state, statistics):
        """The end of a job."""
        self.ends[job_id] = state
        if statistics.job_id:
            self.answer(statistics)

    def assert_in(self, recorded):
        """It is all in what was recorded, given as (topic, message bytes)."""
        answers = {
            values_of(topic, data)
            for topic, data in recorded
            if topic == on_topic("answers")
        }
        assert set(self.answers) <= answers
        recorded_events = events(recorded)
        assert self.accepted <= recorded_events.keys()
        for job_id, state in self.ends.items():
            assert state in recorded_events[job_id], (
                job_id,
                state,
                recorded_events[job_id],
            )


def events(recorded):
    """States of each job by its events, in order."""
    events_by_job = {}
    for topic, data in recorded:
        if topic == on_topic("job_events"):
            event = message_of(topic, data)
            status = event.status
            events_by_job.setdefault(status.job_id, []).append(status.state)
    events_by_job.pop("", None)
    return events_by_job


def unfinished(events_by_job):
    """Jobs that were accepted and have no end."""
    ended = {JobStatus.DONE, JobStatus.CANCELLED, JobStatus.FAILED}
    return {job_id for job_id, kinds in events_by_job.items() if not ended & set(kinds)}


class Witness:
    """Three threads of requests, until the node dies; the client is closed at the
    end.
    """

    def __init__(self, client, expectations, seed):
        self._client = client
        self._told = expectations
        self._over = threading.Event()
        self._actions = ActionClient(
            client.node, SimulateDrops, f"{client.prefix}/simulate_drops"
        )
        until(self._actions.server_is_ready, "the action")
        for name in (
            "estimate",
            "start_drop_simulation",
            "get_drop_simulation",
            "cancel_drop_simulation",
        ):
            client.service(name)
        self._failures = []
        self._threads = [
            threading.Thread(
                target=self._go, args=(act, random.Random(f"{seed} {position}"))
            )
            for position, act in enumerate(
                (self._estimate, self._simulate, self._follow_goal)
            )
        ]
        for thread in self._threads:
            thread.start()

    def stop(self):
        """No answer comes any more."""
        self._over.set()
        for thread in self._threads:
            thread.join()
        # In this order: the executor would have the action in hand, and without its
        # node it has crashed once.
        self._client.stop_spinning()
        self._actions.destroy()
        self._client.close()
        assert not self._failures, self._failures

    def _go(self, act, chance):
        try:
            while not self._over.is_set():
                act(chance)
        except Exception as error:  # of a thread: the test tells
            self._failures.append(error)

    def _wait(self, future):
        """The answer, or None if the node is dead."""
        while not future.done():
            if self._over.wait(GLANCE):
                return None
        return future.result()

    def _ask(self, service, **fields):
        return self._wait(self._client.send(service, **fields))

    def _part(self, chance):
        scale = chance.choice((1.0, chance.uniform(0.5, 2.0)))
        return flat((scale * WEDGE[0], WEDGE[1]), chance.choice(NAMES))

    def _estimate(self, chance):
        answer = self._ask(
            "estimate",
            part=self._part(chance),
            method=chance.choice(("", "csae", "area")),
        )
        if answer is not None:
            assert answer.success, answer.message
            self._told.answer(answer.statistics)

    def _simulate(self, chance):
        drops = chance.choice((30, 300, 3000, 5_000_000))
        answer = self._ask(
            "start_drop_simulation", part=self._part(chance), drops=drops
        )
        if answer is None:
            return
        assert answer.success, answer.message
        self._told.accepted.add(answer.job_id)
        if drops > 3000 or chance.random() < 0.3:
            self._over.wait(0.1 * chance.random())
            self._ask("cancel_drop_simulation", job_id=answer.job_id)
        while (
            job := self._ask("get_drop_simulation", job_id=answer.job_id)
        ) is not None:
            if job.status.state >= DONE:
                self._told.end(answer.job_id, job.status.state, job.statistics)
                return

    def _follow_goal(self, chance):
        goal = SimulateDrops.Goal(
            part=self._part(chance),
            drops=chance.choice((20, 200, 10**6)),
            max_seconds=0.2 * chance.random() + 0.01,
        )
        # In the executor's thread, where no answer can overtake its question.
        run = self._client.run
        handle = self._wait(run(lambda: self._actions.send_goal_async(goal)))
        answer = None if handle is None else self._wait(run(handle.get_result_async))
        if answer is not None:
            self._told.accepted.add(answer.result.job_id)
            state = JobStatus.DONE if answer.result.success else JobStatus.CANCELLED
            self._told.end(answer.result.job_id, state, answer.result.statistics)
