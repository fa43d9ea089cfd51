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

"""A name of parts in the node: its lock, its publisher, and revisions of results."""

import math
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from rclpy import event_handler, qos
from rclpy.publisher import Publisher
from ros_pose_stats_msgs.msg import PoseStatistics

from ..equipment import Equipment

P = TypeVar("P")  # a mesh that comes under the name

LATCHED = qos.QoSProfile(
    depth=1,
    reliability=qos.ReliabilityPolicy.RELIABLE,
    durability=qos.DurabilityPolicy.TRANSIENT_LOCAL,
)
NO_EVENTS = event_handler.PublisherEventCallbacks(use_default_callbacks=False)
"""The executor fails on event handlers that are destroyed while it waits for them."""

PARTING_SECONDS = 1.0  # for a subscriber to take a part's last message


class Channel(Generic[P]):
    """Of one name, whichever meshes come under it: its lock, revisions and publisher.

    The lock is held while a result of the name is latched or withdrawn, while counts
    are added, and while a mesh comes or goes. Nobody holds the locks of two channels.
    Who has one may wait for the locks of state, bag and registry, and builds no mesh;
    nobody who has one of these waits for a channel.
    """

    def __init__(self, equipment: Equipment, note_change: Callable[[], object]) -> None:
        self._node = equipment.node
        self._note_change = note_change  # of what is latched
        self.lock = threading.RLock()
        self.newest_revision = 0  # given to a result
        self.latched_revision = 0
        # when a result went on record last, by the monotonic clock; what a start
        # latches again does not
        self.recorded_at = -math.inf
        self.part: P | None = None  # whose result is latched
        self._publisher: Publisher | None = None
        self._farewell_at = -math.inf

    def next_revision(self) -> int:
        """The number of a new result."""
        with self.lock:
            self.newest_revision += 1
            return self.newest_revision

    def publish(self, data: bytes, part: P | None) -> None:
        """Publish a serialised result, latched for a part, or a farewell for none."""
        with self.lock:
            if self._publisher is None:
                self._publisher = self._node.create_publisher(
                    PoseStatistics,
                    "~/pose_statistics",
                    LATCHED,
                    event_callbacks=NO_EVENTS,
                )
            self.part = part
            if part is None:
                self._farewell_at = time.monotonic()
            self._publisher.publish(data)
        self._note_change()

    def close(self) -> bool:
        """Let the publisher go some time after its farewell; true if settled."""
        with self.lock:
            if self.part is not None or self._publisher is None:
                return True
            if time.monotonic() - self._farewell_at <= PARTING_SECONDS:
                return False
            self._node.destroy_publisher(self._publisher)
            self._publisher = None
            return True
