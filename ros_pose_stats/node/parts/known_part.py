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

"""A part in the node: mesh, results, publisher, and what was counted of it."""

import copy
import math
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import PoseCounts, PoseStatistics

from ...base import methods, text
from ...core.estimators.estimate import estimate_in
from ...core.mesh import decimation
from ...core.planning import auto
from ...core.records import Array, DropScene, Index, Part
from ...core.records.notes import notes_of
from ...core.records.scene import DEFAULT_SEED, numbering_of
from ...core.resting.poses import resting_poses
from ...core.simulation.request import Watch, drop_request
from ..equipment import Equipment
from ..lanes import Lane, Rank, finished_future
from ..memory import Memory
from ..messages import part_requests, statistics_messages
from ..recorder import PART_MESH, POSE_STATISTICS
from ..refusals import MOST_SWAPS
from ..state import Change
from .channel import Channel
from .part_counts import PartCounts
from .part_results import (
    BEST,
    CHECKED,
    PartResults,
    ResultMemory,
    memory_of_results,
)
from .part_source import PartSource

T = TypeVar("T")

SECONDS_BETWEEN = 1.0  # a part that is being refined is published at most this often
INTRODUCED = 4096  # meshes that are known to be in the bag


@dataclass(eq=False)
class LatchedResult:
    """What a part shows at a time."""

    message: PoseStatistics  # which late joiners get
    # the best estimate or simulation for that scene, before it got another number and
    # was combined with the counts where there are any
    model: PoseStatistics
    scene: DropScene  # that the message is for
    latched_at: float = -math.inf  # by the monotonic clock
    is_recorded: bool = False  # whether it is in the bag


@dataclass(eq=False)
class Commons:
    """What all parts share."""

    equipment: Equipment
    parts: "Callable[[], list[KnownPart]]"  # that the node knows
    results: ResultMemory = field(default_factory=memory_of_results)
    # meshes that a bag has, by their names and digests
    introduced: Memory[tuple[Path, str, str], bool] = field(
        default_factory=lambda: Memory(INTRODUCED)
    )


