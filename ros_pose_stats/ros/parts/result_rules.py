"""When a result holds, and which of two is the better one; pure functions."""

import math

from ros_pose_stats_msgs.msg import PoseStatistics
from std_msgs.msg import Header

from ...methods import OBSERVED
from ...records import DropScene
from ...version import VERSION
from ..messages.statistics_messages import copied
from ..settings import Settings


def known_error(message: PoseStatistics) -> float:
    """Expected error of a result; where none has been measured, what a real plate leaves.

    An estimate whose error nobody knows is taken to be as good as that, so that a handful of
    drops does not push it aside.
    """
    error: float = message.expected_error
    return float(message.plate_error) if math.isnan(error) else error


def refutes(message: PoseStatistics) -> bool:
    """Whether a result is of drops that contradicted an estimate."""
    return any(line.startswith("CONFLICT:") for line in message.warnings)


def replaces(new: PoseStatistics, old: PoseStatistics) -> bool:
    """Whether a result takes the place of the latched one for the same scene.

    A larger expected error never replaces a smaller one for the same digest, but that a
    simulation ends what it has shown of itself: its last drops may raise the error a little.
    Of two estimates the newer one counts, which is by the method that is wanted now. What drops
    have refuted comes back only with as many drops behind it, however small the error that it
    tells of itself.
    """
    if new.part_digest == old.part_digest and refutes(new) != refutes(old):
        return new.drops >= old.drops
    if not new.drops and not old.drops and new.method != old.method:
        return True
    if new.final and new.job_id and new.job_id == old.job_id:
        return True
    return new.part_digest != old.part_digest or known_error(new) <= known_error(old)


def still_true(last: PoseStatistics, scene: DropScene) -> bool:
    """Whether a result of the last run holds for its part in the present scene."""
    if (last.version, last.restitution, last.cluster_tolerance, last.round_sides) != (
            VERSION, scene.restitution, scene.cluster_tolerance, scene.round_sides):
        return False
    released = scene.release_height(last.radius)
    return math.isnan(last.drop_height) or math.isclose(last.drop_height, released)


def labelled(message: PoseStatistics, settings: Settings) -> PoseStatistics:
    """The same with the present frame and plate; itself if it has them or was counted."""
    if message.method == OBSERVED or (
            message.plate, message.header.frame_id, message.plate_error) == (
            settings.plate, settings.plate_frame, settings.plate_error):
        return message
    named = copied(message)
    named.header = Header(stamp=message.header.stamp, frame_id=settings.plate_frame)
    named.plate, named.plate_error = settings.plate, settings.plate_error
    named.revision += 1
    return named
