"""Every stable pose drawn with the part resting on the plate; pure functions."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ros_pose_stats_msgs.msg import PoseStatistics, StablePose

from ...recording.writer.markers import (
    DELETE_ALL,
    TEXT_VIEW_FACING,
    TRIANGLE_LIST,
    Marker,
    marker_array_message,
)

Array = NDArray[np.float64]

MOST_POSES = 16
"""Poses drawn of a part, the most probable ones."""

MOST_DRAWN = 400
"""Poses drawn in all; with many parts fewer of each."""

MOST_TRIANGLES = 32_000
"""Of the whole array, with some hundred drawn poses: 2.3 MB, at most once a second."""

FINENESS = (4000, 2000, 1000, 500, 250, 100)
"""Triangles of one drawn part; few steps, so that parts are seldom decimated anew."""

GAP = 0.6
"""Between the parts, in radii."""

LETTER = 0.35
"""Height of the labels, in radii."""


def poses_each(parts: int) -> int:
    """How many poses of each of so many parts are drawn."""
    return max(1, min(MOST_POSES, MOST_DRAWN // max(parts, 1)))


def triangles_each(drawn: int) -> int:
    """How many triangles a drawn pose may have where `drawn` poses are drawn."""
    return next((fine for fine in FINENESS if fine * drawn <= MOST_TRIANGLES), FINENESS[-1])


def marker_array(rows: Sequence[tuple[PoseStatistics, Array]]) -> bytes:
    """Serialised markers, one row a part with its triangles, its poses side by side."""
    markers = [Marker(action=DELETE_ALL)]
    y = 0.0
    for found, triangles in rows:
        y -= found.radius * (1.0 + 0.5 * GAP) if markers[1:] else 0.0
        markers += _row(found, triangles, y, poses_each(len(rows)))
        y -= found.radius * (1.0 + 0.5 * GAP)
    return marker_array_message(markers)


def _row(found: PoseStatistics, triangles: Array, y: float, most: int) -> list[Marker]:
    markers = [_label(found, 0, found.part_id, (-2.0 * found.radius, y, LETTER * found.radius))]
    step = (2.0 + GAP) * found.radius
    for place, pose in enumerate(found.poses[:most]):
        x = place * step
        markers.append(_body(found, pose, triangles, x, y))
        text = f"{pose.index}: {100.0 * pose.probability:.1f} %"
        if math.isnan(pose.probability):
            text = f"{pose.index}: -"
        markers.append(_label(found, pose.index + 1, text,
                              (x, y, pose.top + 0.5 * LETTER * found.radius)))
    return markers


def _body(found: PoseStatistics, pose: StablePose, triangles: Array, x: float,
          y: float) -> Marker:
    where, turn = pose.pose.position, pose.pose.orientation
    return Marker(found.header.frame_id, f"{found.part_id}/poses", TRIANGLE_LIST,
                  (where.x + x, where.y + y, where.z, turn.x, turn.y, turn.z, turn.w),
                  color=_color(pose.probability), corners=triangles, number=pose.index)


def _label(found: PoseStatistics, number: int, text: str,
           where: tuple[float, float, float]) -> Marker:
    return Marker(found.header.frame_id, f"{found.part_id}/labels", TEXT_VIEW_FACING,
                  (*where, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, LETTER * found.radius),
                  (0.1, 0.1, 0.1, 1.0), text=text, number=number)


def _color(probability: Any) -> tuple[float, ...]:
    """From pale to deep blue with the probability."""
    share = 0.0 if math.isnan(probability) else float(min(max(probability, 0.0), 1.0)) ** 0.5
    return (0.85 - 0.75 * share, 0.88 - 0.5 * share, 0.92 - 0.2 * share, 1.0)
