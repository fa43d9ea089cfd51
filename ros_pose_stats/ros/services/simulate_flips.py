"""The action `~/simulate_flips`: flips out of every pose of a known part."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ros_pose_stats_msgs.action import SimulateFlips

from ...errors import RequestError
from ...resting.poses import are_found
from ..jobs.flips import FlipReports, flips_in_all, pose_count
from ..jobs.job import FlipRequest, Job
from ..jobs.queue import Jobs
from ..parts.known_part import at_hand
from ..parts.part_builder import is_large
from ..parts.part_store import PartStore
from ..settings import Settings
from ..transport.answering_node import AnsweringNode
from .goals import GoalServer


class SimulateFlipsServer(GoalServer):
    """Goals that are flips."""

    def __init__(self, node: AnsweringNode, settings: Callable[[], Settings], parts: PartStore,
                 jobs: Jobs, reports: FlipReports) -> None:
        self._settings = settings
        self._parts = parts
        self._reports = reports
        super().__init__(node, SimulateFlips, "simulate_flips", jobs, reports)

    def start_job(self, request: Any) -> Job:
        """Accept flips; too many are refused at once where the part's poses are at hand."""
        settings, known = self._settings(), self._parts.known(request.part_id)
        kick = settings.kick(request.kick_height)
        if request.kick_height < 0.0 and not kick:
            raise RequestError("a kick_height of 0 m or more, for the parameter flip_height is 0",
                               f"{request.kick_height:g}", "half the part's radius flips most "
                               "parts")
        scene = settings.scene(known.scene_override)
        if not is_large(known.part) or are_found(known.part, scene):
            flips_in_all(pose_count(known.part, scene), request.drops, settings)
        return self._jobs.submit(
            FlipRequest(known.part_id, known.content, scene, request.drops, request.seed,
                        0.0, settings.max_job_seconds, kick_height=kick),
            at_hand(known.part), settings)

    def feedback(self, job: Job) -> Any:
        """How far the flips are."""
        found, part = SimulateFlips.Feedback(flips_done=job.drops_done), job.built()
        if part is not None:
            found.flips_total = flips_in_all(pose_count(part, job.request.scene),
                                             job.request.drops, job.settings)
        return found

    def result(self, job: Job | None, success: bool, message: str) -> Any:
        """The transition matrix of what was done."""
        told = SimulateFlips.Result(success=success, message=message)
        found = None if job is None else self._reports.of_job(job.job_id)
        if found is None:
            return told
        for name in ("part_id", "part_digest", "restitution", "kick_height", "seed"):
            setattr(told, name, getattr(found, name))
        told.flips = _whole(found.counts.sum(axis=1) + found.unsettled)
        told.unsettled = _whole(found.unsettled)
        told.transition, told.standard_error = flat(found.transition), flat(found.standard_error)
        return told


def flat(matrix: NDArray[np.float64]) -> array[float]:
    """A matrix row by row, as rclpy takes it as it is."""
    return array("d", np.ascontiguousarray(matrix).tobytes())


def _whole(numbers: NDArray[np.int64]) -> array[int]:
    return array("Q", numbers.astype(np.uint64).tobytes())
