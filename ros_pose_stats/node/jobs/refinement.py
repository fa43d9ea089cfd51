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

"""Drops that check an estimate, and those that make it as good as its target."""

import math
import threading
from concurrent.futures import CancelledError, Future
from functools import partial

import numpy as np
from ros_pose_stats_msgs.msg import PoseStatistics

from ...base import errors, methods
from ...core.estimators import best_method
from ...core.planning import auto, confidence
from ...core.records import DropScene
from ...core.records.notes import note
from ...core.resting.poses import poses_in
from ..equipment import Equipment
from ..lanes import Lane, Rank, finished_future
from ..memory import Memory
from ..messages import part_requests, statistics_messages
from ..parts.known_part import KnownPart
from ..parts.part_results import BEST, CHECKED, TRIED
from ..parts.registry import PartRegistry
from . import JobRequest, Jobs

REMEMBERED_BOUNDS = 1000  # of results; finding one takes longer than an answer's rest

BoundKey = tuple[str, DropScene, str, bool, tuple[int, ...]]


class Refinement:
    """Has estimates checked in a lane of their own, each once, and refined by jobs."""

    def __init__(self, equipment: Equipment, parts: PartRegistry, jobs: Jobs) -> None:
        self._equipment = equipment
        self._settings = equipment.settings
        self._lanes = equipment.lanes
        self._parts = parts
        self._jobs = jobs
        self._report_failure = equipment.node.get_logger().error
        self._checks: dict[tuple[str, str, DropScene], Future[PoseStatistics]] = {}
        # names of parts that wait for their check with nobody asking
        self._followed: set[str] = set()
        self._lock = threading.Lock()
        self._bounds: Memory[BoundKey, float] = Memory(REMEMBERED_BOUNDS)

    def check(self, part: KnownPart, scene: DropScene) -> Future[PoseStatistics]:
        """A built part's checked estimate; new parts come before scenes of old ones."""
        with self._lock:
            message = part.results.get(CHECKED, scene)
            if message is not None:
                return finished_future(message)
            key = part.part_id, part.digest, scene
            if key in self._checks:
                return self._checks[key]
            rank = (
                Rank.REQUESTED_MESH
                if part.part_id in self._followed
                else Rank.KNOWN_PART
            )
            check = self._lanes.put(partial(part.check, scene), rank, Lane.CHECK)
            self._checks[key] = check
        check.add_done_callback(lambda _: self._checks.pop(key, None))
        return check

    def follow(self, part: KnownPart) -> None:
        """Have what a part shows checked, if it is an estimate, and then refined."""
        if not part.lacks_check():
            self._refine(part)
            return
        part_id = part.part_id
        with self._lock:
            is_followed = part_id in self._followed
            self._followed.add(part_id)
        # By its name: what comes in its place meanwhile has its turn.
        if not is_followed:
            self._lanes.put(partial(self._follow, part_id), Rank.WHEN_IDLE, Lane.CHECK)

    def _follow(self, part_id: str) -> None:
        with self._lock:
            self._followed.remove(part_id)
        part = self._parts.current(part_id)
        if part is None:
            return
        scene = self._settings().scene(part.scene_override)
        for improve in (partial(part.check, scene), partial(self._refine, part)):
            try:
                improve()
            except (errors.PoseStatsError, CancelledError):
                pass  # who asks is told; or the node ends
            except Exception as error:
                self._report_failure(
                    f"an estimate of {part_id!r} could not be refined: "
                    f"{type(error).__name__}: {error}"
                )

    def _refine(self, part: KnownPart) -> None:
        """Refine what is latched in the background, if that is wanted and not done."""
        if not part.is_current:
            return
        settings = self._settings()
        drops = min(settings.refine_drops or settings.drops, settings.max_drops)
        scene = settings.scene(part.scene_override)
        target = settings.target_error
        is_hybrid = settings.default_method == methods.AUTO
        request = JobRequest(
            part.part_id,
            part.content,
            scene,
            drops,
            seed=0,
            target_error=self._aim(part, target, scene) if is_hybrid else target,
            max_seconds=settings.max_job_seconds,
            refinement=True,
            hybrid=is_hybrid,
        )
        self._jobs.cancel_refinement(
            part.part_id, "the part or its scene has changed", but=request
        )
        if not (settings.refine_drops or target):
            return
        model = part.model_in(scene)
        if model is not None and (model.drops or is_hybrid):
            if model.drops >= drops:
                return
            if target and self._credible_bound(part, model, scene) <= target:
                return
        self._jobs.submit(request, finished_future(part), settings)

    def has_answer(self, part: KnownPart, method: str, scene: DropScene) -> bool:
        """Whether an answer without a target is at hand; raises as an estimate does."""
        name = method or self._settings().default_method
        if name != methods.AUTO:
            name = part_requests.estimator_name(name, scene.restitution)
            return part.results.get(name, scene) is not None
        checked = part.results.get(CHECKED, scene)
        if checked is None:
            return False
        answer = _believed(part, checked, scene)
        return self._bounds.get(_bound_key(answer, scene)) is not None

    def answer_checked(
        self, part: KnownPart, checked: PoseStatistics, scene: DropScene
    ) -> tuple[PoseStatistics, str]:
        """What answers where no target was asked for, and why."""
        checked = _believed(part, checked, scene)
        return checked, auto.explain_answer(
            best_method(scene.restitution),
            checked.method,
            checked.drops,
            self._credible_bound(part, checked, scene),
            auto.DEFAULT_TARGET,
        )

    def answer_by(
        self,
        method: str,
        part: KnownPart,
        target_error: float,
        scene: DropScene,
        advice: str,
    ) -> PoseStatistics:
        """What the one estimator says that was asked for, whatever its error."""
        message = part.estimate(method, scene)
        if not target_error:
            return message
        bound = self._credible_bound(part, message, scene)
        if bound <= target_error:
            return message
        reason = f"the error of {message.method} is not known here"
        if math.isfinite(bound):
            reason = confidence.explain_missed_target(
                message.method, bound, target_error
            )
        return _missed(message, f"{reason}; {advice}.")[0]

    def answer(
        self,
        part: KnownPart,
        checked: PoseStatistics,
        target_error: float,
        scene: DropScene,
    ) -> tuple[PoseStatistics, str]:
        """The best answer at once, and why; more drops follow if it falls short."""
        settings = self._settings()
        most_drops = min(settings.drops, settings.max_drops)
        best = part.results.get(BEST, scene)
        dropped = best if best is not None and best.drops else None
        if dropped is not None and statistics_messages.refutes(dropped):
            checked = dropped
        for result in filter(None, (checked, dropped)):
            bound = self._credible_bound(part, result, scene)
            if bound <= target_error:
                return result, confidence.explain_kept_target(
                    _means(result), bound, target_error
                )
        for result in filter(None, (dropped, part.results.get(TRIED, scene))):
            if result.drops >= most_drops:
                reason = self._explain_miss(part, result, target_error, scene)
                return _missed(
                    result,
                    f"{reason}, and the node drops at most {most_drops} times for it "
                    "(parameter drops).",
                )
        reason = self._explain_miss(part, checked, target_error, scene)
        request = JobRequest(
            part.part_id,
            part.content,
            scene,
            most_drops,
            seed=0,
            target_error=self._aim(part, target_error, scene),
            max_seconds=settings.max_job_seconds,
            hybrid=True,
        )
        try:
            job = self._jobs.submit(request, finished_future(part), settings)
        except errors.RequestError as refusal:  # the estimate is an answer all the same
            return _missed(checked, f"{reason}; drops cannot refine it now: {refusal}")
        if not job.is_recorded:
            checked = self._equipment.warn_unrecorded(checked)
        return _missed(
            checked,
            f"{reason}; at most {most_drops} drops in the background will refine it, "
            f"job {job.job_id}.",
        )

    def _credible_bound(
        self, part: KnownPart, message: PoseStatistics, scene: DropScene
    ) -> float:
        """The error that a result keeps with 90 % confidence; infinite if unknown."""
        key = _bound_key(message, scene)
        *_, is_refuted, counts = key
        bound = self._bounds.get(key)
        if bound is None:
            resting = poses_in(part.geometry, scene)
            if not message.drops:
                bound = confidence.estimate_bound(message, resting, scene)
            else:
                prior = None
                if message.method == methods.HYBRID or is_refuted:
                    prior = confidence.pose_prior(resting, scene)
                bound = confidence.judge_drops(prior, np.array(counts)).bound
            self._bounds.put(key, bound)
        return bound

    def _explain_miss(
        self,
        part: KnownPart,
        message: PoseStatistics,
        target_error: float,
        scene: DropScene,
    ) -> str:
        """How far a result is from the target."""
        bound = self._credible_bound(part, message, scene)
        return confidence.explain_missed_target(_means(message), bound, target_error)

    def _aim(self, part: KnownPart, target_error: float, scene: DropScene) -> float:
        """The bound at which drops may end, so low that they are latched then."""
        model = part.model_in(scene)
        if model is None:
            return target_error
        return min(target_error, statistics_messages.comparable_error(model))


def _bound_key(message: PoseStatistics, scene: DropScene) -> BoundKey:
    """On what the error depends that a result keeps."""
    poses = sorted(message.poses, key=lambda pose: pose.index)
    counts = tuple(pose.count for pose in poses)
    is_refuted = statistics_messages.refutes(message)
    return message.part_digest, scene, message.method, is_refuted, counts


def _believed(
    part: KnownPart, checked: PoseStatistics, scene: DropScene
) -> PoseStatistics:
    """A checked estimate, or more drops that refute it."""
    best = part.results.get(BEST, scene)
    if (
        best is not None
        and best.drops > checked.drops
        and statistics_messages.refutes(best)
    ):
        return best
    return checked


def _means(message: PoseStatistics) -> str:
    """What a result is, for a sentence."""
    if not message.drops:
        return f"{message.method} alone"
    return f"{message.method} with the {message.drops} drops already made"


def _missed(message: PoseStatistics, choice: str) -> tuple[PoseStatistics, str]:
    warning = note("TARGET_MISSED", choice)
    return statistics_messages.with_warning(message, warning), choice
