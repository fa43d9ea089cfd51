"""Features that the part's own rotations carry into each other."""

from functools import lru_cache, partial

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..records import Array, Index, Mask, Part
from ..resting import equilibria, symmetry
from . import changes, features

SAME_PLACE = 1e-3
"""Features that a rotation leaves this far apart, in radii, are not the same."""

SAME_DOWN = 0.999
"""Cosine of the angle of two directions down that are one."""


def feature_images(space: changes.DesignSpace) -> tuple[Array, Index]:
    """The part's rotations (k, 3, 3) and where each takes every feature, (k, n).

    Axes stay themselves; rotations that do not take faces to faces are left out.
    """
    faces = np.flatnonzero(space.kinds == features.FACE)
    anchor = np.array([space.features[face].anchor for face in faces])
    size = np.array([space.features[face].size for face in faces])
    held, images = [], []
    for rotation in proper_rotations(space.part, space.resting.equilibria):
        image = np.arange(len(space.features))
        apart = np.linalg.norm((anchor @ rotation.T)[:, None] - anchor[None],
                               axis=2) + np.abs(size[:, None] - size[None])
        image[faces] = np.where(apart.min(axis=1) < SAME_PLACE, faces[apart.argmin(axis=1)], -1)
        if image.min() >= 0:
            held.append(rotation)
            images.append(image)
    return np.array(held), np.array(images)


def alike(space: changes.DesignSpace, kept: Mask) -> Index:
    """First feature (n,) of those that do the same to the share of the wanted poses.

    `kept` (P,) bool: the wanted poses. Only rotations count that take wanted poses to wanted ones.
    """
    rotations, images = feature_images(space)
    downs = np.array([pose.down for pose in space.resting.poses])
    keeps = []
    for rotation in rotations:
        near = (downs @ rotation.T) @ downs.T
        keeps.append((near.max(axis=1) > SAME_DOWN).all()
                     and bool((kept[near.argmax(axis=1)] == kept).all()))
    return first_of_orbits(images[np.array(keeps, dtype=np.bool_)])


def first_of_orbits(images: Index) -> Index:
    """First feature (n,) of those that images (k, n) join."""
    count = images.shape[1]
    rows = np.tile(np.arange(count), len(images))
    graph = coo_array((np.ones(rows.size), (rows, images.ravel())), shape=(count, count))
    _, orbit = connected_components(graph, directed=False)
    return np.asarray(np.unique(orbit, return_index=True)[1][orbit], dtype=np.int64)


def proper_rotations(part: Part, found: equilibria.Equilibria) -> Array:
    """Rotation group of a part.

    Each rotation takes a stable face to one of its kind, so that those of the rarest kind tell
    them all. In doubt, and where there are too many to try, there is the identity alone.

    Returns (k, 3, 3): the identity first.
    """
    identity = np.eye(3)[None]
    if found.order.shape[0] > symmetry.MOST_FACES:
        return identity
    kind = symmetry.kinds_of(found)
    frames = lru_cache(maxsize=None)(partial(symmetry.frame_of, found))
    trial = symmetry.SurfaceTrial(part, found.body)
    rarest = np.flatnonzero(kind == np.bincount(kind).argmin())
    held = []
    for other in rarest.tolist():
        for rotation in symmetry.candidates(frames, int(rarest[0]), other):
            if trial.effort > symmetry.MOST_EFFORT:
                return identity
            if trial.holds(rotation):
                held.append(rotation)
    return np.concatenate((identity, np.array(held).reshape(-1, 3, 3)))
