"""From pose statistics to their messages; pure functions."""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_pose_stats_msgs.msg import PoseStatistics as PoseStatisticsMessage
from ros_pose_stats_msgs.msg import StablePose as StablePoseMessage

from .. import records
from .times import duration_message, time_message


@dataclass(frozen=True)
class Answer:
    """What a message says beside the statistics themselves.

    Attributes
    ----------
    stamp : int
        Nanoseconds.
    frame, plate : str
    revision : int
    job_id : str
        Empty for an estimate.
    final : bool
    warnings : tuple of str
        Added to those of the statistics.
    """

    stamp: int
    frame: str
    plate: str
    revision: int
    job_id: str = ""
    final: bool = True
    warnings: tuple[str, ...] = ()


def statistics_message(found: records.PoseStatistics, answer: Answer) -> PoseStatisticsMessage:
    """Make the message.

    Parameters
    ----------
    found : PoseStatistics
    answer : Answer

    Returns
    -------
    ros_pose_stats_msgs/PoseStatistics
    """
    message = PoseStatisticsMessage()
    message.header.stamp = time_message(answer.stamp)
    message.header.frame_id = answer.frame
    for name in ("part_id", "part_digest", "radius", "method", "restitution", "drop_height",
                 "cluster_tolerance", "drops", "unsettled", "seed", "expected_error",
                 "plate_error", "version"):
        setattr(message, name, getattr(found, name))
    message.plate = answer.plate
    message.compute_time = duration_message(
        0.0 if math.isnan(found.seconds) else found.seconds)
    message.job_id = answer.job_id
    message.revision = answer.revision
    message.final = answer.final
    message.poses = [_pose(found.part_id, pose) for pose in found.poses]
    message.warnings = [*found.warnings, *answer.warnings]
    return message


def _pose(part_id: str, pose: records.StablePose) -> StablePoseMessage:
    message = StablePoseMessage()
    message.pose_id = f"{part_id}/{pose.index}"
    for name in ("index", "group", "height", "top", "margin", "barrier", "spread", "probability",
                 "probability_low", "probability_high", "standard_error", "count"):
        setattr(message, name, getattr(pose, name))
    position, orientation, down = message.pose.position, message.pose.orientation, message.down
    position.x, position.y, position.z = pose.position.tolist()
    orientation.x, orientation.y, orientation.z, orientation.w = pose.orientation.tolist()
    down.x, down.y, down.z = pose.down.tolist()
    message.support_polygon = _flat(pose.support_polygon)
    message.outline = _flat(pose.outline)
    return message


def _flat(points: NDArray[np.float64]) -> array[float]:
    """An `array.array`, which rclpy takes as it is."""
    return array("d", np.ascontiguousarray(points, dtype=np.float64).tobytes())
