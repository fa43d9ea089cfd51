"""What cameras count, on `~/pose_counts`, and see, on `~/observed_parts`: recorded and learnt."""

import math

import numpy as np
from rclpy import serialization
from ros_pose_stats_msgs.msg import ObservedParts, PoseCounts

from ..errors import PoseStatsError, RequestError
from ..recording.analysis.decoding import numbering_of
from ..resting.observed_orientations import classify_orientations
from .base import Base
from .batches import BatchSubscription
from .messages import part_messages, part_requests, times
from .parts import known_part, result_store
from .recorder import POSE_COUNTS
from .settings import Settings

MOST_BYTES = 2**20  # of a camera's message: counts of some 80 000 poses, or some 16 000 parts seen


def observed_of_bytes(data: bytes) -> part_messages.ObservedArrays:
    """What a camera saw; raises RequestError if the bytes or its confidences are none."""
    if len(data) > MOST_BYTES:
        raise RequestError(f"an ObservedParts of at most {MOST_BYTES} bytes", f"{len(data)} bytes",
                           "check the publisher")
    numbers = part_messages.see(data, ObservedParts, part_messages.observed_arrays)
    parts, confidence = len(numbers.poses), numbers.confidence
    if not len(confidence):
        confidence = np.ones(parts)
    if len(confidence) != parts:
        raise RequestError("a confidence for each of the poses, or none at all",
                           f"{len(confidence)} for {parts} poses", "fill in all or none")
    wrong = confidence[(confidence < 0.0) | (confidence > 1.0)]
    if len(wrong):
        raise RequestError("confidences from 0 to 1", f"{wrong[0]:g}", "divide percentages by 100")
    return numbers._replace(confidence=confidence)


COUNTS_TOPIC = "~/pose_counts"
MOST_PROBLEMS = 60  # counts that cannot be compared, of which each is told, in a minute
MOST_PARTS = 10**6  # in one count
MOST_SPEEDS, LONGEST_SPEED = 100, 100  # of a feeder, and characters of a name


class CountSubscription:
    """Records each count as it is, learns from it, and says if it cannot be compared."""

    def __init__(self, base: Base, stores: result_store.Stores) -> None:
        self._log, self._recorder = base.node.get_logger(), base.recorder
        self._parts, self._counts, _, self._announcer = stores
        self._refusals = base.refusals
        self.take_waiting = BatchSubscription(base, PoseCounts, COUNTS_TOPIC, "counts",
                                              self._take).take_waiting

    def _take(self, received: list[bytes]) -> None:
        sound: list[tuple[bytes, PoseCounts]] = []
        for data in received:
            try:
                counts = part_messages.deserialized(data, PoseCounts, MOST_BYTES)
                # ROS reads a text that lacks its closing zero byte; other readers of bags do not.
                sound.append((serialization.serialize_message(counts), counts))
            except RequestError as refusal:
                self._refusals.refuse(COUNTS_TOPIC, str(refusal), "count")
        self.take_counts(sound)

    def take_counts(self, sound: list[tuple[bytes, PoseCounts]]) -> None:
        """Put counts, each serialised and as it is, on record together, and learn from them."""
        with self._recorder.step:
            for data, counts in sound:
                part = self._parts.current(counts.part_id)
                if part is not None:
                    self._announcer.introduce(part)
                self._recorder.record(POSE_COUNTS, data)
            for _, counts in sound:
                self.learn_counts(counts)

    def learn_counts(self, counts: PoseCounts, *, again: bool = False) -> None:
        """Learn from counts that are on record, maybe `again`, or say why not."""
        part = self._parts.current(counts.part_id)
        problem, kind = count_problem(counts, part), "counts of nothing"
        if not problem and part is not None:
            if self._counts.add_counts(part, counts) or again:
                return
            stamp, kind = counts.header.stamp, "counts that came before"
            problem = "it came before, and counts once" + ("" if stamp.sec or stamp.nanosec else (
                "; fill in header.stamp, which tells equal counts apart"))
        if self._refusals.floods.count(kind, MOST_PROBLEMS):
            self._log.warning(f"{COUNTS_TOPIC}: recorded, but {problem}")


