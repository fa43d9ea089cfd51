"""Families of bodies on which estimators are fitted and judged, each an endless series."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import count

import numpy as np
from numpy.random import Generator

from ...errors import MassPropertiesError, MeshError
from ...geometry.mass_properties import solid_of
from ...geometry.poses import resting_poses
from ...geometry.shapes import hull_mesh
from ...geometry.shapes.profiles import unit_circle
from ...geometry.shapes.random_polyhedra import random_polyhedron
from ...records import Part
from ...records.scene import DEFAULT_CLUSTER_TOLERANCE
from .machined import machined
from .solids import Solid, assembled, block, extruded

Maker = Callable[[Generator], list[Solid]]

_TOO_FLAT = 0.02
"""Bodies thinner than this, in radii, are drawn anew."""


def prisms(draw: Generator) -> list[Solid]:
    """Regular prisms of 3 to 12 sides, or boxes, with ratios from 1/3 to 3."""
    if draw.random() < 0.3:
        x, y, z = np.exp(draw.uniform(-math.log(2.5), math.log(2.5), 3)).tolist()
        return [extruded(np.array([(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)]), 0.0, z)]
    sides = int(draw.choice([3, 4, 4, 4, 5, 6, 6, 8, 10, 12]))
    across = 2.0 * math.cos(math.pi / sides)
    ratio = float(np.exp(draw.uniform(-math.log(3.0), math.log(3.0))))
    return [extruded(unit_circle(sides), 0.0, across * ratio)]


def plates(draw: Generator) -> list[Solid]:
    """Convex outlines of 3 to 8 corners, 0.04 to 0.5 thick, some with bevelled edges."""
    corners = int(draw.integers(3, 9))
    turn = (np.arange(corners) + draw.uniform(-0.35, 0.35, corners)) * (2 * math.pi / corners)
    outline = np.stack([np.cos(turn), np.sin(turn)], axis=1) * (1.0, draw.uniform(0.4, 1.0))
    thick = float(np.exp(draw.uniform(math.log(0.08), math.log(1.0))))
    if draw.random() < 0.4:
        top = np.column_stack((outline * draw.uniform(0.5, 0.95), np.full(corners, thick)))
        return [Solid(np.vstack((np.column_stack((outline, np.zeros(corners))), top)))]
    return [extruded(outline, 0.0, thick)]


def ellipsoids(draw: Generator) -> list[Solid]:
    """Hulls of 8 to 60 points on an ellipsoid."""
    points = draw.normal(size=(round(math.exp(draw.uniform(math.log(8), math.log(60)))), 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return [Solid(points * (1.0, *draw.uniform(0.35, 1.0, 2)))]


def rounds(draw: Generator) -> list[Solid]:
    """Turned parts: convex profiles of two to five circles with 12 to 48 sides."""
    sides, circles = int(draw.integers(12, 49)), int(draw.integers(2, 6))
    height = math.exp(draw.uniform(-math.log(4.0), math.log(4.0)))
    level = np.concatenate(([0.0, height], draw.uniform(0.0, height, circles - 2)))
    radius = draw.uniform(0.3, 1.0, circles)
    if draw.random() < 0.4:
        radius[1] = radius[0]
    rings = [np.column_stack((unit_circle(sides) * r, np.full(sides, z)))
             for r, z in zip(radius, level, strict=True)]
    return [Solid(np.vstack(rings))]


def cornered(draw: Generator) -> list[Solid]:
    """Hulls of 12 to 80 normally distributed points, stretched along the axes."""
    count_of_points = round(math.exp(draw.uniform(math.log(12), math.log(80))))
    return [Solid(draw.normal(size=(count_of_points, 3)) * (1.0, *draw.uniform(0.4, 1.0, 2)))]


def weighted(draw: Generator) -> list[Solid]:
    """A prism, plate, turned part or hull of points, with one to three weights inside.

    What lies inside a hull is hollow in one part and solid in the next: the centre of mass
    and the inertia are not those of the hull.
    """
    makers = (prisms, plates, rounds, cornered)
    (shell,) = makers[int(draw.integers(len(makers)))](draw)
    corners = shell.corners
    size = 0.01 * float(np.ptp(corners, axis=0).min())
    volume = solid_of(*hull_mesh(corners)).volume
    solids = [shell]
    for _ in range(int(draw.integers(1, 4))):
        share = draw.dirichlet(np.full(corners.shape[0], draw.choice([0.1, 1.0])))
        place = 0.97 * share @ corners + 0.03 * corners.mean(axis=0)
        mass = volume * draw.uniform(0.1, 1.5)
        low, high = place - 0.5 * size, place + 0.5 * size
        weight = block((low[0], low[1], low[2]), (high[0], high[1], high[2]))
        solids.append(Solid(weight.corners, mass / size ** 3))
    return solids


MADE: dict[str, Maker] = {"prisms": prisms, "plates": plates, "ellipsoids": ellipsoids,
                          "machined": machined, "rounds": rounds, "cornered": cornered,
                          "weighted": weighted}
DRAWN: dict[str, tuple[float, str]] = {
    "polyhedra 0": (0.0, "inertia"), "polyhedra 0.25": (0.25, "inertia"),
    "polyhedra 0.65 second": (0.65, "second"), "polyhedra 1": (1.0, "inertia")}

FAMILIES: tuple[str, ...] = (*DRAWN, *MADE)


def family_part(family: str, seed: int, number: int) -> Part:
    """One body of a family, about its centre of mass and in metres; always the same one.

    Parameters
    ----------
    family : str
        Out of `FAMILIES`.
    seed : int
        Of the series, 0 to 2^63.
    number : int
        Place in the series, from 0.
    """
    if family in DRAWN:
        return random_polyhedron(seed, number, *DRAWN[family]).part()
    for attempt in count():
        draw = np.random.Generator(np.random.Philox(np.random.SeedSequence(
            (seed, number, attempt, *family.encode()))))
        try:
            part = assembled(MADE[family](draw))
            found = resting_poses(part, family_tolerance(family))
        except (MeshError, MassPropertiesError):
            continue
        if len(found.poses) > 1 and float(found.equilibria.heights.min()) > _TOO_FLAT:
            return part
    raise AssertionError


def family_tolerance(family: str) -> float:
    """Cluster tolerance at which a family's poses are counted."""
    return 0.0 if family in DRAWN else DEFAULT_CLUSTER_TOLERANCE
