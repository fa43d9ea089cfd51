"""The results of the parts, and which one of them each part shows."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PoseCounts, PoseStatistics

from ... import records
from ...errors import PoseStatsError
from ...estimators.estimate import estimate_in
from ...methods import OBSERVED
from ...planning.confidence import observe_counts
from ...recording.analysis.decoding import numbering_of
from ...records import DropScene
from ..messages.statistics_messages import (
    Answer,
    copied,
    statistics_message,
    statistics_of_message,
)
from ..messages.times import now
from ..settings import Settings
from .announcer import Announcer, Recorded
from .cell_counts import CellCounts, Ground, counts_of_result
from .memory import Memory
from .part_requests import PartRequest, check_request, estimator_name
from .part_store import KnownPart, PartStore
from .result_rules import known_error, labelled, replaces, still_true

REMEMBERED_POSES = 20_000
"""Poses of results kept for parts and scenes that come again; some 2 kB each."""

SECONDS_BETWEEN = 1.0
"""A part that is being refined is published at most this often."""

BEST = "best"
"""What was latched last for a scene; it is latched at once where the scene comes again."""

REFINED = "refined"
"""The best drops that refined an estimate, in any scene; they answer whoever asks again."""


class Key(NamedTuple):
    """What a result is remembered as, `BEST`, `REFINED` or by its method, and what it is of."""

    role: str
    part_id: str
    digest: str
    scene: DropScene
    plate: str
    plate_error: float
    plate_frame: str


def live_size(known: KnownPart) -> int:
    """Bytes that a part and what is latched for it take in a bag, names aside."""
    request = known.request
    mesh = 0 if request is None else request.vertices.nbytes + request.triangles.nbytes
    return mesh + known.latched_bytes


class ResultStore:
    """Estimates, numbers and remembers results, and latches the best one of each part.

    Attributes `on_shown`: told each `KnownPart` once its best result is latched after it, or a
    parameter, is new.
    """

    def __init__(self, settings: Callable[[], Settings], parts: PartStore,
                 announcer: Announcer) -> None:
        self._settings = settings
        self.parts = parts
        self.announcer = announcer
        self.recorder = announcer.recorder
        self._waiting: dict[str, KnownPart] = {}
        self._counted: dict[str, KnownPart] = {}
        self.on_shown: Callable[[KnownPart], object] = lambda known: None
        self._results: Memory[Key, PoseStatistics] = Memory(
            REMEMBERED_POSES, lambda message: len(message.poses))

    def take_part(self, request: PartRequest, last: PoseStatistics | None = None, *,
                  recorded: bool = False, newest: bool = True) -> KnownPart:
        """Make a received mesh a known part, estimated and latched.

        A copy of what is known is ignored; one that was refused is refused again at once.

        `last`: what was latched for it in the last run; `recorded`: whether that stands for this
        run too, if it holds; `newest`: whether it takes the place of a known part of its name.
        Raises PoseStatsError with one line that says what is wrong.
        """
        settings = self._settings()
        check_request(request, settings.max_mesh_bytes)
        scene = settings.scene((request.restitution, request.drop_height))
        known, new = self.parts.resolve(request)
        restored = self._restore_result(known, last, scene)
        if recorded:
            known.on_record = restored
        if new:
            self.estimate(known, "", scene)  # what has no equilibrium is no part
            there = self.parts.put(known, settings.max_parts, settings.max_part_bytes,
                                   newest=newest)
            if there is not known:
                return there
            self.show_best(known, restored)
            self.announcer.announce_part(known)
        elif restored is not None:
            self.offer_results(known, scene, [restored])
        return known

    def relabel(self, last: PoseStatistics) -> PoseStatistics:
        """A result of the last run with the present plate and frame."""
        return labelled(last, self._settings())

    def holds(self, last: PoseStatistics, override: tuple[float, float]) -> bool:
        """Whether a result of the last run is one of the present scene of its part."""
        with suppress(PoseStatsError):  # of an override that holds no more
            return still_true(last, self._settings().scene(override))
        return False

    def _restore_result(self, known: KnownPart, last: PoseStatistics | None,
                        scene: DropScene) -> PoseStatistics | None:
        """Remember a result of the last run, if it still holds."""
        if last is None:
            return None
        with known.revisions.lock:
            known.revisions.newest = max(known.revisions.newest, last.revision)
        if last.part_digest == known.part.digest and known.counts is None:
            known.counts = counts_of_result(last)
        if (last.part_digest != known.part.digest or last.method == OBSERVED
                or not still_true(last, scene)):
            return None
        if not last.drops:
            self._results.put(self._key(last.method, known, scene), last)
        return last

    def record_again(self) -> None:
        """Put parts and what is latched for them on record where the bag may not have them.

        A mesh is followed by its result, which tells its digest. Parts that are too large to be
        recorded again and again go with the files of this run; meshes of earlier runs are
        recorded once in any case.
        """
        meshes, parts = self.parts.meshes, self.parts.all()
        may_repeat = self.recorder.has_room_for(sum(map(live_size, parts)))
        for known in parts:
            with known.revisions.lock:
                if self.recorder.closing or self.parts.current(known.part.part_id) is not known:
                    continue
                if meshes.holds(known) and known.mark >= self.recorder.trusted_from:
                    continue
                if may_repeat or known.mark < 0 or meshes.must_move(known):
                    meshes.record(known)
                    self._record_latched(known)
        meshes.leave_runs(self.parts.all())

    def add_counts(self, known: KnownPart, counts: PoseCounts) -> None:
        """Learn from what a camera counted, if on this plate; `record_waiting` shows it.

        `counts`: of its poses as they are numbered now.
        """
        if counts.plate not in ("", self._settings().plate):
            return
        ground = self._ground(counts)
        with known.revisions.lock:
            if known.latched is None:
                return
            if known.counts is None or known.counts.ground != ground:
                known.counts = CellCounts(ground, np.zeros(len(known.latched.poses), np.int64))
            if known.counts.add(counts):
                self._counted[known.part.part_id] = known

    def _ground(self, message: PoseCounts | PoseStatistics) -> Ground:
        return Ground(numbering_of(message), self._settings().plate)

    def _show_counts(self) -> None:
        """Latch what cameras have counted since it was latched last."""
        for part_id in list(self._counted):
            known = self._counted.pop(part_id)
            with known.revisions.lock:
                if (self.parts.current(part_id) is known and known.model is not None
                        and known.scene is not None):
                    self._latch(known, known.model, known.scene)

    def record_waiting(self) -> None:
        """Show what was counted, and put on record what was not when it was latched again."""
        self._show_counts()
        for part_id in list(self._waiting):
            known = self._waiting.get(part_id)
            if known is None:
                continue
            with known.revisions.lock:
                if self._waiting.get(part_id) is known:
                    del self._waiting[part_id]
                    if self.parts.current(part_id) is known:
                        self._record_latched(known)

    def _record_latched(self, known: KnownPart) -> None:
        """Put what is latched for a part on record as it was published."""
        if known.latched is not None:
            known.mark = self.announcer.record_result(known.latched).mark

    def show_best(self, known: KnownPart, restored: PoseStatistics | None = None) -> None:
        """Latch the best that is known for the part's present scene, at least an estimate."""
        scene = self._settings().scene(known.scene_override)
        self.offer_results(known, scene, self._candidates(known, scene, restored))
        self.on_shown(known)

    def _candidates(self, known: KnownPart, scene: DropScene,
                    restored: PoseStatistics | None) -> Iterator[PoseStatistics]:
        """All that could be shown of a part; each is looked up when those before were offered."""
        if restored is not None:
            yield restored
        best = self._results.get(self._key(BEST, known, scene))
        if best is not None:
            yield best
        with known.revisions.lock:  # until it is offered, so that nothing comes in between
            if known.model is not None and known.scene == scene:
                yield labelled(known.model, self._settings())
        yield self.estimate(known, "", scene)

    def estimate(self, known: KnownPart, method: str, scene: DropScene) -> PoseStatistics:
        """An analytic result, from memory where it was asked for before.

        Raises
        ------
        PoseStatsError
            If the method is unknown, or the part has no equilibrium.
        """
        settings = self._settings()
        name = estimator_name(method or settings.default_method, scene.restitution)
        key = self._key(name, known, scene)
        found = self._results.get(key)
        if found is None:
            found = self.number_result(known, estimate_in(known.part, scene, name), settings)
            self._results.put(key, found)
        return found

    def keep_refinement(self, known: KnownPart, message: PoseStatistics,
                        scene: DropScene) -> None:
        """Remember drops that refined an estimate, for whoever asks again, in any scene."""
        key = self._key(REFINED, known, scene)
        before = self._results.get(key)
        if before is None or replaces(message, before):
            self._results.put(key, message)

    def find_drops(self, known: KnownPart, scene: DropScene) -> PoseStatistics | None:
        """The best end result of drops that is remembered for a scene."""
        found = [self._results.get(self._key(role, known, scene)) for role in (REFINED, BEST)]
        ended = [one for one in found if one is not None and one.drops and one.final]
        return min(ended, key=known_error, default=None)

    def number_result(self, known: KnownPart, found: records.PoseStatistics, settings: Settings,
                      job_id: str = "", final: bool = True,
                      warnings: tuple[str, ...] = ()) -> PoseStatistics:
        """Make the message of a new result of a part, with the error of the settings' plate."""
        if found.method != OBSERVED:
            found = replace(found, plate_error=settings.plate_error)
        return statistics_message(found, Answer(now(), settings.plate_frame, settings.plate,
                                                known.revisions.next(), job_id, final, warnings))

    def is_due(self, known: KnownPart, scene: DropScene) -> bool:
        """Whether an intermediate result for this scene may be latched again by now."""
        return (self._settings().scene(known.scene_override) == scene
                and time.monotonic() - known.published >= SECONDS_BETWEEN)

    def offer_results(self, known: KnownPart, scene: DropScene,
                      candidates: Iterable[PoseStatistics]) -> None:
        """Latch, one after the other, the results that are better than what is latched."""
        for message in candidates:
            with known.revisions.lock:
                better = self._is_better(known, message, scene)
                if better:
                    self._latch(known, message, scene)
            if better:
                self._results.put(self._key(BEST, known, scene), message)

    def _is_better(self, known: KnownPart, message: PoseStatistics, scene: DropScene) -> bool:
        """Whether a result is to take the place of what a part shows of its present scene."""
        if self.parts.current(known.part.part_id) is not known or (
                message is known.latched or message is known.model):
            return False
        if self._settings().scene(known.scene_override) != scene:
            return False
        if (known.scene == scene and known.model is not None
                and not replaces(message, known.model)):
            return False
        return message.final or self.is_due(known, scene)

    def _latch(self, known: KnownPart, message: PoseStatistics, scene: DropScene) -> None:
        """Show a result under a number above that of the one before, and put it on record.

        One that is latched again, because meshes change places, is put on record at most once
        a second; the last one always, by `record_waiting`.
        """
        known.model = message
        message = self._observe(known, message)
        at, revisions, origin = time.monotonic(), known.revisions, message
        if message.revision <= revisions.shown:
            message = copied(message)
            message.revision = revisions.next()
        revisions.shown = message.revision
        again = origin is not message and origin.revision in revisions.recorded
        if (again and not known.mesh_is_last
                and at - revisions.recorded_at < SECONDS_BETWEEN):
            self._waiting[known.part.part_id] = known
            found = Recorded(message, serialize_message(message), -1)
        else:
            self._waiting.pop(known.part.part_id, None)
            found = self.announcer.record_result(message, message is known.on_record)
            revisions.recorded_at, known.mesh_is_last = at, False
            if found.mark >= 0 and not again:
                revisions.recorded.append(origin.revision)
        known.mark, known.latched = found.mark, found.message
        known.latched_bytes = len(found.data)
        known.scene, known.published = scene, at
        self.announcer.publish_result(known.part, found.message, found.data)

    def _observe(self, known: KnownPart, message: PoseStatistics) -> PoseStatistics:
        """A result of the model combined with what was counted; itself where nothing was."""
        counts = known.counts
        if counts is None:
            return message
        ground = self._ground(message)
        if counts.ground != ground and counts.ground.goes_on_as(ground, known.part):
            counts.ground = ground
        if counts.ground != ground:
            return message
        found = observe_counts(statistics_of_message(message), counts.total)
        if found.method != OBSERVED:
            return message
        return self.number_result(known, found, self._settings(), final=message.final)

    def _key(self, role: str, known: KnownPart, scene: DropScene) -> Key:
        settings = self._settings()
        return Key(role, known.part.part_id, known.part.digest, scene, settings.plate,
                   settings.plate_error, settings.plate_frame)
