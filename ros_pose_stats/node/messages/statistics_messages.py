"""From pose statistics to their messages, and which of two results is the better one."""

import copy
import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from rclpy.duration import Duration
from ros_pose_stats_msgs import msg

from ...base import version
from ...core import records
from ...core.records.poses import POSE_FIELDS
from ...core.records.statistics import FORGOTTEN, STATISTICS_FIELDS
from .part_messages import flat
from .times import now, time_message


def statistics_message(
    statistics: records.PoseStatistics, frame: str, **labels: Any
) -> msg.PoseStatistics:
    """Make the message; `labels`: plate, revision, job_id and final in it."""
    message = msg.PoseStatistics()
    message.header.stamp = time_message(now())
    message.header.frame_id = frame
    for name in STATISTICS_FIELDS:
        setattr(message, name, getattr(statistics, name))
    for name, value in labels.items():
        setattr(message, name, value)
    message.scene = statistics.scene
    message.compute_time = Duration(
        seconds=max(0.0, statistics.seconds)
    ).to_msg()  # NaN: 0
    message.poses = [_pose(statistics.part_id, pose) for pose in statistics.poses]
    message.warnings = list(statistics.warnings)
    message.notes = list(statistics.notes)
    return message


def fill_bounds(response: Any, **numbers: Sequence[float]) -> None:
    """Put numbers, each followed by its lower and upper bound, into a response by their names."""
    for name, values in numbers.items():
        for end, value in zip(("", "_low", "_high"), values, strict=True):
            setattr(response, name + end, value)


def with_warning(message: msg.PoseStatistics, warning: str) -> msg.PoseStatistics:
    """The same result with one more warning."""
    twin = copy.copy(message)  # which shares the poses
    twin.warnings = [*message.warnings, warning]
    return twin


def farewell_message(
    last: msg.PoseStatistics, stamp: int, revision: int, reason: str
) -> msg.PoseStatistics:
    """The last message about a part: no poses, and why."""
    message = msg.PoseStatistics(revision=revision, final=True)
    message.header.stamp = time_message(stamp)
    message.header.frame_id = last.header.frame_id
    for name in ("part_id", "part_digest", "radius", "plate", "version"):
        setattr(message, name, getattr(last, name))
    message.expected_error = message.largest_error = message.plate_error = math.nan
    message.warnings = [f"{FORGOTTEN}{reason}; send the mesh again to get results."]
    return message


_DRAWN: "WeakKeyDictionary[records.RestingShape, tuple[array[float], array[float]]]" = (
    WeakKeyDictionary()
)


def _pose(part_id: str, pose: records.StablePose) -> msg.StablePose:
    message = msg.StablePose()
    message.pose_id = f"{part_id}/{pose.index}"
    for name in POSE_FIELDS:
        setattr(message, name, getattr(pose, name))
    orientation = message.pose.orientation
    orientation.x, orientation.y, orientation.z, orientation.w = (
        pose.orientation.tolist()
    )
    for vector, values in (
        (message.pose.position, pose.position),
        (message.down, pose.down),
        (message.roll_axis, pose.roll_axis),
    ):
        vector.x, vector.y, vector.z = values.tolist()
    # all messages of a pose share these, as nobody writes to them
    drawn = _DRAWN.get(pose.shape)
    if drawn is None:
        drawn = _DRAWN[pose.shape] = flat(pose.support_polygon), flat(pose.outline)
    message.support_polygon, message.outline = drawn
    return message


@dataclass(frozen=True, eq=False)
class DrawnShape:
    """Contact polygon and outline as they came in a message."""

    support_polygon: NDArray[np.float64]
    outline: NDArray[np.float64]


def statistics_of_message(message: msg.PoseStatistics) -> records.PoseStatistics:
    """The record that a message stands for; members of clusters are not in messages."""
    plain = {name: getattr(message, name) for name in STATISTICS_FIELDS}
    seconds = message.compute_time.sec + 1e-9 * message.compute_time.nanosec
    return records.PoseStatistics(
        poses=tuple(_pose_of(pose) for pose in message.poses),
        seconds=seconds,
        warnings=tuple(message.warnings),
        notes=tuple(message.notes),
        **plain,
    )


def _pose_of(message: msg.StablePose) -> records.StablePose:
    position = message.pose.position
    turn = message.pose.orientation
    down = message.down
    plain = {name: getattr(message, name) for name in POSE_FIELDS}
    shape = DrawnShape(
        np.array(message.support_polygon).reshape(-1, 2),
        np.array(message.outline).reshape(-1, 2),
    )
    return records.StablePose(
        down=np.array([down.x, down.y, down.z]),
        members=(),
        shape=shape,
        roll_axis=np.array(
            [message.roll_axis.x, message.roll_axis.y, message.roll_axis.z]
        ),
        orientation=np.array([turn.x, turn.y, turn.z, turn.w]),
        position=np.array([position.x, position.y, position.z]),
        **plain,
    )


def known_error(message: msg.PoseStatistics) -> float:
    """Expected error; a plate's where nobody knows it, so that few drops push nothing aside."""
    error: float = message.expected_error
    return float(message.plate_error) if math.isnan(error) else error


def refutes(message: msg.PoseStatistics) -> bool:
    """Whether a result is of drops that contradicted an estimate."""
    return any(line.startswith("CONFLICT:") for line in message.warnings)


def replaces(new: msg.PoseStatistics, old: msg.PoseStatistics) -> bool:
    """Whether a result takes the place of the latched one for the same scene.

    A larger expected error never replaces a smaller one, but that a simulation ends what it has
    shown of itself, and that a newer method counts. What drops refuted needs as many drops.
    """
    if new.part_digest == old.part_digest and refutes(new) != refutes(old):
        return new.drops >= old.drops
    if not (new.job_id or old.job_id) and new.method != old.method:
        return True
    if new.final and new.job_id and new.job_id == old.job_id:
        return True
    return new.part_digest != old.part_digest or known_error(new) <= known_error(old)


def still_true(last: msg.PoseStatistics, scene: records.DropScene) -> bool:
    """Whether a result of the last run holds for its part in the present scene."""
    if (last.version, last.restitution, last.cluster_tolerance, last.round_sides) != (
        version.VERSION,
        scene.restitution,
        scene.cluster_tolerance,
        scene.round_sides,
    ):
        return False
    released = scene.release_height(last.radius)
    return math.isnan(last.drop_height) or math.isclose(last.drop_height, released)
