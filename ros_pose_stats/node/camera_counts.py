"""What cameras count, on `~/pose_counts`, and see, on `~/observed_parts`: recorded and learnt."""

import math
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from functools import partial
from typing import Any

import numpy as np
from rclpy import callback_groups, event_handler, qos, serialization
from ros_pose_stats_msgs.msg import ObservedParts, PoseCounts

from ..base.errors import RequestError
from ..core.resting.observed_orientations import classify_orientations
from .equipment import Equipment
from .lanes import describe_error
from .memory import Memory
from .messages import part_messages, part_requests, times
from .parts.known_part import KnownPart
from .parts.registry import PartRegistry
from .recorder import POSE_COUNTS
from .recording.decoding import numbering_of
from .refusals import COUNTS, MINUTE, SequenceGaps

MOST_BYTES = (
    2**20
)  # of a camera's message: counts of some 80 000 poses, or some 16 000 parts seen
DEPTH = 1000  # messages that wait in the middleware
MOST_AT_ONCE = 2**22  # bytes of messages that are taken together
OVERHEAD = 1000  # bytes that a message is taken to occupy beside its own, decoded and on its way


class BatchSubscription:
    """Hands all messages that wait over to `take`, in their order, by one thread at a time."""

    def __init__(
        self,
        equipment: Equipment,
        kind: type,
        topic: str,
        noun: str,
        take: Callable[[list[bytes]], object],
    ) -> None:
        self._log = equipment.node.get_logger()
        self._floods = equipment.refusals.floods
        self._kind = kind
        self._topic = topic
        self._noun = noun
        self._hand_over = take
        self._count_lost = partial(equipment.refusals.count_lost, COUNTS)
        self._gaps = SequenceGaps()
        self._warned = -math.inf
        self._lock = threading.Lock()
        self._received: Memory[tuple[int, int, int], bool] = Memory(4 * DEPTH)
        group = callback_groups.MutuallyExclusiveCallbackGroup()
        self._subscription: Any = equipment.node.create_subscription(
            kind,
            topic,
            lambda data, info: self._take_with([(data, info)]),
            DEPTH,
            raw=True,
            callback_group=group,
            event_callbacks=event_handler.SubscriptionEventCallbacks(
                incompatible_qos=lambda info: None
            ),
        )
        equipment.node.create_subscription(
            kind,
            topic,
            self._take_unreliable,
            qos.QoSProfile(depth=DEPTH, reliability=qos.ReliabilityPolicy.BEST_EFFORT),
            raw=True,
            callback_group=group,
        )

    def take_waiting(self) -> None:
        """Hand over what the middleware still has, at the end of the node."""
        while self._take_with([]):
            pass

    def _take_with(self, received: list[tuple[bytes, Mapping[str, int]]]) -> bool:
        """Hand over messages and what waits behind them, up to so many bytes; whether any."""
        size = sum(len(data) for data, _ in received)
        handle = self._subscription.handle
        with self._lock:
            with handle:
                while (
                    size < MOST_AT_ONCE
                    and (waiting := handle.take_message(self._kind, True)) is not None
                ):
                    received.append(waiting)
                    size += len(waiting[0]) + OVERHEAD
            lost = 0
            for _, info in received:
                lost += self._gaps.missing_before(info)
                self._floods.count(f"{self._noun} on {self._topic}")
            total = self._count_lost(lost)
            if lost and time.monotonic() - self._warned > MINUTE:
                self._warned = time.monotonic()
                self._log.warning(
                    f"{self._topic}: {total} counts lost so far: they come faster "
                    "than they can be recorded"
                )
            fresh = [data for data, info in received if not self._is_copy(data, info)]
            if fresh:
                self._hand_over(fresh)
        return bool(received)

    def _take_unreliable(self, data: bytes, info: Mapping[str, int]) -> None:
        """Hand over what best-effort publishers send."""
        with self._lock:
            if not self._is_copy(data, info):
                self._hand_over([data])

    def _is_copy(self, data: bytes, info: Mapping[str, int]) -> bool:
        """Whether the other subscription had it: a reliable publisher matches both."""
        sent = (
            info["source_timestamp"],
            info["publication_sequence_number"],
            hash(bytes(data)),
        )
        is_copy = self._received.get(sent) is not None
        self._received.put(sent, True)
        return is_copy


