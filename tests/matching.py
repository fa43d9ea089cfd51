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

"""Poses of differently given parts, matched by the direction that points down."""

from array import array
from collections import Counter
from functools import cache

import numpy as np
from scipy.spatial import cKDTree

from ros_pose_stats import part_from_mesh, resting_poses


def downs(poses):
    """Directions (P, 3)."""
    return np.array([pose.down for pose in poses])


def values(poses, name):
    """One field of every pose (P,)."""
    return np.array([getattr(pose, name) for pose in poses])


def matched(poses, others, turn=None, angle=1e-6):
    """`others` in the order of `poses`, where `turn` carries the first part to the
    second.

    Fails unless the poses match one to one within an angle.
    """
    expected = downs(poses) if turn is None else downs(poses) @ np.asarray(turn).T
    gap, partner = cKDTree(downs(others)).query(expected)
    assert len(poses) == len(others), f"{len(poses)} poses became {len(others)}"
    assert gap.max() < angle
    assert len(np.unique(partner)) == len(others)
    return [others[i] for i in partner]


def group_sizes(surface, tolerance=0.0, **properties):
    """Numbers of poses in each group, rising."""
    poses = resting_poses(part_from_mesh(*surface, **properties), tolerance, 0).poses
    return sorted(Counter(pose.group for pose in poses).values())


@cache
def field_names(kind):
    return tuple(kind.get_fields_and_field_types())


def same(first, second):
    """Whether two messages of different classes hold the same values; NaN equals
    NaN.
    """
    if hasattr(second, "get_fields_and_field_types"):
        return all(
            same(getattr(first, name), getattr(second, name))
            for name in field_names(type(second))
        )
    if isinstance(second, (bool, int, float, str)):
        return first == second or (first != first and second != second)
    if isinstance(second, (array, np.ndarray)):
        return np.array_equal(first, second, equal_nan=True)
    return len(first) == len(second) and all(map(same, first, second))
