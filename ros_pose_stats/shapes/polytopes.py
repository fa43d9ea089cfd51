"""Corners of the regular solids, and their triangulation from corners and face normals.

The face normals of a regular solid are the corners of its dual, so that four sets of points
make all five solids.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Surface = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices (V, 3) and outward triangles (T, 3) of a closed surface."""

_GOLDEN = (1.0 + np.sqrt(5.0)) / 2.0


def cube_corners() -> NDArray[np.float64]:
    """The eight points (±1, ±1, ±1)."""
    return np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


def axis_ends() -> NDArray[np.float64]:
    """The six points ±x, ±y, ±z."""
    return np.vstack((np.eye(3), -np.eye(3))) + 0.0


def _golden_rectangles(short: float, long: float) -> NDArray[np.float64]:
    """The twelve corners of three mutually perpendicular rectangles."""
    rectangle = [(0.0, s * short, t * long) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    return np.vstack([np.roll(rectangle, turn, axis=1) for turn in range(3)])


def icosahedron_corners() -> NDArray[np.float64]:
    """The twelve corners of the icosahedron of edge 2."""
    return _golden_rectangles(1.0, _GOLDEN)


def dodecahedron_corners() -> NDArray[np.float64]:
    """The twenty corners of the dodecahedron around the cube [-1, 1]³."""
    return np.vstack((cube_corners(), _golden_rectangles(_GOLDEN, _GOLDEN - 1.0)))


def polytope(vertices: NDArray[np.float64], normals: NDArray[np.float64]) -> Surface:
    """Fan-triangulated regular solid from its corners and outward face normals (any length)."""
    triangles = [fan for normal in normals for fan in _face_fan(vertices, normal)]
    return vertices, np.array(triangles, dtype=np.int64)


def _face_fan(
    vertices: NDArray[np.float64], normal: NDArray[np.float64]
) -> list[tuple[int, int, int]]:
    """Triangles of the face farthest along `normal`, counter-clockwise from outside."""
    reach = vertices @ normal
    face = np.flatnonzero(reach > 0.5 * reach.max())  # others of a regular solid: below 0.24
    spokes = vertices[face] - vertices[face].mean(axis=0)
    x_axis = spokes[0]
    y_axis = np.cross(normal, x_axis) / np.linalg.norm(normal)
    around = face[np.argsort(np.arctan2(spokes @ y_axis, spokes @ x_axis) % (2.0 * np.pi))]
    first, *rest = around.tolist()
    return [(first, a, b) for a, b in pairwise(rest)]