def count_problem(counts: PoseCounts, part: known_part.KnownPart | None) -> str:
    """Why a camera's count of a part cannot be compared with anything; empty where it can."""
    if len(counts.index) != len(counts.count):
        return f"it has {len(counts.index)} pose indices and {len(counts.count)} counts"
    if part is None or part.shown is None:
        return f"no part {part_requests.shown(counts.part_id)} is known"
    latched = part.shown.latched
    if counts.part_digest and counts.part_digest != part.digest:
        return f"{part_requests.shown(counts.part_id)} has another part_digest by now"
    if sum(counts.count) > MOST_PARTS:
        return f"it counts more than {MOST_PARTS} parts"
    if counts.from_pose >= 0:
        if not 0 < len(counts.feeder_speed) <= LONGEST_SPEED:
            return (f"it has a from_pose and {len(counts.feeder_speed)} characters of "
                    f"feeder_speed; name the feeder's setting in 1 to {LONGEST_SPEED}")
        speeds = part.counts.flips.keys() if part.counts is not None else set()
        if counts.feeder_speed not in speeds and len(speeds) >= MOST_SPEEDS:
            return f"flips at {len(speeds)} feeder_speeds have been counted, the most there are"
    if not math.isfinite(counts.drop_height):
        return f"it has the drop_height {counts.drop_height}; a negative one stands for unknown"
    counted, numbered = numbering_of(counts), numbering_of(latched)
    if not counted.agrees(numbered):
        return f"it has {counted}, the results have {numbered}; copy both from PoseStatistics"
    named = {*counts.index, *([counts.from_pose] if counts.from_pose >= 0 else [])}
    unknown = sorted(named - {pose.index for pose in latched.poses})
    return f"{part_requests.shown(counts.part_id)} has no pose {unknown[0]}" if unknown else ""


OBSERVED_TOPIC = "~/observed_parts"
LEAST_CONFIDENCE = 0.5  # a camera that is less sure of a part says nothing about its pose


class ObservedSubscription:
    """Counts what each message shows, and hands that on as if a camera had counted it."""

    def __init__(self, base: Base, stores: result_store.Stores, counts: CountSubscription) -> None:
        self._settings, self._refusals = base.settings, base.refusals
        self._counts, self._parts = counts, stores.parts
        self.take_waiting = BatchSubscription(base, ObservedParts, OBSERVED_TOPIC, "messages",
                                              self._take).take_waiting

    def _take(self, received: list[bytes]) -> None:
        sound = []
        for data in received:
            try:
                seen = observed_of_bytes(data)
                counts = count_observed(seen, self._parts.current(seen.part_id), self._settings())
            except PoseStatsError as refusal:
                self._refusals.refuse(OBSERVED_TOPIC, str(refusal), "message")
            else:
                if counts is not None:
                    sound.append((serialization.serialize_message(counts), counts))
        self._counts.take_counts(sound)


def count_observed(seen: part_messages.ObservedArrays, part: known_part.KnownPart | None,
                   settings: Settings) -> PoseCounts | None:
    """Count the poses of parts that a camera saw on the plate; None where it saw none."""
    if seen.frame_id not in ("", settings.plate_frame):
        frame = part_requests.shown(settings.plate_frame)
        raise RequestError(f"poses in the frame {frame} (parameter plate_frame)",
                           part_requests.shown(seen.frame_id), "transform them to the plate, z up")
    if part is None or part.shown is None:
        raise RequestError("the part_id of a known part", part_requests.shown(seen.part_id),
                           "publish its mesh on ~/part_mesh first")
    if not len(seen.poses):
        return None
    latched, scene = part.shown.latched, part.shown.scene
    poses = classify_orientations(part.part, seen.poses[:, 3:],
                                  cluster_tolerance=latched.cluster_tolerance,
                                  round_sides=latched.round_sides)
    sure = (poses >= 0) & (seen.confidence >= LEAST_CONFIDENCE)
    index, count = np.unique(poses[sure], return_counts=True)
    counts = PoseCounts(
        part_id=part.part_id, part_digest=part.digest,
        cluster_tolerance=latched.cluster_tolerance, round_sides=latched.round_sides,
        plate=settings.plate, drop_height=-1.0 if scene.drop_height is None else scene.drop_height,
        index=index.astype(np.uint32), count=count.astype(np.uint64),
        unclassified=int((~sure).sum()), from_pose=seen.from_pose,
        feeder_speed=seen.feeder_speed)
    counts.header.stamp = times.time_message(seen.stamp or times.now())
    counts.header.frame_id = settings.plate_frame
    return counts
