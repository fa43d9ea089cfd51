"""Features that a part's own rotations carry into each other, and steps that keep it symmetric."""

from functools import lru_cache, partial

import numpy as np
from scipy.spatial.distance import cdist

from ...core.records import Array, Index, Mask
from ...core.resting import symmetry
from . import changes

SAME_PLACE = (
    1e-3  # features that a rotation leaves this far apart, in radii, are not the same
)
SAME_DOWN = 0.999  # cosine of the angle of two directions down that are one
NOTHING = 1e-5  # share of an axis that symmetry leaves, below which it leaves none
SAME_STEP = 1e-6  # difference of two shares of a step that are equal but for rounding


def feature_images(space: changes.DesignSpace) -> tuple[Array, Index]:
    """Rotations (k, 3, 3) that take faces to faces, and where each takes every feature, (k, n)."""
    anchor = np.array([one.anchor for one in space.features[6:]])
    size = np.array([one.size for one in space.features[6:]])
    held = []
    images = []
    for rotation in proper_rotations(space):
        apart = np.linalg.norm(
            (anchor @ rotation.T)[:, None] - anchor[None], axis=2
        ) + np.abs(size[:, None] - size[None])
        if apart.min(axis=1).max() < SAME_PLACE:
            held.append(rotation)
            images.append(np.concatenate((np.arange(6), 6 + apart.argmin(axis=1))))
    return np.array(held), np.array(images)


def first_alike(space: changes.DesignSpace, kept: Mask) -> Index:
    """First feature (n,) of those that do the same to the share of wanted poses; `kept` (P,)."""
    rotations, images = feature_images(space)
    downs = space.resting.downs
    near = (downs @ rotations.transpose(0, 2, 1)) @ downs.T
    keeps = ((near.max(axis=2) > SAME_DOWN) & (kept[near.argmax(axis=2)] == kept)).all(
        axis=1
    )
    return np.asarray(
        images[keeps].min(axis=0)
    )  # they are a group, so these are whole orbits


def symmetric_steps(space: changes.DesignSpace, within: float) -> Array:
    """Steps (t, n) of the features, as far as `within`, that leave the part as symmetric as it is.

    Each is the mean of what all rotations make of one feature.
    """
    rotations, images = feature_images(space)
    count = len(space.features)
    order = len(rotations)
    mean = np.zeros((count, count))
    mean[:3, :3] = rotations.mean(axis=0).T
    # What is stretched along axis i is stretched along the i-th column of R: a tensor, which
    # changes of proportions hold where it is diagonal.
    tensors = np.einsum("kai,kbi->iab", rotations, rotations) / order
    mean[3:6, 3:6] = np.where(
        np.abs(tensors * (1.0 - np.eye(3))).max(axis=(1, 2)) < NOTHING, 1.0, 0.0
    )[:, None] * np.diagonal(tensors, axis1=1, axis2=2)
    np.add.at(
        mean, (np.tile(np.arange(6, count), order), images[:, 6:].ravel()), 1.0 / order
    )
    mean[np.abs(mean) < NOTHING] = 0.0
    most = np.abs(mean).max(axis=1)
    largest = (np.abs(mean) > most[:, None] - SAME_STEP).argmax(axis=1)
    mean /= np.where(most > 0.0, mean[np.arange(count), largest], np.inf)[:, None]
    first = (cdist(mean, mean, "chebyshev") < NOTHING).argmax(axis=1) == np.arange(
        count
    )
    steps = np.array([row for row in mean[first] if row.any()])
    reach = np.abs(space.body.points).max(axis=0) * space.body.radius
    moved = (
        np.linalg.norm(steps[:, :3], axis=1)
        + np.abs(steps[:, 3:6] * reach).max(axis=1)
        + steps[:, 6:].max(axis=1, initial=0.0)
    )
    return np.asarray(within * steps / moved[:, None])


def proper_rotations(space: changes.DesignSpace) -> Array:
    """Rotation group (k, 3, 3) of a part, the identity first; in doubt the identity alone."""
    identity = np.eye(3)
    found = space.resting.equilibria
    if found.order.shape[0] > symmetry.MOST_FACES:
        return identity[None]
    kind = symmetry.kinds_of(found)
    frames = lru_cache(maxsize=None)(partial(symmetry.frame_of, found))
    trial = symmetry.SurfaceTrial(space.part, found.body)
    # Each rotation takes a stable face to one of its kind, so those of the rarest tell them all.
    rarest = np.flatnonzero(kind == np.bincount(kind).argmin()).tolist()
    held = [identity]
    for other in rarest:
        for rotation in symmetry.candidate_rotations(frames, rarest[0], other):
            if trial.effort > symmetry.MOST_EFFORT:
                return identity[None]
            if trial.holds(rotation):
                held.append(rotation)
    return np.array(held)
