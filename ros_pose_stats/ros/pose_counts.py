"""What cameras count in the cell, on `~/pose_counts`: put on record, and looked at once."""

import math
from collections.abc import Callable

from rclpy.node import Node
from ros_pose_stats_msgs.msg import PoseCounts

from ..errors import RequestError
from ..recording.analysis.decoding import numbering_of
from .messages.camera_messages import counts_of_bytes
from .messages.part_requests import shown
from .parts.known_part import KnownPart
from .recorder import POSE_COUNTS, Recorder
from .refusals import Refusals
from .transport.batches import BatchSubscription

TOPIC = "~/pose_counts"

MOST_PROBLEMS = 60
"""Counts that cannot be compared, of which each is told, in a minute."""

MOST_PARTS = 10**6
"""In one count."""


class CountSubscription:
    """Records each count as it is, and says if it cannot be compared with anything.

    `known`: a known part by its id, or None; `refusals`: told of bytes that are no count; in the
    bag they would be in the way of its readers; `introduce`: puts a part's mesh on record before
    them; `learn`: takes a known part and what was counted of it, where that can be compared, and
    returns false for a message that has come before.
    """

    def __init__(self, node: Node, recorder: Recorder,
                 known: Callable[[str], KnownPart | None], refusals: Refusals,
                 introduce: Callable[[KnownPart], object],
                 learn: Callable[[KnownPart, PoseCounts], bool]) -> None:
        self._log = node.get_logger()
        self._recorder = recorder
        self._known = known
        self._refusals = refusals
        self._introduce = introduce
        self._learn = learn
        self._batches = BatchSubscription(node, PoseCounts, TOPIC, "counts", self._take,
                                          recorder.count_lost, refusals)

    def take_waiting(self) -> None:
        """Record what the middleware still has, at the end of the node."""
        self._batches.take_waiting()

    def _take(self, received: list[bytes]) -> None:
        sound: list[tuple[bytes, PoseCounts]] = []
        for data in received:
            try:
                sound.append((data, counts_of_bytes(data)))
            except RequestError as refusal:
                self._refusals.refuse(TOPIC, str(refusal), "count")
        self.take_counts(sound)

    def take_counts(self, sound: list[tuple[bytes, PoseCounts]]) -> None:
        """Put counts, each serialised and as it is, on record together, and learn from them."""
        with self._recorder.step:
            for data, counts in sound:
                part = self._known(counts.part_id)
                if part is not None:
                    self._introduce(part)
                self._recorder.record(POSE_COUNTS, data)
            for _, counts in sound:
                self.learn_counts(counts)

    def learn_counts(self, counts: PoseCounts, *, again: bool = False) -> None:
        """Learn from counts that are on record, or say why not.

        `again`: whether that was perhaps done before.
        """
        problem, part = count_problem(counts, self._known), self._known(counts.part_id)
        kind = "counts of nothing"
        if not problem and part is not None:
            if self._learn(part, counts) or again:
                return
            stamp, kind = counts.header.stamp, "counts that came before"
            problem = "it came before, and counts once" + ("" if stamp.sec or stamp.nanosec else (
                "; fill in header.stamp, which tells equal counts apart"))
        if self._refusals.floods.count(kind, MOST_PROBLEMS):
            self._log.warning(f"{TOPIC}: recorded, but {problem}")


def count_problem(counts: PoseCounts, known: Callable[[str], KnownPart | None]) -> str:
    """Why a camera's count cannot be compared with anything; empty where it can.

    `known`: a known part by its id, or None.
    """
    if len(counts.index) != len(counts.count):
        return f"it has {len(counts.index)} pose indices and {len(counts.count)} counts"
    part = known(counts.part_id)
    latched = None if part is None else part.shown.latched
    if part is None or latched is None:
        return f"no part {shown(counts.part_id)} is known"
    if counts.part_digest and counts.part_digest != part.digest:
        return f"{shown(counts.part_id)} has another part_digest by now"
    if sum(counts.count) > MOST_PARTS:
        return f"it counts more than {MOST_PARTS} parts"
    if not math.isfinite(counts.drop_height):
        return f"it has the drop_height {counts.drop_height}; a negative one stands for unknown"
    counted, numbered = numbering_of(counts), numbering_of(latched)
    if not counted.agrees(numbered):
        return f"it has {counted}, the results have {numbered}; copy both from PoseStatistics"
    unknown = sorted(set(counts.index) - {pose.index for pose in latched.poses})
    return f"{shown(counts.part_id)} has no pose {unknown[0]}" if unknown else ""
