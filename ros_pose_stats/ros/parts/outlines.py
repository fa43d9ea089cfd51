"""True outlines of a part in its poses, for those who plan grips: one request after the other."""

from array import array
from collections.abc import Sequence
from concurrent.futures import Future

import numpy as np
from ros_pose_stats_msgs.msg import PoseOutline, PoseStatistics

from ...errors import RequestError
from ...records import Part
from ...resting.outlines import outline_at
from ...resting.poses import resting_poses
from .lanes import Lane, Lanes, Rank
from .part_builder import PartWorker, is_large

MOST_WORK = 500_000
"""Triangles in all outlines of an answer, each with what any outline takes: a second or two."""

OUTLINE = 200  # triangles that take as long as what every outline takes
SECONDS = 20.0  # for the outlines of a large part; machines are shared

# number of corners of each ring, and all corners: float64, metres, x and y one after the other
Outline = tuple[list[int], bytes]


class Outlines(PartWorker):
    """Computes outlines in a lane, those of large parts in a process: they lock Python."""

    def __init__(self, lanes: Lanes) -> None:
        super().__init__()
        self._lanes = lanes

    def begin(self, part: Part, result: PoseStatistics,
              heights: Sequence[float]) -> Future[list[PoseOutline]]:
        """Have outlines computed in each pose of a result, in its order, at each height."""
        wrong = next((height for height in heights if not np.isfinite(height)), None)
        if wrong is not None:
            raise RequestError("heights above the plate in metres", f"{wrong}",
                               "a negative one asks for the outline from above")
        triangles, wanted = len(part.surface_triangles), len(result.poses) * len(heights)
        most = MOST_WORK // (triangles + OUTLINE)
        if wanted > most:
            raise RequestError(
                f"at most {most} outlines of {triangles} triangles in an answer",
                f"{wanted} ({len(result.poses)} poses, {len(heights)} heights)",
                "ask for fewer heights at once, or use outline_at of the library")

        def compute() -> list[PoseOutline]:
            asked = (part, [pose.index for pose in result.poses], [float(x) for x in heights],
                     result.cluster_tolerance, int(result.round_sides))
            late = RequestError(f"outlines that take at most {SECONDS:g} s",
                                f"{wanted} of {triangles} triangles",
                                "ask for fewer heights at once")
            outlines = (self.call(SECONDS, late, outlines_of, *asked) if is_large(part)
                        else outlines_of(*asked))
            places = [(pose.pose_id, float(x)) for pose in result.poses for x in heights]
            return [PoseOutline(pose_id=pose_id, height=height, corners=array("I", corners),
                                points=array("d", points))
                    for (pose_id, height), (corners, points) in zip(places, outlines, strict=True)]

        return self._lanes.put(compute, Rank.KNOWN, Lane.OUTLINE)


def outlines_of(part: Part, poses: list[int], heights: list[float], tolerance: float,
                sides: int) -> list[Outline]:
    """Outlines in each pose, by its index, at each height."""
    outlines, resting = [], resting_poses(part, tolerance, sides).poses
    for index in poses:
        for height in heights:
            polygons = outline_at(part, resting[index], None if height < 0.0 else height)
            rings = [ring for polygon in polygons for ring in polygon]
            points = np.concatenate([ring.ravel() for ring in rings]) if rings else np.empty(0)
            outlines.append(([len(ring) for ring in rings], points.astype(np.float64).tobytes()))
    return outlines
