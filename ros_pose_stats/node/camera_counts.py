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

"""What cameras count on `~/pose_counts`, and see on `~/observed_parts`, is learnt."""

import math
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import CancelledError, Future
from contextlib import nullcontext
from functools import partial
from itertools import groupby
from typing import Any, TypeVar

import numpy as np
from rclpy import callback_groups, event_handler, qos, serialization
from ros_pose_stats_msgs.msg import ObservedParts, PoseCounts

from ..base.errors import RequestError
from ..core.records import DropScene, Part
from ..core.resting.observed_orientations import classify_orientations
from .equipment import Equipment
from .lanes import result_or_refusal
from .memory import Memory
from .messages import part_messages, part_requests, times
from .messages.codes import BusyError, describe_error
from .parts.known_part import KnownPart
from .parts.registry import PartRegistry
from .recorder import POSE_COUNTS
from .refusals import COUNTS, MINUTE, SequenceGaps

M = TypeVar("M")
Received = list[tuple[bytes, Mapping[str, int]]]  # messages with rclpy's infos

# of a camera's message: counts of some 80 000 poses, or some 16 000 parts
MOST_BYTES = 2**20
DEPTH = 1000  # messages that wait in the middleware
MOST_AT_ONCE = 2**22  # bytes of messages of a kind that are taken together
GATHER_SECONDS = 0.02  # in which messages gather that are taken together
POLL_SECONDS = 0.001  # between looks whether a callback has ended
OVERHEAD = 1000  # bytes of a message beside its own, decoded and on its way


class BatchSubscription:
    """Hands over messages that come together, each publisher's in their order."""

    def __init__(
        self,
        equipment: Equipment,
        kind: type,
        name: str,
        noun: str,
        hand_over: Callable[[list[bytes]], object],
    ) -> None:
        self._log = equipment.node.get_logger()
        self._floods = equipment.refusals.floods
        self._kind = kind
        self._topic = equipment.node.full_name(name)
        self._noun = noun
        self._hand_over = hand_over
        self._count_lost = partial(equipment.refusals.count_lost, COUNTS)
        self._gaps = SequenceGaps()
        self._warned_at = -math.inf
        self._received: Memory[tuple[int, int, int], bool] = Memory(4 * DEPTH)
        # Who executes in it has all to himself, from before a message is taken.
        self._group = callback_groups.MutuallyExclusiveCallbackGroup()
        subscribe = partial(
            equipment.node.create_subscription,
            kind,
            f"~/{name}",
            raw=True,
            callback_group=self._group,
        )
        self._reliable: Any = subscribe(
            lambda data, info: self._take_with([(data, info)], []),
            DEPTH,
            event_callbacks=event_handler.SubscriptionEventCallbacks(
                incompatible_qos=lambda info: None
            ),
        )
        self._unreliable: Any = subscribe(
            lambda data, info: self._take_with([], [(data, info)]),
            qos.QoSProfile(depth=DEPTH, reliability=qos.ReliabilityPolicy.BEST_EFFORT),
        )

    def take_last(self) -> None:
        """Hand over what the middleware still has, in place of all later callbacks."""
        while not self._group.beginning_execution(self._reliable):
            time.sleep(POLL_SECONDS)
        taken = 0
        while taken < 2 * DEPTH and (batch := self._take_all([], [])):
            taken += batch

    def _take_with(self, reliable: Received, unreliable: Received) -> None:
        """Hand over a message with those that come in the next moment.

        Each callback makes the executor look at all entities of the node, which takes
        the interpreter longer than a message does.
        """
        time.sleep(GATHER_SECONDS)
        self._take_all(reliable, unreliable)

    def _take_all(self, reliable: Received, unreliable: Received) -> int:
        """Hand over messages and those behind them, within a bound; how many."""
        self._append_waiting(reliable, self._reliable)
        self._append_waiting(unreliable, self._unreliable)
        lost = 0
        for _, info in reliable:
            lost += self._gaps.missing_before(info)
            self._floods.count(f"{self._noun} on {self._topic}")
        total = self._count_lost(lost)
        now = time.monotonic()
        if lost and now - self._warned_at > MINUTE:
            self._warned_at = now
            self._log.warning(
                f"{self._topic}: {total} counts lost so far: they come faster "
                "than they can be recorded"
            )
        messages = reliable + unreliable
        fresh = [data for data, info in messages if not self._is_copy(data, info)]
        if fresh:
            self._hand_over(fresh)
        return len(messages)

    def _append_waiting(self, messages: Received, subscription: Any) -> None:
        """Append what waits in the middleware, within a bound."""
        size = sum(len(data) for data, _ in messages)
        handle = subscription.handle
        with handle:
            while size < MOST_AT_ONCE:
                message = handle.take_message(self._kind, True)
                if message is None:
                    break
                messages.append(message)
                size += len(message[0]) + OVERHEAD

    def _is_copy(self, data: bytes, info: Mapping[str, int]) -> bool:
        """Whether the other subscription had it: a reliable publisher matches both."""
        identity = (
            info["source_timestamp"],
            info["publication_sequence_number"],
            hash(bytes(data)),
        )
        is_copy = self._received.get(identity) is not None
        self._received.put(identity, True)
        return is_copy


