"""True outlines of a part in its poses, for those who plan grips: one request after the other."""

from array import array
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from ros_pose_stats_msgs.msg import PoseOutline, PoseStatistics

from ...batch.worker import ProcessDiedError, TookLongError, Worker
from ...errors import BatchError, PoseStatsError, RequestError
from ...records import Part
from ...resting.outlines import outline_at
from ...resting.poses import resting_poses
from .part_builder import is_large, prepare

MOST_WORK = 500_000
"""Triangles in all outlines of an answer, each with what any outline takes: a second or two."""

OUTLINE = 200  # triangles that take as long as what every outline takes
MOST_WAITING = 16
SECONDS = 20.0  # for the outlines of a large part; machines are shared


class Outline(NamedTuple):
    """One outline."""

    corners: list[int]  # of each of its rings
    points: bytes  # float64; metres; x and y one after the other


class Outlines:
    """Computes outlines in a thread, those of large parts in a process: they lock Python."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, "outlines")
        self._worker = Worker(prepare)
        self._waiting: set[Future[list[Outline]]] = set()

    def begin(self, part: Part, result: PoseStatistics,
              heights: Sequence[float]) -> Future[list[Outline]]:
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
        self._waiting = {request for request in self._waiting if not request.done()}
        if len(self._waiting) >= MOST_WAITING:
            raise RequestError(f"at most {MOST_WAITING} requests for outlines waiting",
                               f"{len(self._waiting)}", "ask again in a moment")
        try:
            coming = self._pool.submit(
                self._compute, part, [pose.index for pose in result.poses],
                [float(height) for height in heights], result.cluster_tolerance,
                int(result.round_sides))
        except RuntimeError as error:  # closed
            raise RequestError("a running node", "one that is ending", "start it again") from error
        self._waiting.add(coming)
        return coming

    def _compute(self, part: Part, poses: list[int], heights: list[float], tolerance: float,
                 sides: int) -> list[Outline]:
        asked = part, poses, heights, tolerance, sides
        if not is_large(part):
            return outlines_of(*asked)
        try:
            outlines = self._worker.call_within(SECONDS, try_outlines, *asked)
        except TookLongError as error:
            raise RequestError(f"outlines that take at most {SECONDS:g} s",
                               f"{len(poses) * len(heights)} of {len(part.triangles)} triangles",
                               "ask for fewer heights at once") from error
        except (ProcessDiedError, BatchError) as error:
            raise RequestError("a process that computes the outlines to its end",
                               f"one that {error}", "ask again") from error
        if isinstance(outlines, PoseStatsError):
            raise outlines
        return outlines

    def close(self) -> None:
        """Give up what waits and what is computed in the process."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        self._worker.close()


def outlines_of(part: Part, poses: list[int], heights: list[float], tolerance: float,
                sides: int) -> list[Outline]:
    """Outlines in each pose, by its index, at each height."""
    outlines, resting = [], resting_poses(part, tolerance, sides).poses
    for index in poses:
        for height in heights:
            polygons = outline_at(part, resting[index], None if height < 0.0 else height)
            rings = [ring for polygon in polygons for ring in polygon]
            points = np.concatenate([ring.ravel() for ring in rings]) if rings else np.empty(0)
            outlines.append(Outline([len(ring) for ring in rings],
                                 points.astype(np.float64).tobytes()))
    return outlines


def try_outlines(*asked: Any) -> list[Outline] | PoseStatsError:
    """The same in a process, which an exception would end."""
    try:
        return outlines_of(*asked)
    except PoseStatsError as refusal:
        return refusal


def outline_messages(result: PoseStatistics, heights: Sequence[float],
                     outlines: list[Outline]) -> list[PoseOutline]:
    """The outlines of a result as messages."""
    asked = [(pose.pose_id, float(height)) for pose in result.poses for height in heights]
    return [PoseOutline(pose_id=pose_id, height=height, corners=array("I", outline.corners),
                        points=array("d", outline.points))
            for (pose_id, height), outline in zip(asked, outlines, strict=True)]
