"""From what cameras send to what the node counts; pure functions."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import ObservedParts, PoseCounts

from ...errors import RequestError
from .mesh_views import NotPlainCdrError, ObservedNumbers, observed_numbers

Array = NDArray[np.float64]

MOST_BYTES = 2**20
"""Of a camera's message: counts of some 80 000 poses, or some 16 000 parts seen."""


class ObservedPoses(NamedTuple):
    """Parts that a camera saw at once."""

    stamp: int  # nanoseconds
    frame_id: str
    part_id: str
    orientations: Array  # (n, 4); x y z w
    confidence: Array  # (n,); 0 to 1


def counts_of_bytes(data: bytes) -> PoseCounts:
    """What a camera counted.

    Raises RequestError if the bytes are no `PoseCounts`, or more than any part could have.
    """
    return _message_of_bytes(data, PoseCounts)


def observed_of_bytes(data: bytes) -> ObservedPoses:
    """What a camera saw, where it is as sure of each part as it says.

    Raises RequestError if the bytes are no `ObservedParts`, or more than any picture could hold,
    or its confidences are not from 0 to 1, one a part or none.
    """
    _check_size(data, ObservedParts)
    try:
        numbers = observed_numbers(data)
    except NotPlainCdrError:
        again = serialize_message(_message_of_bytes(data, ObservedParts))
        numbers = observed_numbers(again)
    return _checked(numbers)


def _checked(numbers: ObservedNumbers) -> ObservedPoses:
    parts, confidence = len(numbers.poses), numbers.confidence
    if not len(confidence):
        confidence = np.ones(parts)
    if len(confidence) != parts:
        raise RequestError("a confidence for each of the poses, or none at all",
                           f"{len(confidence)} for {parts} poses", "fill in all or none")
    wrong = confidence[(confidence < 0.0) | (confidence > 1.0)]
    if len(wrong):
        raise RequestError("confidences from 0 to 1", f"{wrong[0]:g}",
                           "divide percentages by 100")
    return ObservedPoses(numbers.stamp, numbers.frame_id, numbers.part_id, numbers.poses[:, 3:],
                         confidence)


def _check_size(data: bytes, kind: type) -> None:
    if len(data) > MOST_BYTES:
        raise RequestError(f"a {kind.__name__} of at most {MOST_BYTES} bytes",
                           f"{len(data)} bytes", "check the publisher")


def _message_of_bytes(data: bytes, kind: type) -> Any:
    _check_size(data, kind)
    try:
        return deserialize_message(data, kind)
    except Exception as error:  # the bindings raise what they like
        raise RequestError(f"a serialised {kind.__name__}", f"{len(data)} bytes that are none "
                           f"({type(error).__name__})", "check the publisher") from error
