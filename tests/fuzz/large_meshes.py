"""Large inputs that are bad on purpose, up to 100 000 triangles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ros_pose_stats import shapes
from ros_pose_stats.shapes import Surface

from .changes import Array, joined, split

TRIANGLES = 100_000

def _random() -> np.random.Generator:
    return np.random.default_rng(1)


def loose_triangles() -> Surface:
    """Triangles anywhere in a ball."""
    return split((_random().standard_normal((3 * TRIANGLES, 3)),
                  np.arange(3 * TRIANGLES).reshape(-1, 3)))


def tangle() -> Surface:
    """Triangles between a thousand random vertices: every edge is crowded."""
    random = _random()
    return random.standard_normal((1000, 3)), random.integers(1000, size=(TRIANGLES, 3))


def closed_tangle() -> Surface:
    """Tetrahedra between 200 vertices: closed, and every edge is shared by hundreds."""
    random = _random()
    corners = random.integers(200, size=(TRIANGLES // 4, 4))
    faces = corners[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]]
    return random.standard_normal((200, 3)), faces.reshape(-1, 3)


def lattice_tangle() -> Surface:
    """Triangles between the points of a lattice, many of them coplanar or without area."""
    random = _random()
    return (random.integers(0, 12, (5000, 3)).astype(float),
            random.integers(5000, size=(TRIANGLES, 3)))


def ring() -> Surface:
    """A disc of 20 000 cocircular points a side."""
    return shapes.prism(20_000, 1.0, 0.5)


def cone() -> Surface:
    """A fan of 50 000 triangles to one apex, on a disc."""
    base, triangles = shapes.prism(TRIANGLES // 2, 1.0, 1.0)
    count = TRIANGLES // 2
    around = np.arange(count)
    sides = np.column_stack((around, np.roll(around, -1), np.full(count, count)))
    return (np.vstack((base[:count], (0.0, 0.0, 1.0))),
            np.vstack((triangles[:count - 2], sides)))


def sphere() -> Surface:
    """50 000 random points on a sphere: nearly half of the facets are stable."""
    return shapes.hull_mesh(shapes.sphere_points(TRIANGLES // 2, 1))


def sphere_of_rings() -> Surface:
    """50 000 points on parallels of a sphere, all cocircular."""
    heights = np.linspace(-1.0, 1.0, 102)[1:-1]
    angles = 2.0 * np.pi * np.arange(500) / 500
    rings = [np.sqrt(1.0 - z * z) * np.column_stack((np.cos(angles), np.sin(angles)))
             for z in heights]
    points = np.vstack([np.column_stack((xy, np.full(500, z)))
                        for xy, z in zip(rings, heights, strict=True)])
    return shapes.hull_mesh(points)


def boxes() -> Surface:
    """8 000 boxes of a lattice, each touching its neighbours."""
    return _boxes(1.0)


def crossing_boxes() -> Surface:
    """8 000 boxes that reach into all their neighbours."""
    return _boxes(1.5)


def nested_boxes() -> Surface:
    """8 000 boxes, each in the next."""
    vertices, triangles = shapes.box(1.0, 1.0, 1.0)
    return joined(*((vertices * factor, triangles) for factor in np.linspace(0.1, 1.0, 8000)))


def _boxes(size: float) -> Surface:
    places: Array = np.stack(np.meshgrid(*[np.arange(20.0)] * 3), axis=-1).reshape(-1, 3)
    vertices, triangles = shapes.box(size, size, size)
    return joined(*((vertices + place, triangles) for place in places))


def dust() -> Surface:
    """A sphere in which all vertices are within a few welds of another."""
    vertices, triangles = split(shapes.hull_mesh(shapes.sphere_points(16_000, 1)))
    return vertices + 1e-8 * _random().standard_normal(vertices.shape), triangles


def coincident() -> Surface:
    """Triangles whose corners are all one point."""
    return np.ones((TRIANGLES, 3)), np.arange(3 * TRIANGLES).reshape(-1, 3) % TRIANGLES


def flat() -> Surface:
    """Triangles in one plane."""
    vertices, triangles = loose_triangles()
    return vertices * (1.0, 1.0, 0.0), triangles


def needle() -> Surface:
    """A prism of 25 000 sides, a thousandth as wide as long."""
    return shapes.prism(TRIANGLES // 4, 1e-3, 1.0)


CASES: dict[str, Callable[[], Surface]] = {
    function.__name__.replace("_", " "): function for function in (
        loose_triangles, tangle, closed_tangle, lattice_tangle, ring, cone, sphere,
        sphere_of_rings, boxes, crossing_boxes, nested_boxes, dust, coincident, flat, needle)
}
