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

"""One life of a node: its process, a client, and lanes of calls that go on side by
side.
"""

import itertools
import os
import random
import threading
import time
from pathlib import Path

from rclpy.action import ActionClient
from ros_pose_stats_msgs.action import SimulateDrops
from ros_pose_stats_msgs.msg import PartMesh, PoseCounts
from rosbags.highlevel import AnyReader
from shape_msgs.msg import Mesh

from tests.contract.node.harness.bags import bags_of, files_of, on_topic, raw
from tests.contract.node.harness.client import CANCELLED, DONE, FAILED, SERVICES, until
from tests.contract.node.harness.node import NodeProcess
from tests.contract.node.harness.transports import LOOPBACK
from tests.contract.node.harness.witness import events, unfinished

from ..cell import Client, domain, status

PREFIX = "/soak/pose_stats"
PATIENCE = 120.0
"""Seconds after which an answer counts as missing."""

ON_ITS_WAY = 0.03
"""Seconds that an answer may still take after the node has died."""

TOPICS = {
    "part_mesh": (PartMesh, f"{PREFIX}/part_mesh"),
    "cad": (Mesh, "/soak/cad"),
    "pose_counts": (PoseCounts, f"{PREFIX}/pose_counts"),
}
CLOCK = str(Path(__file__).with_name("clock"))


class Over(Exception):  # noqa: N818 - no error: it ends a lane
    """The life is over."""


def node_of(bags, clock=None, **values):
    """The node with small bags, so that they are often followed by others."""
    environment = {**LOOPBACK, "ROS_DOMAIN_ID": str(domain())}
    if clock is not None:
        path = os.pathsep.join(filter(None, (CLOCK, os.environ.get("PYTHONPATH"))))
        environment |= {"PYTHONPATH": path, "TRIAL_CLOCK": str(clock)}
    values = {
        "workers": 1,
        "max_bag_bytes": 2**20,
        "max_parts": 40,
        "refine_drops": 200,
        "mesh_topics": "[/soak/cad]",
        **values,
    }
    return NodeProcess(bags, "-r", "__ns:=/soak", environment=environment, **values)


class Life:
    """A node that is ready, and lanes of calls, each in a thread, until it ends or is
    killed.

    Parameters
    ----------
    node : NodeProcess
        Not ready yet; what the last life left is looked at once it is.
    told : Told
    seed : int
    look_back : bool
        Whether the bags are as the last life left them, so that they are looked at.
    """

    def __init__(self, node, answers, seed, look_back=True):
        self.node = node
        self.told = answers
        self.over = threading.Event()
        self._calls = itertools.count(1)
        self.calls = 0
        self._seed = seed
        self._threads = []
        self._left = bags_of(node.log_directory)
        earlier_bags = [
            (topic, data)
            for bag in self._left
            for topic, data in raw(bag)
            if topic == on_topic("job_events")
        ]
        self.client = Client(domain(), PREFIX)
        self.action = ActionClient(
            self.client.node, SimulateDrops, f"{PREFIX}/simulate_drops"
        )
        self._publishers = {
            name: self.client.node.create_publisher(*at, 10)
            for name, at in TOPICS.items()
        }
        try:
            node.ready()
            until(self.action.server_is_ready, "the action")
            for name in SERVICES:
                self.client.service(name)
            if look_back:
                self._look_back(unfinished(events(earlier_bags)))
        except BaseException:
            self._end_lanes()
            raise

    def _look_back(self, jobs):
        """The last bag has been finished for others too, and jobs without an end
        cancelled.
        """
        for bag in self._left[-1:]:
            if not files_of(bag):
                continue  # killed before its first file
            with AnyReader(
                [bag]
            ) as reader:  # values are not looked at: some counts are fuzzed
                messages_read = sum(1 for _ in reader.messages())
            if messages_read != len(raw(bag)):
                self.told.wrong.append(
                    f"rosbags reads {messages_read} of {len(raw(bag))} messages"
                )
        for job_id in jobs:
            answer = self.client.call("get_drop_simulation", job_id=job_id)
            # The state may have an end that a full disk has kept out of the bag.
            if not answer.success or answer.status.state not in (
                DONE,
                CANCELLED,
                FAILED,
            ):
                self.told.wrong.append(
                    f"{job_id} had no end, and is {answer.status.state} now"
                )
        self.told.events["jobs cancelled by the next start"] += len(jobs)

    def start(self, lanes):
        """Begin with lanes; each gets a random generator of its own."""
        for number, lane in enumerate(lanes):
            chance = random.Random(f"{self._seed} {number}")
            thread = threading.Thread(target=self._go, args=(lane, chance), daemon=True)
            self._threads.append(thread)
            thread.start()

    def _go(self, lane, chance):
        try:
            lane(self, chance)
        except Over:
            return
        except Exception as error:
            self.told.wrong.append(f"{lane.__name__}: {type(error).__name__}: {error}")

    def go_on(self, calls):
        """Wait for so many more calls."""
        goal = self.calls + calls
        end = time.monotonic() + 10.0 * PATIENCE
        while self.calls < goal:
            if time.monotonic() > end or not any(
                thread.is_alive() for thread in self._threads
            ):
                raise TimeoutError(
                    f"{goal - self.calls} of {calls} calls were not answered"
                )
            time.sleep(0.01)

    def ask(self, name, **fields):
        """Call a service and wait for the answer."""
        return self.send(name, self.client.service(name).srv_type.Request(**fields))

    def send(self, name, request):
        """The same with a request."""
        begin = time.perf_counter()
        answer = self.wait(self.client.service(name).call_async(request), name)
        self.told.called(name, time.perf_counter() - begin)
        return answer

    def run(self, work):
        """Do something in the executor's thread, where no answer can overtake it."""
        return self.wait(self.client.executor.create_task(work), "the executor")

    def wait(self, future, name):
        """What comes, unless the life is over."""
        answered = threading.Event()
        end = time.monotonic() + PATIENCE
        future.add_done_callback(lambda _: answered.set())
        while not answered.wait(0.05):
            if self.over.is_set():
                raise Over
            if time.monotonic() > end:
                raise TimeoutError(f"no answer of {name} within {PATIENCE:.0f} s")
        self.calls = next(self._calls)
        return future.result()

    def publish(self, name, data):
        """Publish a message, or a serialised one."""
        self._publishers[name].publish(data)

    def pause(self, seconds):
        """Wait, unless the life is over."""
        if self.over.wait(seconds):
            raise Over

    @property
    def memory(self):
        """Resident bytes of the node."""
        return status(self.node, "VmRSS")

    def end(self, kill):
        """Kill the node while all lanes wait for it, or end the lanes and then the
        node.
        """
        try:
            if kill:
                self.node.kill()
                time.sleep(ON_ITS_WAY)
            self._end_lanes()
            if not kill:
                self.node.stop()
        finally:
            self._end_lanes()
            self.node.kill()

    def _end_lanes(self):
        self.over.set()
        for thread in self._threads:
            thread.join()
        # In this order: the executor would have the action in hand, and without its
        # node it has crashed once.
        if self.action is not None:
            self.client.stop_spinning()
            self.action.destroy()
            self.client.close()
            self.action = None
