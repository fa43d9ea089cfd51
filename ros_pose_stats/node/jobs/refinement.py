"""Drops that check an estimate, and those in the background that make it as good as wanted."""

import math
import threading
from concurrent.futures import CancelledError, Future
from functools import partial

import numpy as np
from ros_pose_stats_msgs.msg import PoseStatistics

from ...base import errors, methods
from ...core.estimators import best_method
from ...core.planning import confidence, hybrid
from ...core.records import DropScene, Part
from ...core.resting.poses import poses_in
from ..equipment import Equipment
from ..lanes import Lane, Rank, done_with
from ..messages import statistics_messages
from ..parts import result_store
from ..parts.known_part import KnownPart
from . import JobRequest, Jobs


def credible_bound(part: Part, message: PoseStatistics, scene: DropScene) -> float:
    """The error that a result keeps with 90 % confidence; infinite where nobody knows it."""
    resting = poses_in(part, scene)
    if not message.drops:
        return confidence.estimate_bound(confidence.prior_of(message, resting, scene))
    counts = np.array(
        [pose.count for pose in sorted(message.poses, key=lambda pose: pose.index)]
    )
    prior = (
        confidence.pose_prior(resting, scene)
        if message.method == methods.HYBRID
        else None
    )
    return confidence.judge_drops(prior, counts).bound


