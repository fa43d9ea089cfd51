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

"""From pose statistics to their messages, and which of two results is better."""

import copy
import math
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from rclpy.duration import Duration
from ros_pose_stats_msgs import msg

from ...base import version
from ...core import records
from ...core.records.notes import Note, has_note, note, notes_of
from ...core.records.poses import POSE_FIELDS
from ...core.records.scene import SCENE_FIELDS
from ...core.records.statistics import STATISTICS_FIELDS
from .part_messages import pack_array
from .times import current_stamp, time_message


def statistics_message(
    statistics: records.PoseStatistics, frame: str, **labels: Any
) -> msg.PoseStatistics:
    """Make the message; `labels`: plate, revision, job_id and final in it."""
    message = msg.PoseStatistics()
    message.header.stamp = time_message(current_stamp())
    message.header.frame_id = frame
    for name in STATISTICS_FIELDS:
        setattr(message, name, getattr(statistics, name))
    for name, value in labels.items():
        setattr(message, name, value)
    message.scene = statistics.scene
    message.numbering = statistics.numbering
    seconds = max(0.0, statistics.seconds)  # 0 for NaN
    message.compute_time = Duration(seconds=seconds).to_msg()
    message.poses = [
        _pose_message(statistics.part_id, pose) for pose in statistics.poses
    ]
    message.warnings = note_messages(statistics.warnings)
    return message


def note_messages(warnings: Iterable[Note]) -> list[msg.Note]:
    """The warnings as a message has them."""
    return [msg.Note(**warning._asdict()) for warning in warnings]


def fill_bounds(response: Any, **numbers: Sequence[float]) -> None:
    """Put numbers, each with its lower and upper bound, into a response by name."""
    for name, values in numbers.items():
        for end, value in zip(("", "_low", "_high"), values, strict=True):
            setattr(response, name + end, value)


def with_warning(message: msg.PoseStatistics, warning: Note) -> msg.PoseStatistics:
    """The same result with one more warning."""
    message_copy = copy.copy(message)  # which shares the poses
    message_copy.warnings = [*message.warnings, *note_messages([warning])]
    return message_copy


def with_lookalikes(
    message: msg.PoseStatistics, seen: records.PoseStatistics
) -> msg.PoseStatistics:
    """The same result with the lookalikes that its record has."""
    poses = seen.by_index
    message_copy = copy.copy(message)
    message_copy.poses = list(map(copy.copy, message.poses))
    for pose in message_copy.poses:
        pose.alike_from_above = poses[pose.index].alike_from_above or ()
    return message_copy


def farewell_message(
    last: msg.PoseStatistics, stamp: int, revision: int, reason: str
) -> msg.PoseStatistics:
    """The last message about a part: no poses, and why."""
    message = msg.PoseStatistics(revision=revision, final=True)
    message.header.stamp = time_message(stamp)
    message.header.frame_id = last.header.frame_id
    for name in (
        "part_id",
        "part_digest",
        "radius",
        "bodies",
        "unit",
        "unit_guessed",
        "plate",
        "version",
    ):
        setattr(message, name, getattr(last, name))
    message.expected_error = message.largest_error = message.plate_error = math.nan
    farewell = note("FORGOTTEN", f"{reason}; send the mesh again to get results.")
    return with_warning(message, farewell)


_Outlines = tuple["array[float]", "array[float]"]
_OUTLINES: "WeakKeyDictionary[records.RestingShape, _Outlines]" = WeakKeyDictionary()
"""Contact polygon and outline, which all messages of a pose share."""


def _pose_message(part_id: str, pose: records.StablePose) -> msg.StablePose:
    message = msg.StablePose()
    message.pose_id = f"{part_id}/{pose.index}"
    for name in POSE_FIELDS:
        setattr(message, name, getattr(pose, name))
    for vector, components in (
        (message.pose.position, pose.position),
        (message.pose.orientation, pose.orientation),
        (message.down, pose.down),
        (message.roll_axis, pose.roll_axis),
    ):
        for axis, component in zip("xyzw", components.tolist(), strict=False):
            setattr(vector, axis, component)
    message.alike_from_above = pose.alike_from_above or ()
    # Nobody writes to these.
    outlines = _OUTLINES.get(pose.shape)
    if outlines is None:
        outlines = _OUTLINES[pose.shape] = (
            pack_array(pose.support_polygon),
            pack_array(pose.outline),
        )
    message.support_polygon, message.outline = outlines
    return message


@dataclass(frozen=True, eq=False)
class DrawnShape:
    """Contact polygon and outline as they came in a message."""

    support_polygon: NDArray[np.float64]
    outline: NDArray[np.float64]


def statistics_of_message(message: msg.PoseStatistics) -> records.PoseStatistics:
    """The record that a message stands for; members of clusters are not in messages."""
    fields = {name: getattr(message, name) for name in STATISTICS_FIELDS}
    seconds = message.compute_time.sec + 1e-9 * message.compute_time.nanosec
    return records.PoseStatistics(
        poses=tuple(_pose_of(pose) for pose in message.poses),
        seconds=seconds,
        warnings=notes_of(message),
        **fields,
    )


def _pose_of(message: msg.StablePose) -> records.StablePose:
    fields = {name: getattr(message, name) for name in POSE_FIELDS}
    shape = DrawnShape(
        np.array(message.support_polygon).reshape(-1, 2),
        np.array(message.outline).reshape(-1, 2),
    )
    return records.StablePose(
        down=_components(message.down),
        members=(),
        shape=shape,
        roll_axis=_components(message.roll_axis),
        orientation=_components(message.pose.orientation, "xyzw"),
        position=_components(message.pose.position),
        alike_from_above=tuple(message.alike_from_above) or None,
        **fields,
    )


def _components(vector: Any, axes: str = "xyz") -> records.Array:
    """A vector or quaternion of a message as an array."""
    return np.array([getattr(vector, axis) for axis in axes])


def comparable_error(message: msg.PoseStatistics) -> float:
    """Expected error; the plate's where that is unknown.

    So a few drops do not take the place of a better estimate.
    """
    error: float = message.expected_error
    return float(message.plate_error) if math.isnan(error) else error


def is_recorded(message: msg.PoseStatistics) -> bool:
    """Whether nothing is said of a result that could not be written down."""
    return not has_note(message, "NOT_RECORDED")


def refutes(message: msg.PoseStatistics) -> bool:
    """Whether a result is of drops that contradicted an estimate."""
    return has_note(message, "CONFLICT")


def replaces(newer: msg.PoseStatistics, older: msg.PoseStatistics) -> bool:
    """Whether a result takes the place of the latched one for the same scene.

    A larger expected error never replaces a smaller one, but that a simulation ends
    what it has shown of itself, and that a newer method counts. What drops refuted
    needs as many drops.
    """
    if newer.part_digest == older.part_digest and refutes(newer) != refutes(older):
        return newer.drops >= older.drops
    if not (newer.job_id or older.job_id) and newer.method != older.method:
        return True
    if newer.final and newer.job_id and newer.job_id == older.job_id:
        return True
    return newer.part_digest != older.part_digest or comparable_error(
        newer
    ) <= comparable_error(older)


def holds_for_scene(last: msg.PoseStatistics, scene: records.DropScene) -> bool:
    """Whether a result of the last run holds for its part in the present scene."""
    if last.version != version.VERSION or any(
        getattr(last, name) != getattr(scene, name)
        for name in SCENE_FIELDS
        if name != "drop_height"  # of a message it is that of the release
    ):
        return False
    released = scene.release_height(last.radius)
    return math.isnan(last.drop_height) or math.isclose(last.drop_height, released)
