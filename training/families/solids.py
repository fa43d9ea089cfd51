"""Bodies assembled from convex solids that touch, with holes cut out of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.mesh.mass_properties import solid_of
from ros_pose_stats.mesh.parts import part_from_mesh
from ros_pose_stats.records import Part
from ros_pose_stats.shapes import hull_mesh

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solid:
    """A convex solid of density 1 (-1 for a hole).

    Attributes
    ----------
    corners : (V, 3) array
    density : float
    """

    corners: Array
    density: float = 1.0

    def hole(self) -> Solid:
        """The same solid as a hole."""
        return Solid(self.corners, -1.0)


def extruded(outline: Array, low: float, high: float, axis: int = 2) -> Solid:
    """A convex outline (k, 2) drawn along an axis; its plane keeps the order of the others."""
    layers = [np.insert(outline, axis, level, axis=1) for level in (low, high)]
    return Solid(np.concatenate(layers))


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Solid:
    """A box between two corners."""
    x, y = (low[0], high[0]), (low[1], high[1])
    return extruded(np.array([(a, b) for a in x for b in y]), low[2], high[2])


def assembled(solids: list[Solid]) -> Part:
    """Assemble solids that at most touch, less the holes in them, into one part scaled to 1 m.

    Its surface is the convex hull, its mass properties are those of the solids.
    """
    whole = [solid_of(*hull_mesh(solid.corners)) for solid in solids]
    density = np.array([solid.density for solid in solids])
    masses = density * np.array([one.volume for one in whole])
    centers = np.array([one.centroid for one in whole])
    mass = float(masses.sum())
    center = masses @ centers / mass
    inertia = np.zeros((3, 3))
    for one, sign, part, away in zip(whole, density, masses, centers - center, strict=True):
        inertia += sign * one.inertia
        inertia += part * ((away @ away) * np.eye(3) - np.outer(away, away))
    there = np.concatenate([solid.corners for solid in solids if solid.density > 0.0])
    size = float(np.linalg.norm(there - center, axis=1).max())
    vertices, triangles = hull_mesh((there - center) / size)
    return part_from_mesh(vertices, triangles, center_of_mass=np.zeros(3), mass=1.0,
                          inertia=inertia / (mass * size * size))
