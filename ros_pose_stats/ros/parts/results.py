"""Parts in, results out: what is known, estimated, latched and put on record."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PoseStatistics
from std_msgs.msg import Header

from ... import records
from ...errors import PoseStatsError
from ...estimators import estimate
from ...records import DropScene
from ...records.part import digest_name
from ...simulation.drops import release_height
from ...version import VERSION
from ..messages.statistics_messages import Answer, copied, statistics_message, with_warning
from ..messages.times import now
from ..methods import estimator_name
from ..recorder import ANSWERS, POSE_STATISTICS, Recorder
from ..settings import Settings
from .catalogue import Catalogue, KnownPart
from .latching import LatchedPublishers, known_error, replaces
from .memory import Memory
from .part_builder import PartBuilder
from .part_log import PartLog
from .part_requests import PartRequest, check_request

REMEMBERED = 1024
"""Forgotten parts whose revisions go on where they come again."""

REMEMBERED_POSES = 20_000
"""Poses of results kept for parts and scenes that come again; some 2 kB each."""

SECONDS_BETWEEN = 1.0
"""A part that is being refined is published at most this often."""

NOT_RECORDED = "NOT_RECORDED: this could not be written to the bag: {}."


class Results:
    """All that the node knows of parts.

    Parameters
    ----------
    settings : callable
        Gives the present `Settings`.
    recorder : Recorder
    publishers : LatchedPublishers
    on_part : callable
        Told each `KnownPart` once it is estimated.
    on_new_part : callable
        Told each `KnownPart` that has come, once.
    on_change : callable
        Called when what is latched has changed.
    """

    def __init__(self, settings: Callable[[], Settings], recorder: Recorder,
                 publishers: LatchedPublishers, on_part: Callable[[KnownPart], object],
                 on_new_part: Callable[[KnownPart], object],
                 on_change: Callable[[], object]) -> None:
        self._settings = settings
        self._recorder = recorder
        self._publishers = publishers
        self._on_part = on_part
        self._on_new_part = on_new_part
        self._on_change = on_change
        self._builder = PartBuilder()
        self._memory: Memory[tuple[Any, ...], PoseStatistics] = Memory(
            REMEMBERED_POSES, lambda message: len(message.poses))
        self._revisions: Memory[str, int] = Memory(REMEMBERED)
        self._part_log = PartLog(recorder)
        self.parts = Catalogue(self._withdraw)

    def take(self, request: PartRequest, last: PoseStatistics | None = None) -> KnownPart:
        """Make a received mesh a known part, estimated and latched.

        A copy of what is known is ignored; one that was refused is refused again at once.

        Parameters
        ----------
        request : PartRequest
        last : PoseStatistics, optional
            What was latched for it in the last run.

        Raises
        ------
        PoseStatsError
            With one line that says what is wrong.
        """
        settings = self._settings()
        check_request(request, settings.max_mesh_bytes)
        override = (request.restitution, request.drop_height)
        scene = settings.scene(override)
        before = self._same(request.part_id, request.content)
        part = self._builder.build(request) if before is None else before.part
        old = self.parts.find(part.part_id)
        if old is not None and (old.part.digest, old.scene_override) == (part.digest, override):
            if self._bring_back(old, last, scene):
                self.offer(old, old.restored, scene)
            return old
        known = KnownPart(part, request.content, override, request,
                          revision=self._revision(part.part_id, old))
        restored = self._bring_back(known, last, scene)
        self.estimate(known, "", scene)  # before anybody can see it: what has no equilibrium
        self._put(known, old)  # is no part
        if restored:
            self.offer(known, known.restored, scene)
        self.refresh(known)
        self._on_new_part(known)
        return known

    def _put(self, known: KnownPart, old: KnownPart | None) -> None:
        """Remember and record a part, with no result of the old one between the two."""
        with known.lock if old is None else old.lock:
            before = self._revision(known.part.part_id, old)
            known.revision = max(known.revision, before)
            known.shown = before if old is None else old.shown
            self._log_part(known)
            self.parts.put(known, self._settings().max_parts)

    def _revision(self, part_id: str, old: KnownPart | None) -> int:
        """Of the newest result under a name, also of a part that was forgotten."""
        return (self._revisions.get(part_id) or 0) if old is None else old.revision

    def _log_part(self, known: KnownPart) -> None:
        if known.request is not None:
            self._part_log.note(known.request, known.part.part_id, known.part.digest)

    def record_again(self) -> None:
        """Put all parts and what is latched for them on record, after a gap in it."""
        self._part_log.begin_again()
        for known in self.parts.all():
            with known.lock:
                self._log_part(known)
                if known.latched is not None:
                    self._recorder.record(POSE_STATISTICS, serialize_message(known.latched))

    def take_over(self, request: PartRequest,
                  last: PoseStatistics | None) -> PoseStatistics | None:
        """Put a part of the last run on record, with what was latched if that still holds.

        Returns
        -------
        PoseStatistics or None
            What was latched, for `take`, which makes the part known.
        """
        if last is None:
            return None
        last = self._labelled(last, self._settings())
        self._part_log.note(request, request.part_id, last.part_digest)
        with suppress(PoseStatsError):  # of an override that holds no more
            scene = self._settings().scene((request.restitution, request.drop_height))
            if self._still_true(last, scene):
                self._recorder.record(POSE_STATISTICS, serialize_message(last))
        return last

    def _bring_back(self, known: KnownPart, last: PoseStatistics | None,
                    scene: DropScene) -> bool:
        """Remember a result of the last run, which is on record already, if it still holds."""
        if last is None:
            return False
        with known.lock:
            known.revision = max(known.revision, last.revision)
        if last.part_digest != known.part.digest or not self._still_true(last, scene):
            return False
        known.restored = last
        if not last.drops:
            self._memory.put(self._key(last.method, known, scene), last)
        return True

    @staticmethod
    def _still_true(last: PoseStatistics, scene: DropScene) -> bool:
        """Whether a result of the last run holds for its part in the present scene."""
        if (last.version, last.restitution, last.cluster_tolerance) != (
                VERSION, scene.restitution, scene.cluster_tolerance):
            return False
        released = release_height(scene, last.radius)
        return math.isnan(last.drop_height) or math.isclose(last.drop_height, released)

    def refresh(self, known: KnownPart) -> None:
        """Latch the best that is known for the part's present scene, at least an estimate."""
        settings = self._settings()
        scene = settings.scene(known.scene_override)
        best = self._memory.get(self._key("best", known, scene))
        if best is not None:
            self.offer(known, best, scene)
        self._label_again(known, scene, settings)
        self.offer(known, self.estimate(known, "", scene), scene)
        self._on_part(known)

    def _label_again(self, known: KnownPart, scene: DropScene, settings: Settings) -> None:
        """Give what is latched for the scene the present names of plate and frame."""
        with known.lock:
            if known.latched is not None and known.scene == scene:
                self.offer(known, self._labelled(known.latched, settings), scene)

    @staticmethod
    def _labelled(message: PoseStatistics, settings: Settings) -> PoseStatistics:
        """The same with the present names; itself if it has them."""
        if (message.plate, message.header.frame_id) == (settings.plate, settings.plate_frame):
            return message
        named = copied(message)
        named.header = Header(stamp=message.header.stamp, frame_id=settings.plate_frame)
        named.plate = settings.plate
        named.revision += 1
        return named

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
        found = self._memory.get(key)
        if found is None:
            statistics = estimate(
                known.part, name, restitution=scene.restitution, drop_height=scene.drop_height,
                cluster_tolerance=scene.cluster_tolerance)
            found = self.message(known, statistics, settings)
            self._memory.put(key, found)
        return found

    def keep(self, known: KnownPart, message: PoseStatistics, scene: DropScene) -> None:
        """Remember drops that refined an estimate, for whoever asks again, in any scene."""
        key = self._key("refined", known, scene)
        before = self._memory.get(key)
        if before is None or replaces(message, before):
            self._memory.put(key, message)

    def dropped(self, known: KnownPart, scene: DropScene) -> PoseStatistics | None:
        """The best end result of drops that is remembered for a scene."""
        found = [self._memory.get(self._key(name, known, scene)) for name in ("refined", "best")]
        ended = [one for one in found if one is not None and one.drops and one.final]
        return min(ended, key=known_error, default=None)

    def message(self, known: KnownPart, found: records.PoseStatistics, settings: Settings,
                job_id: str = "", final: bool = True,
                warnings: tuple[str, ...] = ()) -> PoseStatistics:
        """Make the message of a new result of a part."""
        with known.lock:
            known.revision += 1
            revision = known.revision
        return statistics_message(found, Answer(now(), settings.plate_frame, settings.plate,
                                                revision, job_id, final, warnings))

    def answer(self, message: PoseStatistics, *, durable: bool = True) -> PoseStatistics:
        """Put an answer on record before it goes to a caller; warn where that fails."""
        if self._recorder.record(ANSWERS, serialize_message(message), durable=durable):
            return message
        return self.unrecorded(message)

    def unrecorded(self, message: PoseStatistics) -> PoseStatistics:
        """The same with the warning that it is not on record, which it has once."""
        if any(warning.startswith("NOT_RECORDED:") for warning in message.warnings):
            return message
        return with_warning(message, self.not_recorded())

    def not_recorded(self) -> str:
        """The warning of an answer that could not be put on record."""
        return NOT_RECORDED.format(self._recorder.last_problem)

    def due(self, known: KnownPart, scene: DropScene) -> bool:
        """Whether an intermediate result for this scene may be latched again by now."""
        return (self._settings().scene(known.scene_override) == scene
                and time.monotonic() - known.published >= SECONDS_BETWEEN)

    def offer(self, known: KnownPart, message: PoseStatistics, scene: DropScene) -> None:
        """Latch a result for the part's present scene unless a better one is latched."""
        settings = self._settings()
        with known.lock:
            if self.parts.current(known.part.part_id) is not known:
                return
            if settings.scene(known.scene_override) != scene:
                return
            if (known.scene == scene and known.latched is not None
                    and not replaces(message, known.latched)):
                return
            if message is known.latched:
                return
            if not message.final and time.monotonic() - known.published < SECONDS_BETWEEN:
                return
            self._latch(known, message, scene)
        self._memory.put(self._key("best", known, scene), message)
        self._on_change()

    def _latch(self, known: KnownPart, message: PoseStatistics, scene: DropScene) -> None:
        if message.revision <= known.shown:
            known.revision += 1
            message = copied(message)
            message.revision = known.revision
        known.shown = message.revision
        data = serialize_message(message)
        recorded = message is known.restored or self._recorder.record(POSE_STATISTICS, data)
        if not recorded:
            message = self.unrecorded(message)
            data = serialize_message(message)
        known.latched, known.scene, known.published = message, scene, time.monotonic()
        self._publishers.publish(known.part.part_id, data)

    def _same(self, part_id: str, content: bytes) -> KnownPart | None:
        """The known part of this name and mesh; by the mesh alone where there is no name."""
        if part_id:
            known = self.parts.find(part_id)
            return known if known is not None and known.content == content else None
        for known in self.parts.all():
            if known.content == content and known.part.part_id == digest_name(known.part.digest):
                return self.parts.find(known.part.part_id)
        return None

    def _withdraw(self, known: KnownPart) -> None:
        with known.lock:  # what is being latched is withdrawn afterwards
            self._publishers.withdraw(known.part.part_id)
            self._revisions.put(known.part.part_id, known.revision)
        self._on_change()

    def _key(self, name: str, known: KnownPart, scene: DropScene) -> tuple[Any, ...]:
        """Under which a result is remembered."""
        settings = self._settings()
        return (name, known.part.part_id, known.part.digest, scene, settings.plate,
                settings.plate_frame)