COUNTS_TOPIC = "~/pose_counts"
OBSERVED_TOPIC = "~/observed_parts"
MOST_PROBLEMS = 60  # counts that cannot be compared, of which each is told, in a minute
MOST_PARTS = 10**6  # in one count
LEAST_CONFIDENCE = (
    0.5  # a camera that is less sure of a part says nothing about its pose
)
MOST_SPEEDS = 100
LONGEST_SPEED = 100  # of a feeder, and characters of a name


class Cameras:
    """Records each count as it is, learns from it, and says if it cannot be compared.

    What a camera saw is counted, and taken as if it had counted that itself.
    """

    def __init__(self, equipment: Equipment, parts: PartRegistry) -> None:
        self._settings = equipment.settings
        self._refusals = equipment.refusals
        self._log = equipment.node.get_logger()
        self._recorder = equipment.recorder
        self._state = equipment.state
        self._parts = parts
        self._subscriptions = [
            BatchSubscription(
                equipment,
                ObservedParts,
                OBSERVED_TOPIC,
                "messages",
                partial(self._take, OBSERVED_TOPIC, "message", self._count_observed),
            ),
            BatchSubscription(
                equipment,
                PoseCounts,
                COUNTS_TOPIC,
                "counts",
                partial(
                    self._take,
                    COUNTS_TOPIC,
                    "count",
                    lambda data: part_messages.deserialized(
                        data, PoseCounts, MOST_BYTES
                    ),
                ),
            ),
        ]

    def take_waiting(self) -> None:
        """Take what the middleware still has, at the end of the node."""
        for subscription in self._subscriptions:
            subscription.take_waiting()

    def _take(
        self,
        topic: str,
        noun: str,
        read: Callable[[bytes], PoseCounts | None],
        received: list[bytes],
    ) -> None:
        """Learn from what was counted, have that on the disk, and put it on record."""
        sound = []
        for data in received:
            try:
                counts = read(data)
            except Exception as error:  # a refusal, or a failure that is told like one
                self._refusals.refuse(topic, describe_error(error), noun)
                continue
            if counts is not None:
                sound.append(counts)
        for counts in sound:
            self._learn(counts)
        self._state.commit()
        for counts in sound:
            part = self._parts.current(counts.part_id)
            if part is not None:
                part.introduce()
            # ROS reads a text that lacks its closing zero byte; other readers of bags do not.
            self._recorder.record(POSE_COUNTS, serialization.serialize_message(counts))

    def _learn(self, counts: PoseCounts) -> None:
        """Learn from counts, or say why not."""
        part = self._parts.current(counts.part_id)
        kind = "counts of nothing"
        with nullcontext() if part is None else part.lock:  # nothing comes in between
            part = self._parts.current(counts.part_id)
            problem = count_problem(counts, part, self._settings().plate)
            if not problem and part is not None:
                if part.add_counts(counts):
                    return
                stamp = counts.header.stamp
                kind = "counts that came before"
                problem = "it came before, and counts once" + (
                    ""
                    if stamp.sec or stamp.nanosec
                    else "; fill in header.stamp, which tells equal counts apart"
                )
        if self._refusals.floods.count(kind, MOST_PROBLEMS):
            self._log.warning(f"{COUNTS_TOPIC}: recorded, but {problem}")

    def _count_observed(self, data: bytes) -> PoseCounts | None:
        """Count the poses of parts that a camera saw on the plate; None where it saw none."""
        settings = self._settings()
        seen = part_messages.observed_parts(data, MOST_BYTES)
        part = self._parts.current(seen.part_id)
        confidence = seen.confidence
        if len(confidence) not in (0, len(seen.poses)):
            raise RequestError(
                "a confidence for each of the poses, or none at all",
                f"{len(confidence)} for {len(seen.poses)} poses",
                "fill in all or none",
            )
        wrong = confidence[(confidence < 0.0) | (confidence > 1.0)]
        if len(wrong):
            raise RequestError(
                "confidences from 0 to 1", f"{wrong[0]:g}", "divide percentages by 100"
            )
        if seen.frame_id not in ("", settings.plate_frame):
            frame = part_requests.shown(settings.plate_frame)
            raise RequestError(
                f"poses in the frame {frame} (parameter plate_frame)",
                part_requests.shown(seen.frame_id),
                "transform them to the plate, z up",
            )
        if part is None or part.latched is None:
            raise RequestError(
                "the part_id of a known part",
                part_requests.shown(seen.part_id),
                "publish its mesh on ~/part_mesh first",
            )
        if not len(seen.poses):
            return None
        latched = part.latched.message
        scene = part.latched.scene
        poses = classify_orientations(
            part.geometry,
            seen.poses[:, 3:],
            cluster_tolerance=latched.cluster_tolerance,
            round_sides=latched.round_sides,
        )
        sure = (poses >= 0) & (
            confidence >= LEAST_CONFIDENCE if len(confidence) else True
        )
        index, count = np.unique(poses[sure], return_counts=True)
        counts = PoseCounts(
            part_id=part.part_id,
            part_digest=part.digest,
            cluster_tolerance=latched.cluster_tolerance,
            round_sides=latched.round_sides,
            plate=settings.plate,
            index=index.astype(np.uint32),
            count=count.astype(np.uint64),
            drop_height=-1.0 if scene.drop_height is None else scene.drop_height,
            unclassified=int((~sure).sum()),
            from_pose=seen.from_pose,
            feeder_speed=seen.feeder_speed,
        )
        counts.header.stamp = times.time_message(seen.stamp or times.now())
        counts.header.frame_id = settings.plate_frame
        return counts


