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

"""The list of all parts on `~/parts`: a subscriber of depth 1 misses none."""

import math
import threading
import time
from collections.abc import Callable

from ros_pose_stats_msgs.msg import PartList, PartState

from ..equipment import Equipment
from ..messages import times
from .channel import LATCHED, NO_EVENTS
from .known_part import KnownPart

SECONDS_BETWEEN = 1.0  # lists, of what comes in a batch


class PartListing:
    """Lists what is latched: at once after a pause, else within a second.

    `shown_parts` gives the parts with a latched result. Who changes one may hold its
    lock; who lists them takes no part's lock.
    """

    def __init__(
        self, equipment: Equipment, shown_parts: Callable[[], list[KnownPart]]
    ) -> None:
        self._settings = equipment.settings
        self._shown_parts = shown_parts
        self._publisher = equipment.node.create_publisher(
            PartList, "~/parts", LATCHED, event_callbacks=NO_EVENTS
        )
        self._lock = threading.Lock()  # so that no older list comes last
        self._is_outdated = True
        # By the monotonic clock; nothing is listed before what a start latches again.
        self._listed_at = math.inf

    def start(self) -> None:
        """List what an earlier run has latched, all at once, or that there is none."""
        with self._lock:
            self._publish()

    def note_change(self) -> None:
        """List what has changed, unless there was a list just now."""
        with self._lock:
            self._is_outdated = True
            if time.monotonic() - self._listed_at >= SECONDS_BETWEEN:
                self._publish()

    def catch_up(self) -> None:
        """List what has changed since the last list, if anything has."""
        with self._lock:
            if self._is_outdated and self._listed_at < math.inf:
                self._publish()

    def _publish(self) -> None:
        self._is_outdated = False
        self._listed_at = time.monotonic()
        message = PartList()
        message.header.stamp = times.time_message(times.current_stamp())
        message.header.frame_id = self._settings().plate_frame
        for part in self._shown_parts():
            latched = part.latched
            if latched is not None:
                result = latched.message
                message.parts.append(
                    PartState(
                        part_id=result.part_id,
                        part_digest=result.part_digest,
                        revision=result.revision,
                        method=result.method,
                        expected_error=result.expected_error,
                        final=result.final,
                    )
                )
        self._publisher.publish(message)
