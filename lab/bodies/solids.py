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

"""Bodies assembled from convex solids that touch, with holes cut out of them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from ros_pose_stats.core.mesh.parts import part_from_mesh
from ros_pose_stats.core.mesh.surface import solid_of
from ros_pose_stats.core.mesh.vectors import to_unit_size
from ros_pose_stats.core.records import Array, Index, Part

from .shapes import hull_mesh, lofted


@dataclass(frozen=True, eq=False)
class Solid:
    """A solid of density 1 (-1 for a hole), convex where it has no triangles of its
    own.

    Attributes
    ----------
    corners : (V, 3) array
    density : float
    triangles : (T, 3) array of int, optional
        Outward; the convex hull's by default.
    """

    corners: Array
    density: float = 1.0
    triangles: Index | None = None

    def hole(self) -> Solid:
        """The same solid as a hole."""
        return Solid(self.corners, -1.0, self.triangles)

    def surface(self) -> tuple[Array, Index]:
        """Vertices and triangles."""
        if self.triangles is None:
            return hull_mesh(self.corners)
        return self.corners, self.triangles


def extruded(outline: Array, low: float, high: float, axis: int = 2) -> Solid:
    """A convex outline (k, 2) drawn along an axis; its plane keeps the order of the
    others.
    """
    layers = [np.insert(outline, axis, level, axis=1) for level in (low, high)]
    return Solid(np.concatenate(layers))


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Solid:
    """A box between two corners."""
    x = (low[0], high[0])
    y = (low[1], high[1])
    return extruded(np.array([(a, b) for a in x for b in y]), low[2], high[2])


def fan(outline: Array, low: float, high: float) -> Solid:
    """An outline (k, 2) around the z axis, counter-clockwise, drawn along it; as
    star-shaped.
    """
    rings = np.array([np.insert(outline, 2, level, axis=1) for level in (low, high)])
    corners, triangles = lofted(rings, np.array([(0.0, 0.0, low), (0.0, 0.0, high)]))
    return Solid(corners, triangles=triangles)


def tapered(outline: Array, levels: Iterable[tuple[float, float]]) -> Solid:
    """The hull of a convex outline (k, 2) across z, scaled and at a height for each of
    the levels.
    """
    return Solid(
        np.vstack(
            [np.insert(outline * scale, 2, level, axis=1) for scale, level in levels]
        )
    )


def cube(center: Array, half: float, density: float) -> Solid:
    """A cube of an edge of twice `half` along the axes."""
    x, y, z = zip(center - half, center + half, strict=True)
    outline = np.array([(a, b) for a in x for b in y])
    return Solid(extruded(outline, *z).corners, density)


def around(corners: int, jitter: float, draw: Generator) -> Array:
    """Points (k, 2) on the unit circle at nearly even angles, off by up to a share of
    the step.
    """
    turn = (np.arange(corners) + draw.uniform(-jitter, jitter, corners)) * (
        2 * math.pi / corners
    )
    return np.stack([np.cos(turn), np.sin(turn)], axis=1)


def assembled(solids: list[Solid]) -> Part:
    """Assemble solids that at most touch, less the holes in them, into one part scaled
    to 1 m.

    Its surface is the convex hull, or where a solid has triangles of its own, those of
    all solids; its mass properties are those of the solids.
    """
    whole = [
        solid_of(to_unit_size(vertices), triangles)
        for vertices, triangles in (solid.surface() for solid in solids)
    ]
    density = np.array([solid.density for solid in solids])
    masses = density * np.array([body.volume for body in whole])
    centers = np.array([body.centroid for body in whole])
    mass = float(masses.sum())
    center = masses @ centers / mass
    inertia = np.zeros((3, 3))
    for body, sign, part, offset in zip(
        whole, density, masses, centers - center, strict=True
    ):
        inertia += sign * body.inertia
        inertia += part * ((offset @ offset) * np.eye(3) - np.outer(offset, offset))
    full = [solid for solid in solids if solid.density > 0.0]
    corners = np.concatenate([solid.corners for solid in full])
    size = float(np.linalg.norm(corners - center, axis=1).max())
    vertices, triangles = _surface(full)
    return part_from_mesh(
        (vertices - center) / size,
        triangles,
        center_of_mass=np.zeros(3),
        mass=1.0,
        inertia=inertia / (mass * size * size),
    )


def _surface(solids: list[Solid]) -> tuple[Array, Index]:
    """Of the hull of all, or where one has triangles of its own, of each."""
    if all(solid.triangles is None for solid in solids):
        return hull_mesh(np.concatenate([solid.corners for solid in solids]))
    count = 0
    vertices = []
    triangles = []
    for corners, faces in (solid.surface() for solid in solids):
        vertices.append(corners)
        triangles.append(faces + count)
        count += len(corners)
    return np.concatenate(vertices), np.concatenate(triangles)
