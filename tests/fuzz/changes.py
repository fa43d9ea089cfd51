"""The same body given differently: turned, renumbered, cut finer, with more points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ros_pose_stats.shapes import Surface

Array = NDArray[np.float64]
Random = np.random.Generator


def rotation(random: Random) -> Array:
    """Random rotation matrix."""
    return np.asarray(Rotation.from_quat(random.standard_normal(4)).as_matrix())


def turned(surface: Surface, random: Random) -> Surface:
    """Turned at random."""
    return surface[0] @ rotation(random).T, surface[1]


def shuffled(surface: Surface, random: Random) -> Surface:
    """Vertices and triangles in another order, each triangle from another corner."""
    vertices, triangles = surface
    order = random.permutation(len(vertices))
    mixed = np.argsort(order)[triangles][random.permutation(len(triangles))]
    start = random.integers(3, size=len(mixed))[:, None]
    return vertices[order], np.take_along_axis(mixed, (start + np.arange(3)) % 3, axis=1)


def subdivided(surface: Surface) -> Surface:
    """Each triangle cut into four at the middles of its edges."""
    vertices, triangles = surface
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    middle = vertices[unique].mean(axis=1)
    a, b, c = triangles.T
    ab, bc, ca = (index.reshape(-1, 3) + len(vertices)).T
    fine = np.concatenate([np.column_stack(corners) for corners in
                           ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return np.vstack((vertices, middle)), fine


def split(surface: Surface) -> Surface:
    """Each triangle with three vertices of its own."""
    vertices, triangles = surface
    return vertices[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)


def joined(*surfaces: Surface) -> Surface:
    """Several surfaces as one mesh."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in surfaces)])
    return (np.vstack([vertices for vertices, _ in surfaces]),
            np.vstack([triangles + start for (_, triangles), start
                       in zip(surfaces, starts[:-1], strict=True)]))


def with_pocket(surface: Surface, around: Array, factor: float = 0.3) -> Surface:
    """With a void of its own shape inside, shrunk towards a point."""
    vertices, triangles = surface
    return joined(surface, (around + factor * (vertices - around), triangles[:, ::-1]))