def count_problem(counts: PoseCounts, part: KnownPart | None, plate: str) -> str:
    """Why a camera's count of a part cannot be compared with anything; empty where it can."""
    if len(counts.index) != len(counts.count):
        return f"it has {len(counts.index)} pose indices and {len(counts.count)} counts"
    if part is None or part.latched is None:
        return f"no part {part_requests.shown(counts.part_id)} is known"
    if counts.plate not in ("", plate):
        return (
            f"it names the plate {part_requests.shown(counts.plate)}, and the node's is "
            f"{part_requests.shown(plate)}; name that one, or none"
        )
    latched = part.latched.message
    if counts.part_digest and counts.part_digest != part.digest:
        return f"{part_requests.shown(counts.part_id)} has another part_digest by now"
    if sum(counts.count) > MOST_PARTS:
        return f"it counts more than {MOST_PARTS} parts"
    if counts.from_pose >= 0:
        if not 0 < len(counts.feeder_speed) <= LONGEST_SPEED:
            return (
                f"it has a from_pose and {len(counts.feeder_speed)} characters of "
                f"feeder_speed; name the feeder's setting in 1 to {LONGEST_SPEED}"
            )
        tally = part.counts.tally
        speeds = set() if tally is None else tally.flips.keys()
        if counts.feeder_speed not in speeds and len(speeds) >= MOST_SPEEDS:
            return f"flips at {len(speeds)} feeder_speeds have been counted, the most there are"
    if not math.isfinite(counts.drop_height):
        return f"it has the drop_height {counts.drop_height}; a negative one stands for unknown"
    counted = numbering_of(counts)
    numbered = numbering_of(latched)
    if not counted.agrees(numbered):
        return f"it has {counted}, the results have {numbered}; copy both from PoseStatistics"
    named = {*counts.index, *([counts.from_pose] if counts.from_pose >= 0 else [])}
    unknown = sorted(named - {pose.index for pose in latched.poses})
    return (
        f"{part_requests.shown(counts.part_id)} has no pose {unknown[0]}"
        if unknown
        else ""
    )
