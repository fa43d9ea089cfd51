"""What cameras count in the cell, on `~/pose_counts`: put on record, and looked at once."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import PoseCounts

from ..errors import RequestError
from ..recording.analysis.numbering import numbering_of
from .diagnostics import Refusals
from .parts.mesh_subscriptions import DEPTH
from .parts.part_requests import shown
from .parts.part_store import KnownPart
from .recorder import POSE_COUNTS, Recorder

MOST_BYTES = 2**20
"""Of a camera's count: some 80 000 poses."""


def subscribe_to_counts(node: Node, recorder: Recorder, known: Callable[[str], KnownPart | None],
                        refusals: Refusals) -> None:
    """Record each count as it is, and say if it cannot be compared with anything.

    Parameters
    ----------
    node : Node
    recorder : Recorder
    known : callable
        A known part by its id, or None.
    refusals : Refusals
        Told of bytes that are no count; in the bag they would be in the way of its readers.
    """
    def on_counts(data: bytes) -> None:
        try:
            counts = counts_of_bytes(data)
        except RequestError as refusal:
            refusals.refuse("~/pose_counts", str(refusal), "count")
            return
        recorder.record(POSE_COUNTS, data, durable=True)
        problem = count_problem(counts, known)
        if problem:
            node.get_logger().warning(f"~/pose_counts: recorded, but {problem}")

    node.create_subscription(PoseCounts, "~/pose_counts", on_counts, DEPTH, raw=True,
                             callback_group=MutuallyExclusiveCallbackGroup())


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
    latched = part.latched
    counted, numbered = numbering_of(counts), numbering_of(latched)
    if not counted.agrees(numbered):
        return f"it has {counted}, the results have {numbered}; copy both from PoseStatistics"
    unknown = sorted(set(counts.index) - {pose.index for pose in latched.poses})
    return f"{shown(counts.part_id)} has no pose {unknown[0]}" if unknown else ""
