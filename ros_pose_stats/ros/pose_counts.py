"""What cameras count in the cell, on `~/pose_counts`: put on record, and looked at once."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import PoseCounts

from ..errors import RequestError
from ..recording.analysis.numbering import numbering_of
from .diagnostics import Refusals
from .floods import MINUTE
from .parts.part_requests import shown
from .parts.part_store import KnownPart
from .recorder import POSE_COUNTS, Recorder
from .transport.overruns import SequenceGaps

TOPIC = "~/pose_counts"

DEPTH = 1000
"""Counts that wait in the middleware."""

MOST_BYTES = 2**20
"""Of a camera's count: some 80 000 poses."""

MOST_AT_ONCE = 2**22
"""Bytes of counts that are recorded with one sync."""

OVERHEAD = 1000
"""Bytes that a count is taken to occupy beside its own, decoded and on its way."""

MOST_PROBLEMS = 60
"""Counts that cannot be compared, of which each is told, in a minute."""

MOST_PARTS = 10**12
"""In one count."""

Received = tuple[bytes, Mapping[str, int]]


class CountSubscription:
    """Records each count as it is, and says if it cannot be compared with anything.

    All that wait go to the disk with one sync: while that lasts, more come. Those that came too
    quickly all the same are told by the numbers that are missing.

    Parameters
    ----------
    node : Node
    recorder : Recorder
    known : callable
        A known part by its id, or None.
    refusals : Refusals
        Told of bytes that are no count; in the bag they would be in the way of its readers.
    learn : callable
        Takes a known part and what was counted of it, where that can be compared.
    """

    def __init__(self, node: Node, recorder: Recorder,
                 known: Callable[[str], KnownPart | None], refusals: Refusals,
                 learn: Callable[[KnownPart, PoseCounts], object]) -> None:
        self._log = node.get_logger()
        self._recorder = recorder
        self._known = known
        self._refusals = refusals
        self._learn = learn
        self._gaps = SequenceGaps()
        self._lost_told = -math.inf
        self._lock = threading.Lock()
        self._subscription = node.create_subscription(
            PoseCounts, TOPIC, self._on_counts, DEPTH, raw=True,
            callback_group=MutuallyExclusiveCallbackGroup())

    def take_waiting(self) -> None:
        """Record what the middleware still has, at the end of the node."""
        with self._lock:
            while waiting := self._take(0):
                self._record(waiting)

    def _on_counts(self, data: bytes, info: Mapping[str, int]) -> None:
        with self._lock:
            self._record([(data, info), *self._take(len(data))])

    def _take(self, size: int) -> list[Received]:
        """What waits in the middleware, up to so many bytes that can be held at once."""
        found: list[Received] = []
        handle = self._subscription.handle
        with handle:
            while size < MOST_AT_ONCE:
                received = handle.take_message(PoseCounts, True)
                if received is None:
                    break
                found.append(received)
                size += len(received[0]) + OVERHEAD
        return found

    def _record(self, received: list[Received]) -> None:
        """Put counts on record, together."""
        sound: list[tuple[bytes, PoseCounts]] = []
        for data, info in received:
            self._count_lost(self._gaps.missing_before(info["publication_sequence_number"] or 0))
            self._refusals.floods.count(f"counts on {TOPIC}")
            try:
                sound.append((data, counts_of_bytes(data)))
            except RequestError as refusal:
                self._refusals.refuse(TOPIC, str(refusal), "count")
        for place, (data, _) in enumerate(sound, start=1):
            self._recorder.record(POSE_COUNTS, data, durable=place == len(sound))
        for _, counts in sound:
            problem = count_problem(counts, self._known)
            part = self._known(counts.part_id)
            if not problem and part is not None:
                self._learn(part, counts)
            elif self._refusals.floods.count("counts of nothing", MOST_PROBLEMS):
                self._log.warning(f"{TOPIC}: recorded, but {problem}")

    def _count_lost(self, lost: int) -> None:
        self._recorder.counts_lost += lost
        if lost and time.monotonic() - self._lost_told > MINUTE:
            self._lost_told = time.monotonic()
            self._log.warning(f"{TOPIC}: {self._recorder.counts_lost} counts lost so far: they "
                              "come faster than they can be recorded")


def counts_of_bytes(data: bytes) -> PoseCounts:
    """What a camera counted.

    Raises
    ------
    RequestError
        If the bytes are no `PoseCounts`, or more than any part could have.
    """
    if len(data) > MOST_BYTES:
        raise RequestError(f"a PoseCounts of at most {MOST_BYTES} bytes", f"{len(data)} bytes",
                           "check the publisher")
    try:
        return deserialize_message(data, PoseCounts)
    except Exception as error:  # the bindings raise what they like
        raise RequestError("a serialised PoseCounts", f"{len(data)} bytes that are none "
                           f"({type(error).__name__})", "check the publisher") from error


def count_problem(counts: PoseCounts, known: Callable[[str], KnownPart | None]) -> str:
    """Why a camera's count cannot be compared with anything; empty where it can.

    Parameters
    ----------
    counts : PoseCounts
    known : callable
        A known part by its id, or None.
    """
    if len(counts.index) != len(counts.count):
        return f"it has {len(counts.index)} pose indices and {len(counts.count)} counts"
    part = known(counts.part_id)
    if part is None or part.latched is None:
        return f"no part {shown(counts.part_id)} is known"
    if counts.part_digest and counts.part_digest != part.part.digest:
        return f"{shown(counts.part_id)} has another part_digest by now"
    if sum(counts.count) > MOST_PARTS:
        return f"it counts more than {MOST_PARTS} parts"
    latched = part.latched
    counted, numbered = numbering_of(counts), numbering_of(latched)
    if not counted.agrees(numbered):
        return f"it has {counted}, the results have {numbered}; copy both from PoseStatistics"
    unknown = sorted(set(counts.index) - {pose.index for pose in latched.poses})
    return f"{shown(counts.part_id)} has no pose {unknown[0]}" if unknown else ""
