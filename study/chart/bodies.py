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

"""The bodies of the chart: kinds of part, each with its reference probabilities."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lab.bodies.shapes import Surface, ellipsoid_points, hull_mesh
from ros_pose_stats.core.mesh.parts import part_from_mesh
from ros_pose_stats.core.records import Array, DropScene, Index, Part
from ros_pose_stats.core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_ROUND_SIDES,
)
from ros_pose_stats.core.resting.poses import RestingPoses, resting_poses
from ros_pose_stats.core.simulation.simulate import simulate

from ..dataset import Dataset
from ..errors.simulated_poses import SimulatedPoses, pooled
from ..estimates import restings

PARTS_SEED = 21
"""Of the series of machined and turned parts."""

SEMI_AXES = (0.45, 0.95)
"""Range of the two shorter semi-axes of an ellipsoid whose longest one is 1."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A body before any work: vertices (V, 3), triangles (T, 3) and centre of mass
    (3,).
    """

    vertices: Array
    triangles: Index
    center_of_mass: Array

    def part(self) -> Part:
        """Make a new part, for which nothing is prepared."""
        return part_from_mesh(
            self.vertices, self.triangles, center_of_mass=self.center_of_mass
        )


@dataclass(frozen=True, eq=False)
class Size:
    """Bodies of one size or kind.

    Attributes
    ----------
    title : str
    meshes : list of Mesh
    restings : list of RestingPoses
        Stable poses of each.
    simulated : dict of float to SimulatedPoses
        Reference counts by restitution: body after body, the poses of each by `index`.
    height : float or None
        Drop height, metres; None for 20 radii.
    cluster_tolerance : float
    round_sides : int
        As for `simulate`: 0 for bare polyhedra, the defaults for parts.
    """

    title: str
    meshes: list[Mesh]
    restings: list[RestingPoses]
    simulated: dict[float, SimulatedPoses]
    height: float | None
    cluster_tolerance: float = 0.0
    round_sides: int = 0

    def scene(self, restitution: float) -> DropScene:
        """The scene of its bodies at a restitution."""
        return DropScene(
            restitution, self.height, self.cluster_tolerance, self.round_sides
        )

    @property
    def options(self) -> dict[str, Any]:
        """Keywords of the library for its bodies."""
        return {
            "cluster_tolerance": self.cluster_tolerance,
            "round_sides": self.round_sides,
        }

    def first(self, bodies: int) -> Size:
        """The first bodies alone, where there are more."""
        return replace(
            self,
            meshes=self.meshes[:bodies],
            restings=self.restings[:bodies],
            simulated={
                restitution: _first_bodies(simulated, bodies)
                for restitution, simulated in self.simulated.items()
            },
        )


def _first_bodies(simulated: SimulatedPoses, bodies: int) -> SimulatedPoses:
    is_first = simulated.body < bodies
    return SimulatedPoses(
        simulated.body[is_first], simulated.count[is_first], simulated.settled[is_first]
    )


def paper_size(dataset: Dataset) -> Size:
    """The bodies of a dataset, with its counts."""
    bodies = [dataset.polyhedron(number) for number in range(dataset.spec.bodies)]
    vertices = dataset.arrays["vertices"]
    return Size(
        f"paper-size, {vertices.min()} to {vertices.max()} vertices",
        [Mesh(body.vertices, body.triangles, body.center_of_mass) for body in bodies],
        restings(dataset),
        {
            restitution: dataset.simulated(restitution)
            for restitution in dataset.spec.restitutions
        },
        dataset.spec.drop_height,
    )


def ellipsoids(
    vertices: int, bodies: int, drops: int, restitutions: tuple[float, ...]
) -> Size:
    """Hulls of random points on ellipsoids of different proportions, simulated here.

    Parameters
    ----------
    vertices, bodies : int
    drops : int
        Of each body at each restitution.
    restitutions : tuple of float
    """
    meshes = [_ellipsoid(vertices, number) for number in range(bodies)]
    return _drop_bodies(
        f"{vertices:,} vertices".replace(",", " "), meshes, drops, restitutions, 0.0, 0
    )


def machined_parts(bodies: int, drops: int, restitutions: tuple[float, ...]) -> Size:
    """Machined and turned parts as files have them, with the default poses and round
    surfaces.

    Parameters
    ----------
    bodies : int
    drops : int
        Of each body at each restitution.
    restitutions : tuple of float
    """
    from lab.bodies.catalogue_parts import random_part

    meshes = [_homogeneous(random_part(PARTS_SEED, number)) for number in range(bodies)]
    sizes = [len(mesh.vertices) for mesh in meshes]
    return _drop_bodies(
        f"machined and turned parts, {min(sizes)} to {max(sizes)} vertices",
        meshes,
        drops,
        restitutions,
        DEFAULT_CLUSTER_TOLERANCE,
        DEFAULT_ROUND_SIDES,
    )


def _drop_bodies(
    title: str,
    meshes: list[Mesh],
    drops: int,
    restitutions: tuple[float, ...],
    cluster_tolerance: float,
    round_sides: int,
) -> Size:
    """Simulate bodies from 20 radii."""
    parts = [mesh.part() for mesh in meshes]
    poses = [resting_poses(part, cluster_tolerance, round_sides) for part in parts]
    size = Size(title, meshes, poses, {}, None, cluster_tolerance, round_sides)
    for rho in restitutions:
        counts = [
            _count_poses(part, drops, number, size.scene(rho))
            for number, part in enumerate(parts)
        ]
        size.simulated[rho] = pooled(counts)
    return size


def _ellipsoid(vertices: int, number: int) -> Mesh:
    """Make one of the bodies, from these numbers alone."""
    low, high = SEMI_AXES
    b, c = np.random.default_rng((vertices, number)).uniform(low, high, 2).tolist()
    return _homogeneous(hull_mesh(ellipsoid_points(vertices, number, (1.0, b, c))))


def _homogeneous(surface: Surface) -> Mesh:
    return Mesh(*surface, part_from_mesh(*surface).center_of_mass)


def _count_poses(
    part: Part, drops: int, number: int, scene: DropScene
) -> SimulatedPoses:
    """Drops that ended in each pose of a body, by `index`."""
    entropy = np.random.SeedSequence((number, round(scene.restitution * 1e9)))
    statistics = simulate(
        part,
        drops,
        scene.restitution,
        int(entropy.generate_state(1, np.uint64)[0]),
        cluster_tolerance=scene.cluster_tolerance,
        round_sides=scene.round_sides,
    )
    counts = statistics.column("count")
    return SimulatedPoses(
        np.full_like(counts, number),
        counts,
        np.full_like(counts, statistics.drops - statistics.unsettled),
    )
