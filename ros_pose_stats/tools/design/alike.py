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

"""Features that a part's rotations carry into each other, and symmetric steps."""

import numpy as np
from scipy.spatial.distance import cdist

from ...core.kernels.features.motions import candidate_motions
from ...core.records import Array, Index, Mask
from ...core.resting import symmetry
from . import changes
from .goal import Goal

PLACE_TOLERANCE = 1e-3
"""Features that a rotation leaves this far apart, in radii, are not the same."""
DOWN_COSINE = 0.999  # cosine of the angle of two directions down that are one
STEP_TOLERANCE = 1e-5
"""Share of an axis that symmetry leaves, below which it leaves none."""
TIE_TOLERANCE = 1e-6
"""Difference of two shares of a step that are equal but for rounding."""
SAME_MOTION = 1e-3  # difference of entries of two rotations that are one


def feature_images(space: changes.DesignSpace) -> tuple[Array, Index]:
    """Rotations (k, 3, 3) of faces to faces, and where they take features (k, n)."""
    anchor = np.array([feature.anchor for feature in space.features[6:]])
    size = np.array([feature.size for feature in space.features[6:]])
    kept_rotations = []
    images = []
    for rotation in proper_rotations(space):
        distance = np.linalg.norm(
            (anchor @ rotation.T)[:, None] - anchor[None], axis=2
        ) + np.abs(size[:, None] - size[None])
        if distance.min(axis=1).max() < PLACE_TOLERANCE:
            kept_rotations.append(rotation)
            images.append(np.concatenate((np.arange(6), 6 + distance.argmin(axis=1))))
    return np.array(kept_rotations), np.array(images)


def first_equivalents(space: changes.DesignSpace, goal: Goal) -> Index:
    """First feature (n,) of those that change how far the goal is met alike."""
    rotations, images = feature_images(space)
    # They are a group, so these are whole orbits.
    return np.asarray(images[_keeping_rotations(space, rotations, goal)].min(axis=0))


def _keeping_rotations(
    space: changes.DesignSpace, rotations: Array, goal: Goal
) -> Mask:
    """Which rotations (k,) of the part leave a goal as it is."""
    downs = space.resting.downs
    cosine = (downs @ rotations.transpose(0, 2, 1)) @ downs.T
    is_symmetric = (cosine.max(axis=2) > DOWN_COSINE).all(axis=1)
    is_kept = [goal.is_kept(images) for images in cosine.argmax(axis=2)]
    return np.asarray(is_symmetric & is_kept)


def symmetric_steps(space: changes.DesignSpace, length: float, goal: Goal) -> Array:
    """Steps (t, n) of the features that leave the part as symmetric as it is.

    Where shares are wanted of poses that are alike, it is left as symmetric as these
    are. `length`: how far each moves the outline, metres.

    Each is the mean of what all rotations make of one feature.
    """
    rotations, images = feature_images(space)
    if goal.has_shares:
        is_kept = _keeping_rotations(space, rotations, goal)
        rotations = rotations[is_kept]
        images = images[is_kept]
    count = len(space.features)
    order = len(rotations)
    mean = np.zeros((count, count))
    mean[:3, :3] = rotations.mean(axis=0).T
    # What is stretched along axis i is stretched along the i-th column of R: a tensor,
    # which changes of proportions hold where it is diagonal.
    tensors = np.einsum("kai,kbi->iab", rotations, rotations) / order
    oblique = np.abs(tensors * (1.0 - np.eye(3))).max(axis=(1, 2), keepdims=True)
    tensors = np.where(oblique < STEP_TOLERANCE, tensors, 0.0)
    mean[3:6, 3:6] = np.diagonal(tensors, axis1=1, axis2=2)
    np.add.at(
        mean, (np.tile(np.arange(6, count), order), images[:, 6:].ravel()), 1.0 / order
    )
    mean[np.abs(mean) < STEP_TOLERANCE] = 0.0
    steps = mean[mean.any(axis=1)]
    size = np.abs(steps)
    is_largest = size > size.max(axis=1, keepdims=True) - TIE_TOLERANCE
    steps /= np.take_along_axis(steps, is_largest.argmax(axis=1, keepdims=True), axis=1)
    first_copy = (cdist(steps, steps, "chebyshev") < STEP_TOLERANCE).argmax(axis=1)
    steps = steps[first_copy == np.arange(len(steps))]
    reach = np.abs(space.body.points).max(axis=0) * space.body.radius
    reach_of_step = (
        np.linalg.norm(steps[:, :3], axis=1)
        + np.abs(steps[:, 3:6] * reach).max(axis=1)
        + steps[:, 6:].max(axis=1, initial=0.0)
    )
    return np.asarray(length * steps / reach_of_step[:, None])


def proper_rotations(space: changes.DesignSpace) -> Array:
    """Rotation group (k, 3, 3) of a part, the identity first, and alone in doubt."""
    identity = np.eye(3)
    equilibria = space.resting.equilibria
    if equilibria.order.shape[0] > symmetry.MOST_FACES:
        return identity[None]
    trial = symmetry.surface_trial(space.part, equilibria.body)
    rotations = [identity]
    planes = symmetry.hull_trial(space.part, equilibria.body).planes
    for motion in candidate_motions(planes, len(planes.area)):
        is_new = all(np.abs(motion - other).max() > SAME_MOTION for other in rotations)
        if np.linalg.det(motion) > 0.0 and is_new and trial.holds(motion):
            rotations.append(motion)
    return (
        np.array(rotations) if trial.effort <= symmetry.MOST_EFFORT else identity[None]
    )