COUNTS_TOPIC = "pose_counts"
OBSERVED_TOPIC = "observed_parts"
MOST_PROBLEMS = 60  # counts in a minute that cannot be compared, and are told each
MOST_PARTS = 10**6  # in one count
LEAST_CONFIDENCE = 0.5  # a camera that is less sure of a part says nothing of its pose
MOST_SETTINGS = 100
LONGEST_SETTING = 100  # of a feeder, and characters of a name


class Cameras:
    """Records each count as it is, learns from it, and says if it cannot be compared.

    What a camera saw is counted, and taken as if it had counted that itself; where the
    part has left memory, once it is built.
    """

    def __init__(
        self,
        equipment: Equipment,
        parts: PartRegistry,
        build_known: Callable[[KnownPart, DropScene], Future[Part]],
    ) -> None:
        self._settings = equipment.settings
        self._refusals = equipment.refusals
        self._log = equipment.node.get_logger()
        self._full_name = equipment.node.full_name
        self._recorder = equipment.recorder
        self._state = equipment.state
        self._parts = parts
        self._build_known = build_known
        # what was seen of parts that are being built, and its bytes
        self._waiting: dict[KnownPart, list[part_messages.ObservedArrays]] = {}
        self._waiting_bytes = 0
        self._waiting_lock = threading.Lock()
        self._subscriptions = [
            BatchSubscription(
                equipment,
                ObservedParts,
                OBSERVED_TOPIC,
                "messages",
                partial(self._take, OBSERVED_TOPIC, "message", self._read_observed),
            ),
            BatchSubscription(
                equipment,
                PoseCounts,
                COUNTS_TOPIC,
                "counts",
                partial(self._take, COUNTS_TOPIC, "count", read_counts),
            ),
        ]

    def take_last(self) -> None:
        """Take what the middleware still has, at the end of the node."""
        for subscription in self._subscriptions:
            subscription.take_last()

    def _take(
        self,
        topic: str,
        noun: str,
        read: Callable[[M], PoseCounts | None],
        messages: Iterable[M],
    ) -> None:
        """Learn from what was counted, have that on the disk, and put it on record."""
        sound = []
        for message in messages:
            try:
                counts = read(message)
            except Exception as error:  # a refusal, or a failure that is told like one
                self._refusals.refuse(
                    self._full_name(topic), describe_error(error), noun
                )
                continue
            if counts is not None:
                sound.append(counts)
        for counts in sound:
            self._learn(counts)
        self._state.commit()
        # One look at part and bag for all that came of a part in a row.
        for part_id, series in groupby(sound, lambda counts: counts.part_id):
            part = self._parts.current(part_id)
            if part is not None:
                # The bag has the mesh before. To read it is no work for a callback, but
                # where the node ends, or too many wait.
                try:
                    part.once_introduced(part.introduce).result()
                except (CancelledError, BusyError):
                    part.introduce()
            for counts in series:
                # As it was read, not as it came: ROS reads a text that lacks its
                # closing zero byte, and other readers of bags do not.
                data = serialization.serialize_message(counts)
                self._recorder.record(POSE_COUNTS, data)

    def _learn(self, counts: PoseCounts) -> None:
        """Learn from counts, or say why not."""
        part = self._parts.current(counts.part_id)
        kind = "counts of nothing"
        with nullcontext() if part is None else part.lock:  # nothing comes in between
            part = self._parts.current(counts.part_id)
            problem = numbering_problem(counts.numbering, part)
            if problem:
                self._refusals.refuse(self._full_name(COUNTS_TOPIC), problem, "count")
                return
            problem = count_problem(counts, part, self._settings().plate)
            if part is not None and not problem:
                if part.add_counts(counts):
                    return
                kind = "counts that came before"
                problem = "it came before, and counts once"
                stamp = counts.header.stamp
                if not (stamp.sec or stamp.nanosec):
                    problem += "; fill in header.stamp, which tells equal counts apart"
        if self._refusals.floods.count(kind, MOST_PROBLEMS):
            self._log.warning(
                f"{self._full_name(COUNTS_TOPIC)}: recorded, but {problem}"
            )

    def _read_observed(self, data: bytes) -> PoseCounts | None:
        """Count the poses of parts that a camera saw; None where that comes later."""
        observed = part_messages.observed_parts(data, MOST_BYTES)
        check_observed(observed, self._settings().plate_frame)
        part = self._parts.current(observed.part_id)
        if part is None or part.latched is None:
            raise RequestError(
                "the part_id of a known part",
                part_requests.quote_text(observed.part_id),
                f"publish its mesh on {self._full_name('part_mesh')} first",
            )
        if not len(observed.poses):
            return None
        with self._waiting_lock:
            if part in self._waiting:
                self._let_wait(part, observed)
                return None
            build = self._build_known(part, part.latched.scene)
            is_built = build.done()
            if not is_built:
                self._let_wait(part, observed)
        if is_built:
            return self._count_observed(observed, part, result_or_refusal(build))
        build.add_done_callback(partial(self._count_waiting, part))
        return None

    def _let_wait(
        self, part: KnownPart, observed: part_messages.ObservedArrays
    ) -> None:
        """Have a message wait until its part is built; the lock is held."""
        size = observed.poses.nbytes + OVERHEAD
        if self._waiting_bytes + size > MOST_AT_ONCE:
            raise BusyError(
                f"at most {MOST_AT_ONCE} bytes that wait for parts to be built",
                f"{size} more than the {self._waiting_bytes} that do",
                "send it again in a moment",
            )
        self._waiting_bytes += size
        self._waiting.setdefault(part, []).append(observed)

    def _count_waiting(self, part: KnownPart, build: Future[Part]) -> None:
        """Count what was seen of a part that is built now, or is refused."""
        with self._waiting_lock:
            messages = self._waiting.pop(part)
            self._waiting_bytes -= sum(
                observed.poses.nbytes + OVERHEAD for observed in messages
            )
        self._take(
            OBSERVED_TOPIC,
            "message",
            lambda observed: self._count_observed(
                observed, part, result_or_refusal(build)
            ),
            messages,
        )

    def _count_observed(
        self, observed: part_messages.ObservedArrays, part: KnownPart, geometry: Part
    ) -> PoseCounts | None:
        """Count the poses that a camera saw; None where another mesh numbers them."""
        settings = self._settings()
        latched = part.latched
        assert latched is not None
        result = latched.message
        problem = numbering_problem(observed.numbering, part)
        if problem:
            self._refusals.refuse(self._full_name(OBSERVED_TOPIC), problem, "message")
            return None
        poses = classify_orientations(
            geometry,
            observed.poses[:, 3:],
            cluster_tolerance=result.cluster_tolerance,
            round_sides=result.round_sides,
        )
        is_sure = poses >= 0
        if len(observed.confidence):
            is_sure &= observed.confidence >= LEAST_CONFIDENCE
        index, count = np.unique(poses[is_sure], return_counts=True)
        scene = latched.scene
        counts = PoseCounts(
            part_id=part.part_id,
            numbering=result.numbering,
            plate=settings.plate,
            index=index.astype(np.uint32),
            count=count.astype(np.uint64),
            drop_height=-1.0 if scene.drop_height is None else scene.drop_height,
            unclassified=int((~is_sure).sum()),
            from_pose=observed.from_pose,
            feeder_setting=observed.feeder_setting,
        )
        counts.header.stamp = times.time_message(
            observed.stamp or times.current_stamp()
        )
        counts.header.frame_id = settings.plate_frame
        return counts


