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

"""Goals of the actions as a client follows them."""

import threading

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from ros_pose_stats_msgs.action import PlanFeeding, SimulateDrops, SimulateFlips
from ros_pose_stats_msgs.msg import Code

from .client import until, wait_for
from .node import PATIENCE

ACTIONS = {
    "plan_feeding": PlanFeeding,
    "simulate_drops": SimulateDrops,
    "simulate_flips": SimulateFlips,
}


class Goals:
    """The client of an action of a `Client`."""

    def __init__(self, client, name="simulate_drops"):
        self.client = client
        self._kind = ACTIONS[name]
        self._actions = ActionClient(client.node, self._kind, f"{client.prefix}/{name}")
        assert self._actions.wait_for_server(PATIENCE)
        until(self._answers, f"an answer of {name}")

    def _answers(self):
        """Whether a goal that is refused comes back: the first answers may be lost."""
        heard = threading.Event()
        self.client.run(
            lambda: self._actions.send_goal_async(self._kind.Goal())
        ).add_done_callback(
            lambda accepted: (
                accepted.result()
                .get_result_async()
                .add_done_callback(lambda _: heard.set())
            )
        )
        return heard.wait(5.0)

    def send(self, **fields):
        """Send a goal, which is accepted in any case."""
        return Goal(self.client, self._actions, self._kind.Goal(**fields))

    def close(self):
        self.client.run(self._actions.destroy)  # the executor might have it in hand


class Goal:
    """One goal, its feedback and its result.

    rclpy's action client drops an answer that comes before it has noted the question,
    so all questions are asked in the executor's thread.
    """

    def __init__(self, client, actions, request):
        self._client = client
        self._lock = threading.Lock()
        self._feedback = []
        self.handle = wait_for(
            client.run(
                lambda: actions.send_goal_async(request, feedback_callback=self._take)
            ),
            "acceptance",
        )
        assert self.handle.accepted
        self._result = client.run(self.handle.get_result_async)

    def _take(self, message):
        with self._lock:
            self._feedback.append(message.feedback)

    @property
    def feedback(self):
        with self._lock:
            return list(self._feedback)

    def first_feedback(self):
        return until(lambda: self.feedback, "feedback")[0]

    def cancel(self):
        """Ask for the cancel; the answer."""
        return wait_for(
            self._client.run(self.handle.cancel_goal_async), "an answer to a cancel"
        )

    @property
    def ended(self):
        return self._result.done()

    def result(self):
        """Status and result, once there."""
        answer = wait_for(self._result, "a result")
        return answer.status, answer.result


def plans(client):
    """The client of ~/plan_feeding, which lasts as long as the node's."""
    if client.plans is None:
        client.plans = Goals(client, "plan_feeding")
        client.closing.callback(client.plans.close)
    return client.plans


def planned(client, **fields):
    """A plan that must succeed."""
    status, result = plans(client).send(**fields).result()
    assert result.success, result.message
    assert result.code == Code.OK
    assert status == GoalStatus.STATUS_SUCCEEDED
    return result


def refused_plan(client, **fields):
    """A plan that must be refused, in one line; its message."""
    status, result = plans(client).send(**fields).result()
    assert status == GoalStatus.STATUS_ABORTED and not result.success
    assert result.code not in (Code.OK, Code.INTERNAL)
    assert result.message and "\n" not in result.message
    assert "internal failure" not in result.message
    return result.message
