"""Drops in the background that make an estimate as good as somebody wants it."""

from collections.abc import Callable

import numpy as np
from ros_pose_stats_msgs.msg import PoseStatistics

from ...errors import RequestError
from ...estimators import best_method
from ...methods import AUTO, HYBRID
from ...planning import confidence, hybrid
from ...records import DropScene, Part
from ...resting.poses import poses_in
from ..messages import statistics_messages
from ..parts import announcer, known_part, result_store
from ..settings import Settings
from . import JobRequest, Jobs


def credible_bound(part: Part, message: PoseStatistics, scene: DropScene) -> float:
    """The error that a result keeps with 90 % confidence; infinite where nobody knows it."""
    resting = poses_in(part, scene)
    if not message.drops:
        return confidence.estimate_bound(confidence.prior_of(message, resting, scene))
    counts = np.zeros(len(resting.poses), dtype=np.int64)
    for pose in message.poses:
        counts[pose.index] = pose.count
    prior = confidence.pose_prior(resting, scene) if message.method == HYBRID else None
    return confidence.judge_drops(prior, counts).bound


class Refinement:
    """Starts drops where an estimate alone is not good enough."""

    def __init__(self, settings: Callable[[], Settings], results: result_store.ResultStore,
                 jobs: Jobs, announcer: announcer.Announcer) -> None:
        self._settings, self._results = settings, results
        self._jobs, self._announcer = jobs, announcer

    def refine(self, known: known_part.KnownPart) -> None:
        """Refine a part's latched result in the background, if that is wanted and not done."""
        settings = self._settings()
        drops = min(settings.refine_drops or settings.drops, settings.max_drops)
        scene, hybrid = settings.scene(known.scene_override), settings.default_method == AUTO
        target = settings.target_error
        request = JobRequest(known.part_id, known.content, scene, drops, 0,
                             self._aim(known, target, scene) if hybrid else target,
                             settings.max_job_seconds, True, hybrid)
        self._jobs.cancel_refinement(known.part_id, "the part or its scene has changed",
                                     but=request)
        wanted = settings.refine_drops or settings.target_error
        if wanted and not _fine_enough(known, request, target):
            self._jobs.submit(request, known_part.at_hand(known.part), settings)

    def answer_checked(self, known: known_part.KnownPart, checked: PoseStatistics,
                       scene: DropScene) -> tuple[PoseStatistics, str]:
        """What answers where no target was asked for, and why."""
        best, dropped = best_method(scene.restitution), self._results.find_drops(known, scene)
        if (dropped is not None and dropped.drops > checked.drops
                and statistics_messages.refutes(dropped)):
            return dropped, f"Drops already made contradict {best}."
        return checked, hybrid.explain_check(best, checked.drops, scene, checked.radius)

    def answer(self, known: known_part.KnownPart, target_error: float,
               scene: DropScene) -> tuple[PoseStatistics, str]:
        """The best that can be said at once, and why; drops follow if it misses the target."""
        best, dropped = self._results.estimate(known, AUTO, scene), self._results.find_drops(
            known, scene)
        if dropped is not None and statistics_messages.refutes(dropped):
            best = dropped
        bound = credible_bound(known.part, best, scene)
        if bound <= target_error:
            return best, confidence.enough(_means(best), bound, target_error)
        if dropped is not None:
            of_found = credible_bound(known.part, dropped, scene)
            if of_found <= target_error:
                return dropped, confidence.enough(_means(dropped), of_found, target_error)
            most = self._most_drops()
            if dropped.drops >= most:
                short = confidence.not_enough(_means(dropped), of_found, target_error)
                return _missed(dropped, f"{short}, and the node drops at most {most} times for it "
                               "(parameter drops).")
        short = confidence.not_enough(_means(best), bound, target_error)
        return _missed(best, f"{short}; {self._start(known, target_error, scene)}")

    def _most_drops(self) -> int:
        settings = self._settings()
        return min(settings.drops, settings.max_drops)

    def _aim(self, known: known_part.KnownPart, target_error: float, scene: DropScene) -> float:
        """The bound at which drops may end; with a higher one they might not be latched."""
        model = known.shown.model
        if model is None or known.shown.scene != scene:
            return target_error
        return min(target_error, statistics_messages.known_error(model))

    def _start(self, known: known_part.KnownPart, target_error: float, scene: DropScene) -> str:
        """Begin to drop; what there is to say about it."""
        settings = self._settings()
        request = JobRequest(known.part_id, known.content, scene, self._most_drops(), 0,
                             self._aim(known, target_error, scene), settings.max_job_seconds,
                             hybrid=True)
        try:
            job = self._jobs.submit(request, known_part.at_hand(known.part), settings)
        except RequestError as refusal:  # the estimate is an answer all the same
            return f"drops cannot refine it now: {refusal}"
        promise = (f"at most {request.drops} drops in the background will refine it, job "
                f"{job.job_id}.")
        return promise if job.recorded else f"{promise} {self._announcer.not_recorded()}"


def _means(message: PoseStatistics) -> str:
    """What a result is, for a sentence."""
    if not message.drops:
        return f"{message.method} alone"
    return f"{message.method} with the {message.drops} drops already made"


def _missed(message: PoseStatistics, choice: str) -> tuple[PoseStatistics, str]:
    return statistics_messages.with_warning(message, f"TARGET_MISSED: {choice}"), choice


def _fine_enough(known: known_part.KnownPart, request: JobRequest, target_error: float) -> bool:
    """Whether the model is as good as a refinement would make it."""
    model = known.shown.model
    if model is None or known.shown.scene != request.scene:
        return False
    if not (model.drops or request.hybrid):
        return False
    return model.drops >= request.drops or (bool(target_error) and (
        credible_bound(known.part, model, request.scene) <= target_error))
