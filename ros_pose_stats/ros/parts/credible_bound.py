"""The error that a result keeps with 90 % confidence, told from its message."""

from __future__ import annotations

import numpy as np
from ros_pose_stats_msgs.msg import PoseStatistics

from ...methods import HYBRID
from ...planning.confidence import (
    estimate_bound,
    plain_bound,
    pose_prior,
    prior_bound,
    prior_of,
)
from ...records import DropScene, Part
from ...resting.poses import resting_poses


def credible_bound(part: Part, message: PoseStatistics, scene: DropScene) -> float:
    """Bound of the error over the poses, against what infinitely many drops would give.

    Parameters
    ----------
    part : Part
    message : PoseStatistics
        Of this part in this scene.
    scene : DropScene

    Returns
    -------
    float
        A fraction; infinite where the method does not know so low a drop.
    """
    resting = resting_poses(part, scene.cluster_tolerance)
    if not message.drops:
        return estimate_bound(prior_of(message, resting, scene))
    counts = np.zeros(len(resting.poses), dtype=np.int64)
    for pose in message.poses:
        counts[pose.index] = pose.count
    if message.method == HYBRID:
        return prior_bound(pose_prior(resting, scene))(counts)
    return plain_bound(counts)
