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

"""Builds parts and outlines; what takes long, in a process that can be stopped."""

import os
from array import array
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import partial
from typing import Any, TypeVar

import numpy as np
from ros_pose_stats_msgs.msg import PoseOutline, PoseStatistics

from ...base import errors, methods
from ...base.worker import ProcessDiedError, TookLongError, Worker
from ...core.estimators.estimate import estimate_in
from ...core.kernels.compilation import (
    all_kernels,
    announcement,
    compile_missing,
    filling_store,
    prepare_kernels,
)
from ...core.mesh import decimation
from ...core.mesh.bodies import overlap
from ...core.records import DropScene, Part
from ...core.resting.outlines import outline_at
from ...core.resting.poses import are_found, resting_poses
from ..equipment import Equipment
from ..lanes import Lane, Rank
from ..messages.codes import NotDoneError, refusal_at_end
from ..messages.part_requests import PartRequest, build_part

T = TypeVar("T")

LARGE_TRIANGLES = 5000  # a mesh with more may take longer than others should wait
CORNERS = 3  # vertices a triangle where each has its own
# for looking in the node how the bodies of a mesh lie to each other
OVERLAP_SECONDS = 0.05
BUDGET_SECONDS = 60.0  # for one mesh
NICENESS = 10  # drops and answers come first
SECONDS_BETWEEN = 5.0  # between lines of how many kernels are compiled


def is_large(mesh: PartRequest | Part) -> bool:
    """Whether a mesh may take longer than others should wait."""
    return (
        len(mesh.triangles) > LARGE_TRIANGLES
        or len(mesh.vertices) > CORNERS * LARGE_TRIANGLES
    )


def warm_up(say: Callable[..., object]) -> None:
    """Have the machine code of every kernel at hand; says so if that takes a minute."""

    def fill() -> None:
        say(announcement())
        compile_missing(
            lambda count, total: say(
                f"{count} of {total} kernels compiled",
                throttle_duration_sec=SECONDS_BETWEEN,
            )
        )

    all_kernels()
    with filling_store(fill):
        prepare_kernels()


def prepare_process() -> None:
    """Give way to others, and load the kernels, in a process that works for a node."""
    os.nice(NICENESS)
    all_kernels()
    prepare_kernels()


def attempt(function: Callable[..., T], *arguments: Any) -> T | Exception:
    """Call a function in that process, which an exception would end."""
    try:
        return function(*arguments)
    except errors.PoseStatsError as refusal:
        return refusal
    except Exception as error:  # belongs to whoever asked, who may not have its type
        return RuntimeError(f"{type(error).__name__}: {error}")


class PartWorker(Worker):
    """The process, for one caller after the other."""

    def __init__(self, equipment: Equipment) -> None:
        super().__init__(prepare_process)
        self._settings = equipment.settings
        self._lanes = equipment.lanes

    def call(
        self,
        seconds: float,
        refusal: errors.PoseStatsError,
        function: Callable[..., T],
        *arguments: Any,
    ) -> T:
        """Have a function called there; raises what it raises, or NotDoneError.

        `refusal` is raised where it takes longer than some seconds.
        """
        try:
            outcome = self.call_within(seconds, attempt, function, *arguments)
        except TookLongError as error:
            raise refusal from error
        except (ProcessDiedError, errors.BatchError) as error:
            if self.closed:
                raise refusal_at_end() from error
            raise NotDoneError(
                "a process that works on the part to the end",
                f"one that {error}",
                "send the mesh again; decimate it if memory is short",
            ) from error
        if isinstance(outcome, Exception):
            raise outcome
        return outcome


def build_prepared(
    request: PartRequest | Part, scene: DropScene
) -> tuple[Part, dict[Any, Any]]:
    """A part with what is prepared on the way to its first estimate and picture."""
    part = request if isinstance(request, Part) else build_part(request)
    estimate_in(part, scene, methods.AUTO)
    decimation.visible_triangles(part)  # for its markers
    return part, part.all_prepared()


