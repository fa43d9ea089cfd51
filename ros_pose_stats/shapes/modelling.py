"""Solids made as a machinist would: outlines extruded and revolved, then cut.

This is where the solid modeller manifold3d is used; lengths are in millimetres.
"""

from __future__ import annotations

import numpy as np
from manifold3d import CrossSection, Manifold
from numpy.typing import NDArray

from ..mesh.arrays import in_standard_order
from .closed_forms import Surface
from .profiles import Outline, unit_circle


def extrude(outline: Outline, axis: str, start: float, stop: float) -> Manifold:
    """Solid over an outline in the two axes that follow `axis` in the cycle x, y, z."""
    solid = CrossSection([outline]).extrude(stop - start).translate((0.0, 0.0, start))
    order = {"x": (2, 0, 1), "y": (1, 2, 0), "z": (0, 1, 2)}[axis]
    return solid.transform(np.eye(3, 4)[list(order)])


def drill(radius: float, axis: str, center: tuple[float, float], start: float, stop: float,
          sides: int = 32) -> Manifold:
    """Drilling tool along an axis; its center as in `extrude`."""
    return extrude(radius * unit_circle(sides) + np.array(center), axis, start, stop)


def revolve(outline: Outline, sides: int) -> Manifold:
    """Solid around z; the outline gives (distance from the axis, z)."""
    return CrossSection([outline]).revolve(sides)


def surface_of(solid: Manifold) -> Surface:
    """Triangles of a solid."""
    mesh = solid.to_mesh64()
    vertices = np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3]
    return in_file_order(vertices, np.asarray(mesh.tri_verts, dtype=np.int64))


def in_file_order(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Surface:
    """Coordinates as float32 numbers, vertices and triangles in lexicographic order.

    So files do not depend on the order in which a modeller emits triangles.
    """
    rounded = vertices.astype(np.float32).astype(np.float64) + 0.0
    merged, index = np.unique(rounded, axis=0, return_inverse=True)
    return merged, in_standard_order(index.reshape(-1)[triangles])
