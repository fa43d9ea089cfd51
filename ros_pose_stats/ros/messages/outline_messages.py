"""True outlines of a part in its poses as messages, for those who plan grips."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

import numpy as np
from ros_pose_stats_msgs.msg import PoseOutline, PoseStatistics

from ...errors import RequestError
from ...records import Part
from ...resting.outlines import Polygon, outline_at
from ...resting.poses import resting_poses

MOST_TRIANGLES = 500_000
"""Triangles of the part times its outlines in one answer: about a second."""


def outline_messages(part: Part, found: PoseStatistics,
                     heights: Sequence[float]) -> list[PoseOutline]:
    """Outlines in each pose of a result, in its order, at each height.

    `found`: the message, whose poses are meant; `heights`: above the plate, metres; negative: as
    seen from above. Raises RequestError if a height is no finite number, or there would be too
    many.
    """
    wrong = next((height for height in heights if not np.isfinite(height)), None)
    if wrong is not None:
        raise RequestError("heights above the plate in metres", f"{wrong}",
                           "a negative one asks for the outline from above")
    triangles, wanted = len(part.surface_triangles), len(found.poses) * len(heights)
    if triangles * wanted > MOST_TRIANGLES:
        raise RequestError(
            f"at most {MOST_TRIANGLES} triangles in all outlines of an answer",
            f"{wanted} outlines ({len(found.poses)} poses, {len(heights)} heights) of "
            f"{triangles} triangles",
            "ask for fewer heights at once, or use outline_at of the library")
    poses = resting_poses(part, found.cluster_tolerance, found.round_sides).poses
    return [_message(one.pose_id, float(height), outline_at(
                part, poses[one.index], None if height < 0.0 else float(height)))
            for one in found.poses for height in heights]


def _message(pose_id: str, height: float, polygons: Sequence[Polygon]) -> PoseOutline:
    rings = [ring for polygon in polygons for ring in polygon]
    points = np.concatenate([ring.ravel() for ring in rings]) if rings else np.empty(0)
    return PoseOutline(pose_id=pose_id, height=height,
                       corners=array("I", [len(ring) for ring in rings]),
                       points=array("d", points.astype(np.float64).tobytes()))
