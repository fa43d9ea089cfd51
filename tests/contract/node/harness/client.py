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

"""A client of the node inside the test's process."""

import threading
import time
from contextlib import ExitStack
from functools import cache

import rclpy
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParameters,
)
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.msg import Code, PoseStatistics

from .node import PATIENCE

SERVICES = {
    "estimate": srv.EstimatePoses,
    "get_statistics": srv.GetStatistics,
    "fit_plate": srv.FitPlate,
    "forget_part": srv.ForgetPart,
    "start_drop_simulation": srv.StartDropSimulation,
    "get_drop_simulation": srv.GetDropSimulation,
    "list_drop_simulations": srv.ListDropSimulations,
    "cancel_drop_simulation": srv.CancelDropSimulation,
    "describe_parameters": DescribeParameters,
    "get_parameters": GetParameters,
    "set_parameters": SetParameters,
    "list_parameters": ListParameters,
}
QUEUED, RUNNING, DONE, CANCELLED, FAILED = range(1, 6)

FIRST_PAUSE = 0.005
LONGEST_PAUSE = 0.08
"""Seconds between two looks: a look may be a request, which costs as many milliseconds
as this begins with.
"""

LASTING_NODES = []


def is_farewell(statistics):
    """Whether a result is the last word about a part: the node has forgotten it."""
    return not statistics.poses and any(
        warning.code == "FORGOTTEN" for warning in statistics.warnings
    )


def until(condition, thing="it"):
    """Poll until `condition()` gives something true, and return that.

    The longer it takes, the more rarely.
    """
    end = time.monotonic() + PATIENCE
    pause = FIRST_PAUSE
    while not (outcome := condition()):
        assert time.monotonic() < end, f"waited in vain for {thing}"
        time.sleep(pause)
        pause = min(1.5 * pause, LONGEST_PAUSE)
    return outcome


def wait_for(future, thing="an answer"):
    """Result of a future that an executor in another thread completes."""
    finished = threading.Event()
    future.add_done_callback(lambda _: finished.set())
    assert finished.wait(PATIENCE), f"waited in vain for {thing}"
    return future.result()


def ask_until_answered(client, request):
    """The answer of a service whose first ones are lost where it has not found the
    client yet.
    """

    def ask():
        future = client.call_async(request)
        heard = threading.Event()
        future.add_done_callback(lambda _: heard.set())
        return heard.wait(5.0) and future.result()

    until(client.service_is_ready, f"service {client.srv_name}")
    return until(ask, f"an answer of {client.srv_name}")


@cache
def context_of(domain, participant):
    """A participant in a domain that clients of this process share until it ends.

    Where one ends, Fast DDS 2.14 writes through broken pointers now and then, or spins
    for ever. It ends with the last node of its context.
    """
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    LASTING_NODES.append(
        rclpy.create_node("_tests", context=context, enable_rosout=False)
    )
    return context


class Client:
    """A ROS node of its own with its executor in a thread; `prefix` is of the node's
    names.
    """

    def __init__(self, domain, prefix="/pose_stats", participant=0):
        self.prefix = prefix
        self.context = context_of(domain, participant)
        self.node = rclpy.create_node("planner", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self._clients = {}
        self.plans = None  # the client of an action, once it is wanted
        self.closing = ExitStack()
        self._open = True
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    def _spin(self):
        while self._open:
            try:
                self.executor.spin_once(timeout_sec=0.5)
            except ExternalShutdownException:
                return
            except InvalidHandle:  # of a subscription that a test has just ended
                continue

    def stop_spinning(self):
        """End the executor's thread, so that nothing that is destroyed is in its
        hands.
        """
        self._open = False
        self.executor.wake()
        self._thread.join()

    def close(self):
        self.closing.close()
        # before all else: spinning in a context that ends meanwhile fails
        self.stop_spinning()
        self.executor.shutdown()
        self.node.destroy_node()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def run(self, work):
        """Do something in the executor's thread, where no answer can overtake it."""
        return wait_for(self.executor.create_task(work), "the executor")

    def service(self, name):
        """The client of a service, as soon as that answers; it may ask many things at
        once.

        By itself rclpy loses all answers but ten.
        """
        if name not in self._clients:
            client = self.node.create_client(
                SERVICES[name],
                f"{self.prefix}/{name}",
                qos_profile=QoSProfile(depth=1000),
            )
            ask_until_answered(client, client.srv_type.Request())  # for nothing
            self._clients[name] = client
        return self._clients[name]

    def send(self, name, **fields):
        """Call a service without waiting."""
        service = self.service(name)
        return service.call_async(service.srv_type.Request(**fields))

    def call(self, name, **fields):
        return wait_for(self.send(name, **fields), f"{name}")

    def good(self, name, **fields):
        """Call a service that must succeed."""
        answer = self.call(name, **fields)
        assert answer.success, answer.message
        return answer

    def refused(self, name, **fields):
        """Call a service that must refuse, in one line; its message."""
        answer = self.call(name, **fields)
        assert not answer.success
        assert answer.code not in (Code.OK, Code.INTERNAL)
        assert answer.message and "\n" not in answer.message
        assert "internal failure" not in answer.message
        return answer.message

    def set(self, **values):
        """Set parameters one by one; the reasons of those that were refused."""
        messages = [
            Parameter(name, value=value).to_parameter_msg()
            for name, value in values.items()
        ]
        results = self.call("set_parameters", parameters=messages).results
        return {
            name: result.reason
            for name, result in zip(values, results, strict=True)
            if not result.successful
        }

    def subscribe(self, kind, topic, take, *, latched=False, depth=300, raw=False):
        durability = (
            DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        )
        quality = QoSProfile(
            depth=depth, reliability=ReliabilityPolicy.RELIABLE, durability=durability
        )
        return self.node.create_subscription(kind, topic, take, quality, raw=raw)

    def late_joiner(self):
        """What a planner that has just started gets on ~/pose_statistics."""
        return Joiner(self)


class Joiner:
    """Collects what is latched for each part, and everything that comes."""

    def __init__(self, client):
        self._client = client
        self._lock = threading.Lock()
        self._all = []
        self._subscription = client.subscribe(
            PoseStatistics, f"{client.prefix}/pose_statistics", self._take, latched=True
        )

    def _take(self, message):
        with self._lock:
            self._all.append(message)

    def of(self, part_id):
        """All that came for a part, in order."""
        with self._lock:
            return [message for message in self._all if message.part_id == part_id]

    def parts(self):
        """Parts with a result; for a moment, the farewell of one just forgotten is
        latched.
        """
        with self._lock:
            newest = {message.part_id: message for message in self._all}
        return {
            part_id for part_id, message in newest.items() if not is_farewell(message)
        }

    def wait(self, part_id, condition=lambda message: True):
        """The first message of a part that fulfils a condition."""
        return until(
            lambda: next(
                (received for received in self.of(part_id) if condition(received)), None
            ),
            f"a result of {part_id}",
        )

    def close(self):
        self._client.node.destroy_subscription(self._subscription)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
