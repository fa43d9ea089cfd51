"""Builds parts and outlines: small ones here, what takes long in a process that can be stopped."""

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
    compile_missing,
    filling_store,
    prepare_kernels,
)
from ...core.mesh import decimation, overlap
from ...core.records import DropScene, Part
from ...core.resting.outlines import outline_at
from ...core.resting.poses import are_found, resting_poses
from ..equipment import Equipment
from ..lanes import Lane, NotDoneError, Rank, refusal_at_end
from ..messages.part_requests import PartRequest, part_of

T = TypeVar("T")

LARGE_TRIANGLES = (
    5000  # a mesh with more of them may take longer than others should wait
)
CORNERS = 3  # vertices a triangle where each has its own
HERE_SECONDS = (
    0.05  # for looking in the node how the bodies of a mesh lie to each other
)
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
    """Have the machine code of every kernel at hand; says if that takes a minute or more."""

    def fill() -> None:
        say("compiling kernels, once for all later starts; it takes a minute or two")
        compile_missing(
            lambda done, total: say(
                f"{done} of {total} kernels compiled",
                throttle_duration_sec=SECONDS_BETWEEN,
            )
        )

    all_kernels()
    with filling_store(fill):
        prepare_kernels()


def prepare() -> None:
    """Give way to others, and load the kernels; called in a process that is to work for a node."""
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
        super().__init__(prepare)
        self._settings = equipment.settings
        self._lanes = equipment.lanes

    def call(
        self,
        seconds: float,
        late: errors.PoseStatsError,
        function: Callable[..., T],
        *arguments: Any,
    ) -> T:
        """Have a function called there; raises `late`, NotDoneError and what it has raised."""
        try:
            outcome = self.call_within(seconds, attempt, function, *arguments)
        except TookLongError as error:
            raise late from error
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


def _build(
    request: PartRequest | Part, scene: DropScene
) -> tuple[Part, dict[Any, Any]]:
    """A part with all that is prepared on the way to its first estimate and picture."""
    part = request if isinstance(request, Part) else part_of(request)
    estimate_in(part, scene, methods.AUTO)
    decimation.visible_triangles(part)  # for its markers
    return part, part.all_prepared()


class PartBuilder(PartWorker):
    """Builds parts, such as take long with their poses for the node's scene."""

    def build(self, request: PartRequest) -> Part:
        """Build a part; raises TakesLongError in the quick lane where it is none for that."""
        if not is_large(request):
            try:
                with overlap.within(HERE_SECONDS):
                    return part_of(request)
            except overlap.TakesLongError:
                if self._lanes.is_quick():
                    raise
        part, prepared = self._ask(request, self._settings().scene())
        part.keep_all(prepared)
        return part

    def find_poses(self, part: Part, scene: DropScene) -> None:
        """Have the poses of a large part at hand; raises as `build`."""
        if is_large(part) and not are_found(part, scene):
            part.keep_all(self._ask(part, scene)[1])

    def _ask(
        self, request: PartRequest | Part, scene: DropScene
    ) -> tuple[Part, dict[Any, Any]]:
        late = errors.MeshError(
            f"a mesh that is checked within {BUDGET_SECONDS:g} s",
            f"{len(request.triangles)} triangles",
            "decimate it",
        )
        return self.call(BUDGET_SECONDS, late, _build, request, scene)


MOST_WORK = (
    500_000  # triangles in all outlines of an answer, and `OUTLINE` for each: 1 or 2 s
)
OUTLINE = 200  # triangles that take as long as what every outline takes
OUTLINE_SECONDS = 20.0  # for the outlines of a large part; machines are shared


class Outlines(PartWorker):
    """Works on outlines in a lane, on those of large parts in a process: it locks Python."""

    def begin(
        self, part: Part, result: PoseStatistics, heights: Sequence[float]
    ) -> Future[list[PoseOutline]]:
        """Have outlines computed in each pose of a result, in its order, at each height."""
        wrong = next((height for height in heights if not np.isfinite(height)), None)
        if wrong is not None:
            raise errors.RequestError(
                "heights above the plate in metres",
                f"{wrong}",
                "a negative one asks for the outline from above",
            )
        triangles = len(part.surface_triangles)
        wanted = len(result.poses) * len(heights)
        most = MOST_WORK // (triangles + OUTLINE)
        if wanted > most:
            raise errors.RequestError(
                f"at most {most} outlines of {triangles} triangles in an answer",
                f"{wanted} ({len(result.poses)} poses, {len(heights)} heights)",
                "ask for fewer heights at once, or use outline_at of the library",
            )
        return self.put(
            part,
            f"{wanted} outlines of {triangles} triangles",
            outlines_of,
            part,
            {pose.index: pose.pose_id for pose in result.poses},
            list(heights),
            result.cluster_tolerance,
            int(result.round_sides),
        )

    def put(
        self, part: Part, what: str, function: Callable[..., T], *arguments: Any
    ) -> Future[T]:
        """Have a function called that outlines a part; `what` it does, in words."""
        late = errors.RequestError(
            f"work on outlines that takes at most {OUTLINE_SECONDS:g} s",
            what,
            "ask for less at once, or decimate the mesh",
        )
        return self._lanes.put(
            partial(self.call, OUTLINE_SECONDS, late, function, *arguments)
            if is_large(part)
            else partial(function, *arguments),
            Rank.KNOWN_PART,
            Lane.OUTLINE,
        )


def outlines_of(
    part: Part,
    poses: dict[int, str],
    heights: list[float],
    tolerance: float,
    sides: int,
) -> list[PoseOutline]:
    """Outlines in each pose, by its index with its pose_id, at each height."""
    outlines = []
    resting = resting_poses(part, tolerance, sides).poses
    for index, pose_id in poses.items():
        for height in heights:
            polygons = outline_at(
                part, resting[index], None if height < 0.0 else height
            )
            rings = [ring for polygon in polygons for ring in polygon]
            points = (
                np.concatenate([ring.ravel() for ring in rings])
                if rings
                else np.empty(0)
            )
            outlines.append(
                PoseOutline(
                    pose_id=pose_id,
                    height=height,
                    corners=array("I", map(len, rings)),
                    points=array("d", points.astype(np.float64).tobytes()),
                )
            )
    return outlines
