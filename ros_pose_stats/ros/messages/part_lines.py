"""Lines of the log about parts and counts; pure functions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import PoseCounts

from ...errors import RequestError
from ...records import Part
from ..parts.catalogue import KnownPart
from ..parts.part_requests import LONGEST_NAME, shown

MOST_BYTES = 2**20
"""Of a camera's count: some 80 000 poses."""


def part_line(part: Part, latched: Any) -> str:
    """What has come: name, size, triangles, poses."""
    size = " x ".join(f"{1e3 * x:.4g}" for x in np.ptp(part.surface_vertices, axis=0))
    poses = "" if latched is None else f", {len(latched.poses)} stable poses"
    return f"{part.part_id}: {size} mm, {len(part.triangles)} triangles{poses}"


def named(part_id: str) -> str:
    """A part in a line of the log; empty where its name could spoil the line."""
    fit = 0 < len(part_id) <= LONGEST_NAME and part_id.isprintable()
    return f", part '{part_id}'" if fit else ""


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
    if counts.cluster_tolerance != latched.cluster_tolerance:
        return (f"its cluster_tolerance is {counts.cluster_tolerance:g}, that of the results "
                f"{latched.cluster_tolerance:g}; copy it from PoseStatistics")
    unknown = sorted(set(counts.index) - {pose.index for pose in latched.poses})
    return f"{shown(counts.part_id)} has no pose {unknown[0]}" if unknown else ""
