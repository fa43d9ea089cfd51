"""The bodies of the chart: sizes of part, each with its reference probabilities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...mesh.parts import part_from_mesh
from ...records import Part
from ...resting.poses import RestingPoses, resting_poses
from ...shapes import ellipsoid_points, hull_mesh
from ...simulation.simulate import simulate
from ..dataset import Dataset
from ..errors.simulated_poses import SimulatedPoses, pooled
from ..estimates import restings

Array = NDArray[np.float64]

SEMI_AXES = (0.45, 0.95)
"""Range of the two shorter semi-axes of an ellipsoid whose longest one is 1."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A body before any work: vertices (V, 3), triangles (T, 3) and centre of mass (3,)."""

    vertices: Array
    triangles: NDArray[np.int64]
    center_of_mass: Array

    def part(self) -> Part:
        """Make a new part, for which nothing is prepared."""
        return part_from_mesh(self.vertices, self.triangles, center_of_mass=self.center_of_mass)


@dataclass(frozen=True, eq=False)
class Size:
    """Bodies of one size.

    Attributes
    ----------
    title : str
    meshes : list of Mesh
    known : list of RestingPoses
        Stable poses of each.
    simulated : dict of float to SimulatedPoses
        Reference counts by restitution: body after body, the poses of each by `index`.
    height : float or None
        Drop height, metres; None for 20 radii.
    """

    title: str
    meshes: list[Mesh]
    known: list[RestingPoses]
    simulated: dict[float, SimulatedPoses]
    height: float | None


def paper_size(dataset: Dataset) -> Size:
    """The bodies of a dataset, with its counts."""
    bodies = [dataset.polyhedron(number) for number in range(dataset.spec.bodies)]
    vertices = dataset.arrays["vertices"]
    return Size(f"paper-size, {vertices.min()} to {vertices.max()} vertices",
                [Mesh(one.vertices, one.triangles, one.center_of_mass) for one in bodies],
                restings(dataset),
                {one: dataset.simulated(one) for one in dataset.spec.restitutions},
                dataset.spec.drop_height)


def ellipsoids(vertices: int, bodies: int, drops: int, restitutions: tuple[float, ...]) -> Size:
    """Hulls of random points on ellipsoids of different proportions, simulated here.

    Parameters
    ----------
    vertices, bodies : int
    drops : int
        Of each body at each restitution.
    restitutions : tuple of float
    """
    meshes, known, simulated = [], [], []
    for number in range(bodies):
        mesh = _ellipsoid(vertices, number)
        part = mesh.part()
        meshes.append(mesh)
        known.append(resting_poses(part, 0.0, 0))
        simulated.append([_simulated(part, drops, one, number) for one in restitutions])
    return Size(f"{vertices:,} vertices".replace(",", " "), meshes, known,
                {restitution: pooled(list(of_all)) for restitution, of_all
                 in zip(restitutions, zip(*simulated, strict=True), strict=True)}, None)


def _ellipsoid(vertices: int, number: int) -> Mesh:
    """Make one of the bodies, from these numbers alone."""
    low, high = SEMI_AXES
    b, c = np.random.default_rng((vertices, number)).uniform(low, high, 2).tolist()
    surface = hull_mesh(ellipsoid_points(vertices, number, (1.0, b, c)))
    return Mesh(*surface, part_from_mesh(*surface).center_of_mass)


def _simulated(part: Part, drops: int, restitution: float, number: int) -> SimulatedPoses:
    """Drops that ended in each pose of a body, by `index`."""
    seed = np.random.SeedSequence((number, round(restitution * 1e9))).generate_state(1, np.uint64)
    found = simulate(part, drops, restitution, int(seed[0]), cluster_tolerance=0.0, round_sides=0)
    counts = np.zeros(len(found.poses), dtype=np.int64)
    for pose in found.poses:
        counts[pose.index] = pose.count
    return SimulatedPoses(np.full_like(counts, number), counts,
                          np.full_like(counts, found.drops - found.unsettled))
