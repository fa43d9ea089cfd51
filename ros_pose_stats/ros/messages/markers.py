"""Every stable pose drawn with the part resting on the plate; pure functions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import Point
from numpy.typing import NDArray
from ros_pose_stats_msgs.msg import PoseStatistics, StablePose
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from ...records import Part
from ...resting.decimation import decimated_hull

Array = NDArray[np.float64]

MOST_POSES = 16
"""Poses drawn of a part, the most probable ones."""

MOST_DRAWN = 400
"""Poses drawn in all; with many parts fewer of each."""

MOST_TRIANGLES = 6_000
"""Of the whole array: rclpy turns each corner into an object, and services wait meanwhile."""

FINENESS = (120, 60, 30, 12)
"""Triangles of one drawn part; few steps, so that parts are seldom thinned anew."""

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


def corners(part: Part, most: int) -> list[Point]:
    """Corners of the part's hull, three a triangle, part frame, metres."""
    soup = decimated_hull(part, most).reshape(-1, 3)
    return [Point(x=x, y=y, z=z) for x, y, z in soup.tolist()]


def marker_array(rows: Sequence[tuple[PoseStatistics, Sequence[Point]]]) -> MarkerArray:
    """One row a part, its poses side by side, most probable first.

    Parameters
    ----------
    rows : sequence of (PoseStatistics, corners)

    Returns
    -------
    MarkerArray
        Begins by deleting what was drawn before.
    """
    markers = [Marker(action=Marker.DELETEALL)]
    y = 0.0
    for found, soup in rows:
        y -= found.radius * (1.0 + 0.5 * GAP) if markers[1:] else 0.0
        markers += _row(found, soup, y, poses_each(len(rows)))
        y -= found.radius * (1.0 + 0.5 * GAP)
    return MarkerArray(markers=markers)


def _row(found: PoseStatistics, soup: Sequence[Point], y: float, most: int) -> list[Marker]:
    markers = [_label(found, 0, found.part_id, -2.0 * found.radius, y, LETTER * found.radius)]
    step = (2.0 + GAP) * found.radius
    for place, pose in enumerate(found.poses[:most]):
        x = place * step
        markers.append(_body(found, pose, soup, x, y))
        text = f"{pose.index}: {100.0 * pose.probability:.1f} %"
        if math.isnan(pose.probability):
            text = f"{pose.index}: -"
        markers.append(_label(found, pose.index + 1, text, x, y,
                              pose.top + 0.5 * LETTER * found.radius))
    return markers


def _marker(found: PoseStatistics, kind: int, place: str, number: int) -> Marker:
    marker = Marker(ns=f"{found.part_id}/{place}", id=number, type=kind, action=Marker.ADD)
    marker.header.frame_id = found.header.frame_id
    marker.pose.orientation.w = 1.0
    return marker


def _body(found: PoseStatistics, pose: StablePose, soup: Sequence[Point], x: float,
          y: float) -> Marker:
    marker = _marker(found, Marker.TRIANGLE_LIST, "poses", pose.index)
    marker.pose.position.x = pose.pose.position.x + x
    marker.pose.position.y = pose.pose.position.y + y
    marker.pose.position.z = pose.pose.position.z
    marker.pose.orientation = pose.pose.orientation
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    marker.color = _color(pose.probability)
    marker.points = list(soup)
    return marker


def _label(found: PoseStatistics, number: int, text: str, x: float, y: float,
           z: float) -> Marker:
    marker = _marker(found, Marker.TEXT_VIEW_FACING, "labels", number)
    marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = x, y, z
    marker.scale.z = LETTER * found.radius
    marker.color = ColorRGBA(r=0.1, g=0.1, b=0.1, a=1.0)
    marker.text = text
    return marker


def _color(probability: Any) -> ColorRGBA:
    """From pale to deep blue with the probability."""
    share = 0.0 if math.isnan(probability) else float(min(max(probability, 0.0), 1.0)) ** 0.5
    return ColorRGBA(r=0.85 - 0.75 * share, g=0.88 - 0.5 * share, b=0.92 - 0.2 * share, a=1.0)