class Refinement:
    """Has estimates checked in a lane of their own, equal ones once, and refined by jobs."""

    def __init__(
        self, equipment: Equipment, stores: result_store.Stores, jobs: Jobs
    ) -> None:
        self._settings = equipment.settings
        self._lanes = equipment.lanes
        self._jobs = jobs
        self._parts, _, self._results, self._announcer = stores
        self._report_failure = equipment.node.get_logger().error
        self._checks: dict[tuple[str, str, DropScene], Future[PoseStatistics]] = {}
        self._followed: set[str] = (
            set()
        )  # parts that wait for their check with nobody asking
        self._lock = threading.Lock()

    def checked(self, known: KnownPart, scene: DropScene) -> Future[PoseStatistics]:
        """A built part's checked estimate; new parts come before scenes of known ones."""
        with self._lock:
            message = self._results.checked(known, scene)
            if message is not None:
                return done_with(message)
            key = known.part_id, known.digest, scene
            coming = self._checks.get(key)
            if coming is None:
                rank = Rank.SENT if known.part_id in self._followed else Rank.KNOWN
                coming = self._checks[key] = self._lanes.put(
                    partial(self._results.check, known, scene), rank, Lane.CHECK
                )
                coming.add_done_callback(lambda _: self._checks.pop(key, None))
            return coming

    def follow(self, known: KnownPart) -> None:
        """Have what a part shows checked, where it is an estimate alone, and then refined."""
        if not self._results.lacks_check(known):
            self._refine(known)
            return
        with self._lock:
            follows = known.part_id in self._followed
            self._followed.add(known.part_id)
        if not follows:  # by its name: what comes in its place meanwhile has its turn
            self._lanes.put(
                partial(self._follow, known.part_id), Rank.LATER, Lane.CHECK
            )

    def _follow(self, part_id: str) -> None:
        with self._lock:
            self._followed.remove(part_id)
        known = self._parts.current(part_id)
        if known is None:
            return
        scene = self._settings().scene(known.scene_override)
        check = partial(self._results.check, known, scene)
        for improve in (check, partial(self._refine, known)):
            try:
                improve()
            except (errors.PoseStatsError, CancelledError):
                pass  # who asks is told; or the node ends
            except Exception as error:
                self._report_failure(
                    f"an estimate of {part_id!r} could not be refined: "
                    f"{type(error).__name__}: {error}"
                )

    def _refine(self, known: KnownPart) -> None:
        """Refine a part's latched result in the background, if that is wanted and not done."""
        if self._parts.current(known.part_id) is not known:
            return
        settings = self._settings()
        drops = min(settings.refine_drops or settings.drops, settings.max_drops)
        scene = settings.scene(known.scene_override)
        target = settings.target_error
        hybrid = settings.default_method == methods.AUTO
        request = JobRequest(
            known.part_id,
            known.content,
            scene,
            drops,
            0,
            self._aim(known, target, scene) if hybrid else target,
            settings.max_job_seconds,
            True,
            hybrid,
        )
        self._jobs.cancel_refinement(
            known.part_id, "the part or its scene has changed", but=request
        )
        model = known.model_in(scene)
        fine = (
            model is not None
            and (model.drops or hybrid)
            and (
                model.drops >= drops
                or (target and credible_bound(known.part, model, scene) <= target)
            )
        )
        if (settings.refine_drops or target) and not fine:
            self._jobs.submit(request, done_with(known), settings)

    def answer_checked(
        self, known: KnownPart, checked: PoseStatistics, scene: DropScene
    ) -> tuple[PoseStatistics, str]:
        """What answers where no target was asked for, and why."""
        best = best_method(scene.restitution)
        dropped = self._results.find_drops(known, scene)
        if (
            dropped
            and dropped.drops > checked.drops
            and statistics_messages.refutes(dropped)
        ):
            return dropped, f"Drops already made contradict {best}."
        return checked, hybrid.explain_check(best, checked.drops, scene, checked.radius)

    def answer_by(
        self,
        method: str,
        known: KnownPart,
        target_error: float,
        scene: DropScene,
        advice: str,
    ) -> PoseStatistics:
        """What the one estimator says that was asked for, whatever its error."""
        message = self._results.estimate(known, method, scene)
        bound = credible_bound(known.part, message, scene) if target_error else 0.0
        if bound <= target_error:
            return message
        short = (
            confidence.not_enough(message.method, bound, target_error)
            if math.isfinite(bound)
            else f"the error of {message.method} is not known here"
        )
        return _missed(message, f"{short}; {advice}.")[0]

    def answer(
        self, known: KnownPart, target_error: float, scene: DropScene
    ) -> tuple[PoseStatistics, str]:
        """The best that can be said at once, and why; drops follow if it misses the target."""
        best = self._results.estimate(known, methods.AUTO, scene)
        dropped = self._results.find_drops(known, scene)
        if dropped and statistics_messages.refutes(dropped):
            best = dropped
        settings = self._settings()
        most = min(settings.drops, settings.max_drops)
        for result in filter(None, (best, dropped)):
            bound = credible_bound(known.part, result, scene)
            if bound <= target_error:
                return result, confidence.enough(_means(result), bound, target_error)
        spent = next(
            (
                result
                for result in (dropped, self._results.find_tried(known, scene))
                if result and result.drops >= most
            ),
            None,
        )
        bound = credible_bound(known.part, spent or best, scene)
        short = confidence.not_enough(_means(spent or best), bound, target_error)
        if spent is not None:
            return _missed(
                spent,
                f"{short}, and the node drops at most {most} times for it "
                "(parameter drops).",
            )
        request = JobRequest(
            known.part_id,
            known.content,
            scene,
            most,
            0,
            self._aim(known, target_error, scene),
            settings.max_job_seconds,
            hybrid=True,
        )
        try:
            job = self._jobs.submit(request, done_with(known), settings)
        except errors.RequestError as refusal:  # the estimate is an answer all the same
            return _missed(best, f"{short}; drops cannot refine it now: {refusal}")
        promise = (
            f"at most {most} drops in the background will refine it, job {job.job_id}."
        )
        if not job.recorded:
            promise += f" {self._announcer.not_recorded()}"
        return _missed(best, f"{short}; {promise}")

    def _aim(self, known: KnownPart, target_error: float, scene: DropScene) -> float:
        """The bound at which drops may end; with a higher one they might not be latched."""
        model = known.model_in(scene)
        return (
            target_error
            if model is None
            else min(target_error, statistics_messages.known_error(model))
        )


def _means(message: PoseStatistics) -> str:
    """What a result is, for a sentence."""
    if not message.drops:
        return f"{message.method} alone"
    return f"{message.method} with the {message.drops} drops already made"


def _missed(message: PoseStatistics, choice: str) -> tuple[PoseStatistics, str]:
    return statistics_messages.with_warning(message, f"TARGET_MISSED: {choice}"), choice
