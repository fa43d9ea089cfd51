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

"""A node in a namespace of its own, its publishers and what it says of its health."""

import threading
from contextlib import contextmanager

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_pose_stats_msgs.msg import ObservedParts, PartMesh, PoseCounts

from .client import Client, until
from .node import PATIENCE, NodeProcess


@contextmanager
def cell_of(domain, log_directory, namespace, *arguments, **values):
    """A node that is ready, and a client of it."""
    with (
        Client(domain, f"/{namespace}/pose_stats") as client,
        NodeProcess(
            log_directory, "-r", f"__ns:=/{namespace}", *arguments, **values
        ) as node,
    ):
        node.ready()
        yield node, client


class MeshPublisher:
    """Publishes meshes, or what else a cell tells the node of a client."""

    def __init__(self, client, topic="", kind=PartMesh, *, latched=False):
        durability = (
            DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        )
        quality = QoSProfile(
            depth=1000, reliability=ReliabilityPolicy.RELIABLE, durability=durability
        )
        self._client = client
        self._publisher = client.node.create_publisher(
            kind, topic or f"{client.prefix}/part_mesh", quality
        )
        # What cameras send, the node hears reliably and with best effort; meshes, as
        # they come and as they are latched.
        is_heard_twice = latched or kind in (PoseCounts, ObservedParts)
        self._takers = 2 if is_heard_twice else 1

    def matched(self, parts=1):
        """Wait until the node listens, for each of several parts of a topic."""
        takers = parts * self._takers
        until(
            lambda: self._publisher.get_subscription_count() >= takers,
            f"{takers} subscriptions of the node",
        )
        return self

    def publish(self, *messages):
        """Publish messages, or serialised ones."""
        for message in messages:
            self._publisher.publish(message)
        return self

    def acknowledged(self):
        """Wait until the node's side has received all of them."""
        assert self._publisher.wait_for_all_acked(Duration(seconds=int(PATIENCE)))


def publishers_of_parts(client):
    """How many publish results, beside the one that is there from the start."""
    topic = f"{client.prefix}/pose_statistics"
    return len(client.node.get_publishers_info_by_topic(topic)) - 1


def latched(client, part_id):
    """What is latched for a part, once there is something."""

    def found():
        answer = client.call("get_statistics", part_id=part_id)
        return answer.statistics

    return until(found, f"a result of {part_id}")[0]


class Health:
    """What a client hears on /diagnostics of the node that it belongs to."""

    def __init__(self, client):
        self._name = f"{client.prefix[1:]}: "
        self._news = threading.Condition()
        self._heard = 0
        self._lines = {}
        client.subscribe(DiagnosticArray, "/diagnostics", self._take, depth=10)

    def _take(self, message):
        lines = {
            line.name.removeprefix(self._name): line
            for line in message.status
            if line.name.startswith(self._name)
        }
        with self._news:
            self._heard += bool(lines)
            self._lines.update(lines)

    def line(self, name, condition=lambda line, values: True):
        """A line that was said from now on and fulfils a condition, and its values."""
        heard_before = self._heard + 1  # the next one may be on its way

        def found():
            line = self._lines.get(name)
            if self._heard <= heard_before or line is None:
                return None
            values = {pair.key: pair.value for pair in line.values}
            return (line, values) if condition(line, values) else None

        return until(found, f"diagnostics of {name}; last: {self._lines.get(name)}")

    def latest(self, name):
        """The last line of all and its values."""
        line = self._lines[name]
        return line, {pair.key: pair.value for pair in line.values}

    def eventually(self, name, condition=lambda line, values: True):
        """A line that fulfils a condition, be it the last one or one to come, and its
        values.
        """

        def there():
            reading = self.latest(name) if name in self._lines else None
            return reading if reading and condition(*reading) else None

        return until(there, f"diagnostics of {name}")