@dataclass(eq=False)
class KnownPart:
    """A mesh under a name, with a scene of its own, and all that the node has of it."""

    commons: Commons
    channel: "Channel[KnownPart]"
    part_id: str
    digest: str
    content: bytes  # digest of the mesh as it was sent
    # restitution and drop height of the part's own scene; negative: the node's
    scene_override: tuple[float, float]
    source: PartSource
    latched: LatchedResult | None = None
    size: int = 0  # bytes of the mesh as it is stored
    change: int = 0  # number of the change of the state that has it
    # whether the node knows it by its name, which another mesh may have taken
    is_current: bool = False

    def __post_init__(self) -> None:
        self.lock = self.channel.lock
        self._equipment = self.commons.equipment
        self._settings = self.commons.equipment.settings
        self.counts = PartCounts(self._equipment, self.part_id, self.digest)
        self.results = PartResults(
            self.commons.results,
            self._settings,
            self.channel.next_revision,
            self.part_id,
            self.digest,
        )
        # as it was drawn last: the part itself may have left memory
        self._drawn: Array | None = None

    @property
    def geometry(self) -> Part:
        """The part itself. Raises PoseStatsError if it cannot be built."""
        return self.source.get()

    @property
    def is_built(self) -> bool:
        """Whether the part itself is in memory."""
        return self.source.part is not None

    @property
    def can_be_drawn(self) -> bool:
        """Whether it is or was in memory in this run."""
        return self._drawn is not None or self.is_built

    def draw(self, limit: int) -> Array | None:
        """Triangles (t, 3, 3) to draw it by, at most so many."""
        part = self.source.part
        if part is not None:
            self._drawn = decimation.visible_triangles(part, limit)
        elif self._drawn is not None and len(self._drawn) > limit:
            self._drawn = decimation.thin_out(self._drawn, limit)
        return self._drawn

    def change_of_state(self, use: int) -> Change:
        """By which the state has what it is; `use`: number of its last use."""
        restitution, drop_height = map(float, self.scene_override)
        row = (
            self.part_id,
            self.digest,
            self.content,
            restitution,
            drop_height,
            self.size,
            use,
        )
        return Change("parts", self.part_id, row)

    def is_stored(self) -> bool:
        """Whether the state has it on the disk; waits until it has."""
        return self._equipment.state.commit(self.change)

    # What comes of it, and what of that is latched.

    def estimate(self, method: str, scene: DropScene) -> PoseStatistics:
        """An analytic result, from memory if there is one; raises PoseStatsError."""
        settings = self._settings()
        name = part_requests.estimator_name(
            method or settings.default_method, scene.restitution
        )
        message = self.results.get(name, scene)
        if message is None:
            message = self.results.number(
                estimate_in(self.geometry, scene, name), settings
            )
            self.results.put(name, scene, message)
        return message

    def check(self, scene: DropScene) -> PoseStatistics:
        """Check its estimate by some drops, as the library does, and offer the outcome.

        Raises PoseStatsError, and CancelledError where the node ends.
        """
        settings = self._settings()
        message = self.results.get(CHECKED, scene)
        if message is None:
            part = self.geometry
            lanes = self._equipment.lanes
            statistics = auto.answer_with_drops(
                estimate_in(part, scene, methods.AUTO),
                part,
                scene,
                drop_request(auto.MOST_DROPS, DEFAULT_SEED, 0.0, settings.threads()),
                Watch(None, lambda: lanes.is_closed, background=True),
            )
            if lanes.is_closed:
                raise CancelledError
            message = self.results.number(statistics, settings)
            self.results.put(CHECKED, scene, message)
        if settings.default_method == methods.AUTO:
            self.offer_result(scene, message)
        return message

    def lacks_check(self) -> bool:
        """Whether an estimate alone is latched where a checked one should be."""
        settings = self._settings()
        scene = settings.scene(self.scene_override)
        model = self.model_in(scene)
        return (
            settings.default_method == methods.AUTO
            and self.results.get(CHECKED, scene) is None
            and not (model is not None and model.drops)
        )

    def model_in(self, scene: DropScene) -> PoseStatistics | None:
        """The model behind what is latched, where that is for this scene."""
        latched = self.latched
        return latched.model if latched is not None and latched.scene == scene else None

    def offer_result(self, scene: DropScene, message: PoseStatistics) -> None:
        """Remember the best result of a scene, and latch it if that is the part's own.

        One that is not final is only latched.
        """
        if message.final:
            self.results.put_final(scene, message)
        with self.lock:
            if self._is_better(message, scene) and (
                message.final or self.is_due(scene)
            ):
                self._latch(message, scene)

    def _is_better(self, message: PoseStatistics, scene: DropScene) -> bool:
        """Whether a result is to take the place of what is latched."""
        latched = self.latched
        if latched is not None and (
            message is latched.message or message is latched.model
        ):
            return False
        if not (self.is_current and self._is_present(scene)):
            return False
        if self.counts.lack_comparison(message):
            return False  # it is shown again once it is compared
        model = self.model_in(scene)
        return model is None or statistics_messages.replaces(message, model)

    def is_due(self, scene: DropScene) -> bool:
        """Whether an intermediate result for this scene may be latched again by now."""
        latched = self.latched
        return self._is_present(scene) and (
            latched is None or time.monotonic() - latched.latched_at >= SECONDS_BETWEEN
        )

    def _is_present(self, scene: DropScene) -> bool:
        """Whether a scene is the part's own in the present settings."""
        return self._settings().scene(self.scene_override) == scene

    def show_best(self) -> None:
        """Latch the best that is known for the present scene, at least an estimate."""
        settings = self._settings()
        scene = settings.scene(self.scene_override)
        best = self.results.get(BEST, scene)
        if best is not None:
            self.offer_result(scene, best)
        with self.lock:  # so that nothing comes in between
            model = self.model_in(scene)
            if model is not None:
                model = self.results.relabel(settings, model)
                if model.drops and not model.job_id:
                    self.results.put(CHECKED, scene, model)
                self.offer_result(scene, model)
        message = None
        if settings.default_method == methods.AUTO:
            message = self.results.get(CHECKED, scene)
        self.offer_result(scene, message or self.estimate("", scene))

    def _latch(self, model: PoseStatistics, scene: DropScene) -> None:
        """Show a result under a higher number than the last; record and store it."""
        channel = self.channel
        now = time.monotonic()
        combined = self.counts.combine(model, self._evidence_of_others)
        message = model
        if combined is not None:
            message = self.results.number(combined, self._settings(), final=model.final)
        is_repeated = message.revision <= channel.latched_revision
        if is_repeated:
            message = copy.copy(message)
            message.revision = channel.next_revision()
        is_observed = message.method == methods.OBSERVED
        if is_observed and not self.counts.commit():
            message = self._equipment.warn_unrecorded(message)
        is_recorded = not is_repeated or now - channel.recorded_at >= SECONDS_BETWEEN
        if is_recorded:  # else `show_waiting` records it
            message = self.record(POSE_STATISTICS, message)
            channel.recorded_at = now
        channel.latched_revision = message.revision
        self.latched = LatchedResult(message, model, scene, now, is_recorded)
        data = serialize_message(message)
        channel.publish(data, self)
        self._equipment.node.get_logger().debug(
            f"{self.part_id}: revision {message.revision} latched, by {message.method} "
            f"with {message.drops} drops"
        )
        model_data = serialize_message(model) if is_observed else b""
        row = (self.part_id, data, model_data, channel.newest_revision)
        self._equipment.state.put(Change("results", self.part_id, row))

    def show_waiting(self) -> None:
        """Show what was counted, and record what was not when it was latched again."""
        with self.lock:
            latched = self.latched
            if latched is None or not self.is_current:
                return
            counted = self.counts.parts_counted_for(latched.model)
            is_news = counted not in (0, latched.message.counted_parts)
            if is_news and not self.counts.lack_comparison(latched.model):
                self._latch(latched.model, latched.scene)
            elif not latched.is_recorded and self.channel.recorded_at > -math.inf:
                latched.is_recorded = True
                self.record(POSE_STATISTICS, latched.message)

    def withdraw_result(self, stamp: int, reason: str) -> None:
        """Tell present subscribers that the part is forgotten."""
        # Another mesh of the name, if this one shows nothing yet.
        last = self.channel.part
        if last is None or last.latched is None:
            return
        farewell = statistics_messages.farewell_message(
            last.latched.message, stamp, self.channel.next_revision(), reason
        )
        data = serialize_message(farewell)
        self._equipment.recorder.record(POSE_STATISTICS, data)
        self.channel.publish(data, None)

    def restore(self) -> None:
        """Latch what an earlier run has latched, if it holds in the present scene."""
        self.counts.restore()
        row = self._equipment.state.get("results", self.part_id)
        if row is None:
            return
        channel = self.channel
        _, data, model_data, channel.newest_revision = row
        channel.latched_revision = channel.newest_revision
        settings = self._settings()
        scene = settings.scene(self.scene_override)
        try:
            message = deserialize_message(data, PoseStatistics)
            model = message
            if model_data:
                model = deserialize_message(model_data, PoseStatistics)
        except Exception:  # of the bindings: then it is estimated anew
            return
        if (
            message.part_digest != self.digest
            or not statistics_messages.holds_for_scene(model, scene)
        ):
            return
        with self.lock:
            message.final = True  # nothing is going to refine it any more
            model = self.results.relabel(settings, model)
            if not model_data:
                message = model
            channel.newest_revision = max(channel.newest_revision, message.revision)
            channel.latched_revision = channel.newest_revision
            if not self.counts.lack_comparison(model):  # else it is shown once built
                self._latch_again(message, model, scene)
        self.results.put_restored(scene, model)

    def _latch_again(
        self, message: PoseStatistics, model: PoseStatistics, scene: DropScene
    ) -> None:
        """Show what an earlier run has latched, anew if it says something else now."""
        self.latched = LatchedResult(message, model, scene, time.monotonic())
        is_observed = message.method == methods.OBSERVED
        observed = message.counted_parts if is_observed else 0
        if self.counts.parts_counted_for(model) != observed or (
            is_observed and message.header.frame_id != self._settings().plate_frame
        ):
            self._latch(model, scene)
        else:
            self.channel.publish(serialize_message(message), self)

    # What cameras counted of it.

    def compare_counts(self, geometry: Part) -> None:
        """Find out, by the part itself, how what was counted fits the present scene.

        That comes before a result is shown, and is no work for a callback.
        """
        numbering = numbering_of(self._settings().scene(self.scene_override))
        with self.lock:
            others = self.counts.other_numberings(numbering)
        for other in others:  # while nobody waits for the lock
            resting_poses(geometry, *other)
        with self.lock:
            self.counts.compare(geometry, numbering)

    def add_counts(self, message: PoseCounts) -> bool:
        """Learn what a camera counted of what is latched; false for what came before.

        The lock is held since the two were compared.
        """
        assert self.latched is not None
        return self.counts.add(message, self.latched.message)

    def find_flips(self, message: PoseStatistics, setting: str) -> Index:
        """Flips (K, K) counted at a setting on a result's ground; or NotFoundError."""
        with self.lock:
            flips = self.counts.flips_at(message, setting)
        self.counts.commit()
        return flips

    def _evidence_of_others(self, plate: str) -> Iterator[Array]:
        """What the other parts that were counted on a plate say of its error."""
        for part in self.commons.parts():
            latched = part.latched
            if part is not self and latched is not None:
                evidence = part.counts.evidence_on(plate, latched.model)
                if evidence is not None:
                    yield evidence

    # What of it is in the bag and in the log.

    def record(self, topic: str, message: PoseStatistics) -> PoseStatistics:
        """Record a result before anybody has it; the same, warning if that fails."""
        self.introduce()
        if self._equipment.recorder.record(topic, serialize_message(message)):
            return message
        return self._equipment.warn_unrecorded(message)

    def once_introduced(self, act: Callable[[], T]) -> Future[T]:
        """Do what puts something on record, in a lane where the bag lacks the mesh.

        To read that is no work for a callback. The future is cancelled at the end of
        the node, and has a BusyError where too many wait.
        """
        if self._is_introduced():
            return finished_future(act())
        return self._equipment.lanes.put(act, Rank.KNOWN_PART, Lane.RECORD)

    def _is_introduced(self) -> bool:
        """Whether the bag has the mesh."""
        key = self._equipment.recorder.bag, self.part_id, self.digest
        return self.commons.introduced.get(key) is not None

    def introduce(self) -> None:
        """Record the mesh once a bag, and what is latched if it is not recorded yet."""
        if self._is_introduced():
            return
        message = self.source.mesh()  # while nobody waits for the lock
        recorder = self._equipment.recorder
        with self.lock:
            if self._is_introduced():  # another thread was at it
                return
            if message is None or not recorder.record(PART_MESH, message):
                return
            # The bag may be a new one by now, and this its first record.
            key = recorder.bag, self.part_id, self.digest
            self.commons.introduced.put(key, True)
            latched = self.latched
            if latched is not None and not latched.is_recorded:
                latched.is_recorded = recorder.record(
                    POSE_STATISTICS, serialize_message(latched.message)
                )

    def log_arrival(self, geometry: Part) -> None:
        """Log what has come, so that a wrong unit is seen; of a flood not all."""
        floods = self._equipment.refusals.floods
        name = part_requests.quote_text(self.part_id)
        is_usual_for_it = floods.count(f"meshes of part {name}", MOST_SWAPS)
        is_usual = floods.count("new parts")
        if not (is_usual and is_usual_for_it) or self.latched is None:
            return
        log = self._equipment.node.get_logger()
        message = self.latched.message
        log.info(
            f"{part_requests.part_line(geometry)}, "
            f"{len(message.poses)} stable poses "
            f"({text.most_probable(message.poses)} % by {message.method}); "
            f"bag {self._equipment.recorder.log.directory}"
        )
        for warning in notes_of(message):
            is_of_part = warning in geometry.warnings
            if warning.acts and (is_of_part or warning.code == "HEIGHT_SUSPECT"):
                log.warning(f"{self.part_id}: {warning}")
