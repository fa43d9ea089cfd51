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

"""What is refused, what comes too often, and what diagnostics say of the health."""

import bisect
import platform
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from .messages.codes import describe_error
from .messages.times import current_stamp, steady_timer, time_message

MINUTE = 60.0
MOST_MESSAGES = 600  # of one topic in a minute; ten a second
MOST_SWAPS = 60  # meshes that take each other's place as one part in a minute
MOST_SOURCES = 1000  # that are counted in one minute


class Floods:
    """Counts what comes from each source, and logs once a minute what floods."""

    def __init__(self, say: Callable[[str], object]) -> None:
        self._log = say
        self._lock = threading.Lock()
        self._began = time.monotonic()
        self._counts = Counter[str]()  # of this minute
        self._floods = Counter[str]()  # those that are more than usual
        self._previous_floods = Counter[str]()  # what flooded in the minute before

    def count(self, source: str, limit: int = MOST_MESSAGES) -> bool:
        """Count one more; whether that is within what is usual in a minute."""
        with self._lock:
            self._begin_minute()
            if source not in self._counts and len(self._counts) >= MOST_SOURCES:
                return True
            self._counts[source] = count = self._counts[source] + 1
            if count > limit:
                if source not in self._floods and source not in self._previous_floods:
                    self._log(f"a flood: more than {limit} of {source} within a minute")
                self._floods[source] = count
        return count <= limit

    def current(self) -> dict[str, int]:
        """How many came of each source that floods, in the last minute or this one."""
        with self._lock:
            self._begin_minute()
            return self._previous_floods | self._floods  # the larger number of each

    def _begin_minute(self) -> None:
        """Begin another minute where one is over, and say what came in that one."""
        passed = time.monotonic() - self._began
        if passed >= MINUTE:
            self._began += passed
            self._previous_floods = self._floods
            self._floods = Counter()
            self._counts = Counter()
            for source, count in self._previous_floods.items():
                self._log(f"a flood: {count} of {source} in the last minute")


MOST_PUBLISHERS = 64


class SequenceGaps:
    """Counts what is missing between the numbers that publishers of a topic give.

    The middleware tells of no sample that a newer one pushed out, nor which publisher
    one is from: it is taken to follow the nearest lower number that has arrived.
    """

    def __init__(self) -> None:
        self._last_numbers: list[int] = []

    def missing_before(self, info: Mapping[str, int]) -> int:
        """Messages lost just before this one, if its publisher numbers them."""
        number = info["publication_sequence_number"] or 0
        if number <= 0:
            return 0
        index = bisect.bisect_left(self._last_numbers, number) - 1
        missing = 0 if index < 0 else number - self._last_numbers.pop(index) - 1
        bisect.insort(self._last_numbers, number)
        if len(self._last_numbers) > MOST_PUBLISHERS:
            del self._last_numbers[0]
        return missing


MESHES = "meshes"
COUNTS = "counts"  # that may be lost
REMEMBERED = 20  # refused meshes listed with their reasons
# In which both copies of a latched mesh, or equal requests, count once.
COPY_SECONDS = 2.0
RECENT_SECONDS = 60.0  # a refused mesh is a warning for this long


class Health(NamedTuple):
    """One line of diagnostics: whether it is a warning, its text, values by key."""

    warn: bool
    text: str
    values: dict[str, Any]


class _Refusal(NamedTuple):
    time: float  # by the clock that never jumps
    stamp: int
    source: str
    reason: str


class Refusals:
    """Meshes and counts that were refused, meshes that were lost, and floods."""

    def __init__(self, say: Callable[[str], object]) -> None:
        self._log = say
        self.floods = Floods(say)
        self._recent: deque[_Refusal] = deque(maxlen=REMEMBERED)
        self._lock = threading.Lock()
        self.refused = 0
        self.lost = Counter[str]()

    def refuse(self, source: str, reason: str, kind: str = "mesh") -> None:
        """Count and tell a refusal, unless it is a copy of one just before."""
        with self._lock:
            at = time.monotonic()
            if any(
                (last.source, last.reason) == (source, reason)
                and at - last.time < COPY_SECONDS
                for last in self._recent
            ):
                return
            self.refused += 1
            self._recent.append(_Refusal(at, current_stamp(), source, reason))
        if self.floods.count("refusals"):
            self._log(f"{source}: {kind} refused: {reason}")

    def watch_mesh(self, source: str, mesh: Future[Any]) -> None:
        """Have a mesh that turns out to be bad counted as refused, with its source."""

        def look(future: Future[Any]) -> None:
            error = None if future.cancelled() else future.exception()
            if error is not None:
                self.refuse(source, describe_error(error))

        mesh.add_done_callback(look)

    def count_lost(self, kind: str, count: int) -> int:
        """Count messages of a kind that a flood overran; how many that are by now."""
        with self._lock:
            self.lost[kind] += count
            return self.lost[kind]

    def health(self, parts: int, waiting: int) -> Health:
        """The line about meshes."""
        with self._lock:
            recent = list(self._recent)
            refused = self.refused
            overrun = self.lost[MESHES]
        is_recent = bool(recent) and time.monotonic() - recent[-1].time < RECENT_SECONDS
        floods = "; ".join(
            f"{count} of {source} within a minute"
            for source, count in self.floods.current().items()
        )
        text = f"{parts} parts"
        if is_recent:
            text = f"refused: {recent[-1].source}: {recent[-1].reason}"
        elif floods:
            text = f"a flood: {floods}"
        values: dict[str, Any] = {
            "parts": parts,
            "meshes waiting": waiting,
            "refused": refused,
            "overrun": overrun,
            "floods": floods or "none",
        }
        for index, refusal in enumerate(reversed(recent)):
            values[f"refused {index}"] = (
                f"{refusal.stamp / 1e9:.3f} {refusal.source}: {refusal.reason}"
            )
        return Health(is_recent or bool(floods), text, values)


HOST = platform.node()


def publish_diagnostics(node: Node, lines: Mapping[str, Callable[[], Health]]) -> None:
    """Publish all lines, each with what it is about, once a second."""
    name = node.get_fully_qualified_name()[1:]
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def publish() -> None:
        message = DiagnosticArray()
        for subject, look in lines.items():
            health = look()
            message.status.append(
                DiagnosticStatus(
                    level=DiagnosticStatus.WARN if health.warn else DiagnosticStatus.OK,
                    name=f"{name}: {subject}",
                    message=health.text,
                    hardware_id=HOST,
                    values=[
                        KeyValue(key=key, value=str(value))
                        for key, value in health.values.items()
                    ],
                )
            )
        message.header.stamp = time_message(current_stamp())
        publisher.publish(message)

    steady_timer(node, 1.0, publish)