class PartBuilder(PartWorker):
    """Builds parts, such as take long with their poses for the node's scene."""

    def build(self, request: PartRequest) -> Part:
        """Build a part; the quick lane has no time for some: raises TakesLongError."""
        if not is_large(request):
            try:
                with overlap.patience(OVERLAP_SECONDS):
                    return build_part(request)
            except overlap.TakesLongError:
                if self._lanes.is_quick():
                    raise
        part, prepared = self._build_there(request, self._settings().scene())
        part.keep_all(prepared)
        return part

    def find_poses(self, part: Part, scene: DropScene) -> None:
        """Have the poses of a large part at hand; raises as `build`."""
        if is_large(part) and not are_found(part, scene):
            part.keep_all(self._build_there(part, scene)[1])

    def _build_there(
        self, request: PartRequest | Part, scene: DropScene
    ) -> tuple[Part, dict[Any, Any]]:
        refusal = errors.TimedOutError(
            f"a mesh that is checked within {BUDGET_SECONDS:g} s",
            f"{len(request.triangles)} triangles",
            "decimate it",
        )
        return self.call(BUDGET_SECONDS, refusal, build_prepared, request, scene)


# triangles in all outlines of an answer, and `OUTLINE` for each: a second or two
MOST_WORK = 500_000
OUTLINE = 200  # triangles that take as long as what every outline takes
OUTLINE_SECONDS = 20.0  # for the outlines of a large part; machines are shared


class Outlines(PartWorker):
    """Works on outlines in a lane, on those of large parts in a process.

    In the node itself these would lock Python.
    """

    def begin(
        self, part: Part, result: PoseStatistics, heights: Sequence[float]
    ) -> Future[list[PoseOutline]]:
        """Have outlines made in each pose of a result, in its order, at each height."""
        for height in heights:
            if not np.isfinite(height):
                raise errors.RequestError(
                    "heights above the plate in metres",
                    f"{height}",
                    "a negative one asks for the outline from above",
                )
        triangles = len(part.surface_triangles)
        outlines = len(result.poses) * len(heights)
        most_outlines = MOST_WORK // (triangles + OUTLINE)
        if outlines > most_outlines:
            raise errors.RequestError(
                f"at most {most_outlines} outlines of {triangles} triangles "
                "in an answer",
                f"{outlines} ({len(result.poses)} poses, {len(heights)} heights)",
                "ask for fewer heights at once, or use outline_at of the library",
            )
        return self.put(
            part,
            f"{outlines} outlines of {triangles} triangles",
            outlines_of,
            part,
            {pose.index: pose.pose_id for pose in result.poses},
            list(heights),
            result.cluster_tolerance,
            int(result.round_sides),
        )

    def put(
        self, part: Part, task: str, function: Callable[..., T], *arguments: Any
    ) -> Future[T]:
        """Have a function called that outlines a part; `task` says what it does."""
        work = partial(function, *arguments)
        if is_large(part):
            refusal = errors.TimedOutError(
                f"work on outlines that takes at most {OUTLINE_SECONDS:g} s",
                task,
                "ask for less at once, or decimate the mesh",
            )
            work = partial(self.call, OUTLINE_SECONDS, refusal, function, *arguments)
        return self._lanes.put(work, Rank.KNOWN_PART, Lane.OUTLINE)


def outlines_of(
    part: Part,
    pose_ids: dict[int, str],
    heights: list[float],
    tolerance: float,
    sides: int,
) -> list[PoseOutline]:
    """Outlines in each pose, by its index with its pose_id, at each height."""
    outlines = []
    resting = resting_poses(part, tolerance, sides).poses
    for index, pose_id in pose_ids.items():
        for height in heights:
            is_from_above = height < 0.0
            polygons = outline_at(
                part, resting[index], None if is_from_above else height
            )
            rings = [ring for polygon in polygons for ring in polygon]
            points = np.concatenate([np.empty(0), *(ring.ravel() for ring in rings)])
            outlines.append(
                PoseOutline(
                    pose_id=pose_id,
                    height=height,
                    corners=array("I", map(len, rings)),
                    points=array("d", points.astype(np.float64).tobytes()),
                )
            )
    return outlines