def read_counts(data: bytes) -> PoseCounts:
    """What a camera counted; raises RequestError if it is too long."""
    counts: PoseCounts = part_messages.deserialize(data, PoseCounts, MOST_BYTES)
    return counts


def check_observed(observed: part_messages.ObservedArrays, plate_frame: str) -> None:
    """Refuse what cannot be counted whatever the part; raises RequestError."""
    confidence = observed.confidence
    if len(confidence) not in (0, len(observed.poses)):
        raise RequestError(
            "a confidence for each of the poses, or none at all",
            f"{len(confidence)} for {len(observed.poses)} poses",
            "fill in all or none",
        )
    wrong = confidence[(confidence < 0.0) | (confidence > 1.0)]
    if len(wrong):
        raise RequestError(
            "confidences from 0 to 1", f"{wrong[0]:g}", "divide percentages by 100"
        )
    if observed.frame_id not in ("", plate_frame):
        frame = part_requests.quote_text(plate_frame)
        raise RequestError(
            f"poses in the frame {frame} (parameter plate_frame)",
            part_requests.quote_text(observed.frame_id),
            "transform them to the plate, z up",
        )


def numbering_problem(numbering: int, part: KnownPart | None) -> str:
    """Why counts under a numbering are refused; empty where they are not."""
    if part is None or part.latched is None or not numbering:
        return ""
    present = part.latched.message.numbering
    if numbering == present:
        return ""
    return (
        f"OTHER_NUMBERING: expected {present} of the present result of "
        f"{part_requests.quote_text(part.part_id)}, or 0 for it, got {numbering}; "
        "copy numbering from PoseStatistics"
    )


