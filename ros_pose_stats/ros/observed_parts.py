"""Parts that cameras see, on `~/observed_parts`: the pose of each is found, and counted."""

from collections.abc import Callable

import numpy as np
from rclpy.node import Node
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import ObservedParts, PoseCounts

from ..errors import PoseStatsError, RequestError
from ..resting.observed_orientations import classify_orientations
from .messages.camera_messages import ObservedPoses, observed_of_bytes
from .messages.part_requests import shown
from .messages.times import now, time_message
from .parts.known_part import KnownPart
from .pose_counts import CountSubscription
from .recorder import Recorder
from .refusals import Refusals
from .settings import Settings
from .transport.batches import BatchSubscription

TOPIC = "~/observed_parts"

LEAST_CONFIDENCE = 0.5
"""A camera that is less sure of a part says nothing about its pose."""


class ObservedSubscription:
    """Counts what each message shows, and hands that on as if a camera had counted it.

    `known`: a known part by its id, or None; `refusals`: told of what cannot be counted.
    """

    def __init__(self, node: Node, settings: Callable[[], Settings], counts: CountSubscription,
                 known: Callable[[str], KnownPart | None], recorder: Recorder,
                 refusals: Refusals) -> None:
        self._settings = settings
        self._counts = counts
        self._known = known
        self._refusals = refusals
        self._batches = BatchSubscription(node, ObservedParts, TOPIC, "messages", self._take,
                                          recorder.count_lost, refusals)

    def take_waiting(self) -> None:
        """Count what the middleware still has, at the end of the node."""
        self._batches.take_waiting()

    def _take(self, received: list[bytes]) -> None:
        found = []
        for data in received:
            try:
                counts = count_observed(observed_of_bytes(data), self._known, self._settings())
            except PoseStatsError as refusal:
                self._refusals.refuse(TOPIC, str(refusal), "message")
            else:
                found += [] if counts is None else [(serialize_message(counts), counts)]
        self._counts.take_counts(found)


def count_observed(seen: ObservedPoses, known: Callable[[str], KnownPart | None],
                   settings: Settings) -> PoseCounts | None:
    """Count the poses of parts that a camera saw; None where it saw none.

    `known`: a known part by its id, or None. Raises PoseStatsError if the part is not known, or
    its orientations are not in the frame of the plate or none.
    """
    if seen.frame_id not in ("", settings.plate_frame):
        raise RequestError(f"poses in the frame {shown(settings.plate_frame)} (parameter "
                           "plate_frame)", shown(seen.frame_id),
                           "transform them to the plate, z up")
    part = known(seen.part_id)
    if part is None or part.shown.latched is None or part.shown.scene is None:
        raise RequestError("the part_id of a known part", shown(seen.part_id),
                           "publish its mesh on ~/part_mesh first")
    if not len(seen.orientations):
        return None
    latched = part.shown.latched
    found = classify_orientations(part.part, seen.orientations,
                                  cluster_tolerance=latched.cluster_tolerance,
                                  round_sides=latched.round_sides)
    sure = (found >= 0) & (seen.confidence >= LEAST_CONFIDENCE)
    index, count = np.unique(found[sure], return_counts=True)
    height = part.shown.scene.drop_height
    counts = PoseCounts(
        part_id=part.part_id, part_digest=part.digest,
        cluster_tolerance=latched.cluster_tolerance, round_sides=latched.round_sides,
        plate=settings.plate, drop_height=-1.0 if height is None else height,
        index=index.astype(np.uint32), count=count.astype(np.uint64),
        unclassified=int((~sure).sum()))
    counts.header.stamp = time_message(seen.stamp or now())
    counts.header.frame_id = settings.plate_frame
    return counts
