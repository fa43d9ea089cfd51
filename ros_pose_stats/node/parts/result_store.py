"""The results of the parts, and which one of them each part shows."""

import copy
import math
import time
from concurrent.futures import CancelledError
from dataclasses import replace
from typing import NamedTuple

from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import PoseStatistics
from std_msgs.msg import Header

from ...base import methods
from ...core import records
from ...core.estimators.estimate import estimate_in
from ...core.planning import hybrid
from ...core.simulation.request import Watch, drop_request
from ..equipment import Equipment
from ..messages import part_requests, statistics_messages as messages
from ..recorder import POSE_STATISTICS
from ..settings import Settings
from ..state import Change
from . import announcer, count_store, part_store
from .known_part import KnownPart, Memory, Shown

REMEMBERED_POSES = (
    20_000  # of results for parts and scenes that come again; some 2 kB each
)
SECONDS_BETWEEN = 1.0  # a part that is being refined is published at most this often
BEST = "best"  # of all that came for a scene; latched at once where that is the part's again
CHECKED = "checked"  # the default estimate with some drops beside it, the usual answer
TRIED = "tried"  # the end of the last job

Key = tuple[str, str, str, records.DropScene, str, float, str]


class ResultStore:
    """Estimates, numbers and remembers results, and latches the best one of each part."""

    def __init__(
        self,
        equipment: Equipment,
        parts: part_store.PartStore,
        counts: count_store.CountStore,
        announcer: announcer.Announcer,
    ) -> None:
        self._settings = equipment.settings
        self._parts = parts
        self._counts = counts
        self._announcer = announcer
        self._state = equipment.state
        self._lanes = equipment.lanes
        self._results: Memory[Key, PoseStatistics] = Memory(
            REMEMBERED_POSES, lambda message: len(message.poses)
        )

    def restore(self, known: KnownPart) -> None:
        """Latch what an earlier run has latched, if it holds in the present scene."""
        self._counts.restore(known)
        row = self._state.get("results", known.part_id)
        revisions = known.revisions
        if row is None:
            return
        _, latched, behind, revisions.newest = row
        revisions.shown = revisions.newest
        settings = self._settings()
        scene = settings.scene(known.scene_override)
        try:
            last = deserialize_message(latched, PoseStatistics)
            model = deserialize_message(behind, PoseStatistics) if behind else last
        except Exception:  # of the bindings: then it is estimated anew
            return
        if last.part_digest != known.digest or not messages.still_true(model, scene):
            return
        with revisions.lock:
            last.final = True  # nothing is going to refine it any more
            model = _labelled(known, settings, model)
            last = last if behind else model
            known.shown = Shown(last, model, scene, time.monotonic())
            revisions.newest = revisions.shown = max(revisions.newest, last.revision)
            observed = last.method == methods.OBSERVED
            if self._counts.counted_as(known, model) != last.observed * observed or (
                observed and last.header.frame_id != settings.plate_frame
            ):
                self._latch(known, model, scene)
            else:
                self._announcer.publish_result(known, serialize_message(last))
        roles = (
            [BEST] if model.job_id else [BEST, CHECKED if model.drops else model.method]
        )
        for role in roles:
            self._results.put(self._key(role, known, scene), model)

    def show_waiting(self) -> None:
        """Show what was counted, and put on record what was not when it was latched again."""
        for known in self._parts.all():
            with known.revisions.lock:
                shown = known.shown
                if shown is None or self._parts.current(known.part_id) is not known:
                    continue
                if self._counts.counted_as(known, shown.model) not in (
                    0,
                    shown.latched.observed,
                ):
                    self._latch(known, shown.model, shown.scene)
                elif not shown.recorded and known.revisions.recorded_at > -math.inf:
                    shown.recorded = True
                    self._announcer.record(POSE_STATISTICS, known, shown.latched)

    def show_best(self, known: KnownPart) -> None:
        """Latch the best that is known for the part's present scene, at least an estimate."""
        settings = self._settings()
        scene = settings.scene(known.scene_override)
        best = self._results.get(self._key(BEST, known, scene))
        if best is not None:
            self.offer_result(known, scene, best)
        with known.revisions.lock:  # so that nothing comes in between
            model = known.model_in(scene)
            if model is not None:
                model = _labelled(known, settings, model)
                if model.drops and not model.job_id:
                    self._results.put(self._key(CHECKED, known, scene), model)
                self.offer_result(known, scene, model)
        checked = (
            self.checked(known, scene)
            if settings.default_method == methods.AUTO
            else None
        )
        self.offer_result(known, scene, checked or self.estimate(known, "", scene))

    def remembers(
        self, known: KnownPart, method: str, scene: records.DropScene
    ) -> bool:
        """Whether an answer without a target is at hand; raises as `estimate`."""
        name = method or self._settings().default_method
        role = (
            CHECKED
            if name == methods.AUTO
            else part_requests.estimator_name(name, scene.restitution)
        )
        return self._results.get(self._key(role, known, scene)) is not None

    def checked(
        self, known: KnownPart, scene: records.DropScene
    ) -> PoseStatistics | None:
        """The checked estimate, if it was made before."""
        return self._results.get(self._key(CHECKED, known, scene))

    def lacks_check(self, known: KnownPart) -> bool:
        """Whether a part shows an estimate alone where a checked one is wanted."""
        settings = self._settings()
        scene = settings.scene(known.scene_override)
        model = known.model_in(scene)
        return (
            settings.default_method == methods.AUTO
            and self.checked(known, scene) is None
            and not (model is not None and model.drops)
        )

    def check(self, known: KnownPart, scene: records.DropScene) -> PoseStatistics:
        """Drop a part some times beside its estimate, as the library does, and offer the outcome.

        Raises PoseStatsError, and CancelledError where the node ends.
        """
        settings = self._settings()
        message = self.checked(known, scene)
        if message is None:
            part = known.part
            request = drop_request(
                hybrid.CHECK_DROPS, part.seed, 0.0, settings.threads()
            )
            statistics, _ = hybrid.checked(
                estimate_in(part, scene, methods.AUTO),
                part,
                scene,
                request,
                Watch(None, lambda: self._lanes.closed, background=True),
            )
            if self._lanes.closed:
                raise CancelledError
            message = (
                self.number_result(known, statistics, settings)
                if statistics.drops
                else self.estimate(known, methods.AUTO, scene)
            )
            self._results.put(self._key(CHECKED, known, scene), message)
        if settings.default_method == methods.AUTO:
            self.offer_result(known, scene, message)
        return message

    def estimate(
        self, known: KnownPart, method: str, scene: records.DropScene
    ) -> PoseStatistics:
        """An analytic result, from memory where it was asked for before; raises PoseStatsError."""
        settings = self._settings()
        name = part_requests.estimator_name(
            method or settings.default_method, scene.restitution
        )
        key = self._key(name, known, scene)
        message = self._results.get(key)
        if message is None:
            message = self.number_result(
                known, estimate_in(known.part, scene, name), settings
            )
            self._results.put(key, message)
        return message

    def find_drops(
        self, known: KnownPart, scene: records.DropScene
    ) -> PoseStatistics | None:
        """The best that is remembered for a scene, if it is an end result of drops."""
        best = self._results.get(self._key(BEST, known, scene))
        return best if best is not None and best.drops else None

    def find_tried(
        self, known: KnownPart, scene: records.DropScene
    ) -> PoseStatistics | None:
        """The end result of the last drops for a scene, which need not be the best."""
        return self._results.get(self._key(TRIED, known, scene))

    def number_result(
        self,
        known: KnownPart,
        statistics: records.PoseStatistics,
        settings: Settings,
        job_id: str = "",
        final: bool = True,
    ) -> PoseStatistics:
        """Make the message of a new result of a part, with the error of the settings' plate."""
        if statistics.method != methods.OBSERVED:
            statistics = replace(statistics, plate_error=settings.plate_error)
        return messages.statistics_message(
            statistics,
            settings.plate_frame,
            plate=settings.plate,
            revision=known.revisions.next(),
            job_id=job_id,
            final=final,
        )

    def is_due(self, known: KnownPart, scene: records.DropScene) -> bool:
        """Whether an intermediate result for this scene may be latched again by now."""
        return self._settings().scene(known.scene_override) == scene and (
            known.shown is None
            or time.monotonic() - known.shown.published >= SECONDS_BETWEEN
        )

    def offer_result(
        self, known: KnownPart, scene: records.DropScene, message: PoseStatistics
    ) -> None:
        """Remember a result that is better than others for its scene, and latch it in the part's.

        One that is not final is only latched.
        """
        key = self._key(BEST, known, scene)
        best = self._results.get(key)
        if message.final and message.job_id:
            self._results.put(self._key(TRIED, known, scene), message)
        if message.final and (best is None or messages.replaces(message, best)):
            self._results.put(key, message)
        with known.revisions.lock:
            shown = known.shown
            model = known.model_in(scene)
            is_new = shown is None or not (
                message is shown.latched or message is shown.model
            )
            better = (
                is_new
                and self._parts.current(known.part_id) is known
                and self._settings().scene(known.scene_override) == scene
                and (model is None or messages.replaces(message, model))
            )
            if better and (message.final or self.is_due(known, scene)):
                self._latch(known, message, scene)

    def _latch(
        self, known: KnownPart, model: PoseStatistics, scene: records.DropScene
    ) -> None:
        """Show a result under a number above that of the one before, record and keep it."""
        revisions = known.revisions
        at = time.monotonic()
        observed = self._counts.observe(known, model)
        message = (
            model
            if observed is None
            else self.number_result(
                known, observed, self._settings(), final=model.final
            )
        )
        again = message.revision <= revisions.shown
        if again:
            message = copy.copy(message)
            message.revision = revisions.next()
        if (
            known.counts is not None
            and message.method == methods.OBSERVED
            and not (self._state.commit(known.counts.change))
        ):
            message = self._announcer.warn_unrecorded(message)
        recorded = not again or at - revisions.recorded_at >= SECONDS_BETWEEN
        if recorded:  # else `show_waiting` records it
            message = self._announcer.record(POSE_STATISTICS, known, message)
            revisions.recorded_at = at
        revisions.shown = message.revision
        known.shown = Shown(message, model, scene, at, recorded)
        data = serialize_message(message)
        self._announcer.publish_result(known, data)
        beside = serialize_message(model) if message.method == methods.OBSERVED else b""
        self._state.put(
            Change(
                "results",
                known.part_id,
                (known.part_id, data, beside, revisions.newest),
            )
        )

    def _key(self, role: str, known: KnownPart, scene: records.DropScene) -> Key:
        """The key of a role (`BEST`, `CHECKED`, `TRIED` or a method) of a part in a scene."""
        settings = self._settings()
        return (
            role,
            known.part_id,
            known.digest,
            scene,
            settings.plate,
            settings.plate_error,
            settings.plate_frame,
        )


class Stores(NamedTuple):
    """What the node knows of parts, and says of them."""

    parts: part_store.PartStore
    counts: count_store.CountStore
    results: ResultStore
    announcer: announcer.Announcer


def _labelled(
    known: KnownPart, settings: Settings, message: PoseStatistics
) -> PoseStatistics:
    """The same with the present frame and plate; itself if it has them or was counted."""
    if message.method == methods.OBSERVED or (
        message.plate,
        message.header.frame_id,
        message.plate_error,
    ) == (settings.plate, settings.plate_frame, settings.plate_error):
        return message
    named = copy.copy(message)
    named.header = Header(stamp=message.header.stamp, frame_id=settings.plate_frame)
    named.plate, named.plate_error = settings.plate, settings.plate_error
    named.revision = known.revisions.next()
    return named