def count_problem(counts: PoseCounts, part: KnownPart | None, plate: str) -> str:
    """Why counts of a part cannot be compared with anything; empty where they can."""
    if len(counts.index) != len(counts.count):
        return f"it has {len(counts.index)} pose indices and {len(counts.count)} counts"
    name = part_requests.quote_text(counts.part_id)
    if part is None or part.latched is None:
        return f"no part {name} is known"
    if counts.plate not in ("", plate):
        return (
            f"it names the plate {part_requests.quote_text(counts.plate)}, and the "
            f"node's is {part_requests.quote_text(plate)}; name that one, or none"
        )
    if sum(counts.count) > MOST_PARTS:
        return f"it counts more than {MOST_PARTS} parts"
    indices = {*counts.index}
    if counts.from_pose >= 0:
        indices.add(counts.from_pose)
        problem = flip_problem(counts, part)
        if problem:
            return problem
    if not math.isfinite(counts.drop_height):
        return (
            f"it has the drop_height {counts.drop_height}; "
            "a negative one stands for unknown"
        )
    unknown = sorted(indices - {pose.index for pose in part.latched.message.poses})
    return f"{name} has no pose {unknown[0]}" if unknown else ""


def flip_problem(counts: PoseCounts, part: KnownPart) -> str:
    """Why counts of flips cannot be added to those before; empty where they can."""
    if not 0 < len(counts.feeder_setting) <= LONGEST_SETTING:
        return (
            f"it has a from_pose and {len(counts.feeder_setting)} characters of "
            f"feeder_setting; name the feeder's setting in 1 to {LONGEST_SETTING}"
        )
    tally = part.counts.tally
    settings = set() if tally is None else tally.flips.keys()
    if counts.feeder_setting not in settings and len(settings) >= MOST_SETTINGS:
        return (
            f"flips at {len(settings)} feeder_settings have been counted, "
            "the most there are"
        )
    return ""
