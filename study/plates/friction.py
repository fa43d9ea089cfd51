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

"""A second simulator, with friction and moving releases: it stands for real plates.

Nothing is shared with the drops of the product. The part flies with constant angular
momentum, by midpoint steps that are short against its distance from the plate. At a
touching corner the impulse is integrated along its normal part with Coulomb friction,
and the restitution is that of energy (Stronge, Impact Mechanics, 2000). A drop ends
once its energy is too small to leave the face that it is about to lie on.
"""

import json
import math
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np

from lab.bodies.shapes import box, ellipsoid_points, hull_mesh, prism
from ros_pose_stats.core.mesh.parts import part_from_mesh
from ros_pose_stats.core.mesh.vectors import rotation_matrices
from ros_pose_stats.core.records import Array, Index, Part
from ros_pose_stats.core.records.scene import GRAVITY
from ros_pose_stats.core.resting.poses import resting_poses

FILE = Path(__file__).with_name("counts.json")
PLATES = 10
DROPS = 500

SHORTEST = 8e-3
"""Of a step, in the time in which a part falls by its radius."""

TURN = 0.05
"""Most that a step turns the part, radians."""

SLOWEST = 0.03
"""Approach below which nothing rebounds, over the speed of a fall by the radius."""

SLICES = 24
FEW_SLICES = 3
"""Of the normal impulse up to greatest compression; fewer where nothing rebounds."""

MOST_STEPS = 400_000
NEAR = 0.2
"""Share of its barrier to which a part's energy falls before it counts as at rest."""


class RealPlate(NamedTuple):
    """A plate and how parts are released over it."""

    restitution: float
    friction: float
    drop_height: float  # metres
    speed: float  # along the plate, m/s
    spin: float  # about a random axis, rad/s

    def in_words(self) -> str:
        """For a table."""
        feeding = "moving" if self.speed else "at rest"
        return (
            f"restitution {self.restitution:.2f}, friction {self.friction:.2f}, "
            f"{1e3 * self.drop_height:.0f} mm, {feeding}"
        )


def plate_of(number: int) -> RealPlate:
    """One of the plates of the study; every other one is fed by parts that move."""
    random = np.random.default_rng((1, number))
    moving = number % 2
    restitution = float(random.uniform(0.1, 0.5))
    friction = float(random.uniform(0.1, 0.3))
    height = float(np.exp(random.uniform(math.log(0.025), math.log(0.3))))
    return RealPlate(restitution, friction, height, 0.5 * moving, 15.0 * moving)


def study_parts() -> list[Part]:
    """Boxes, prisms, irregular ones, a wedge and a box without a corner, of 7 to 50
    mm.
    """
    sizes = (
        (0.02, 0.03, 0.012),
        (0.01, 0.01, 0.0075),
        (0.016, 0.022, 0.02),
        (0.03, 0.05, 0.012),
        (0.014, 0.025, 0.018),
    )
    wedge = np.array(
        [
            (x, y, z)
            for x in (0.0, 0.03)
            for y, z in ((0.0, 0.0), (0.02, 0.0), (0.0, 0.015))
        ]
    )
    cut = np.vstack(
        (
            box(0.02, 0.024, 0.016)[0][:-1],
            [(0.01, 0.012, 0.0), (0.01, 0.0, 0.008), (-0.002, 0.012, 0.008)],
        )
    )
    return [
        part_from_mesh(*surface)
        for surface in (
            *(box(*size) for size in sizes),
            prism(6, 0.01, 0.024),
            prism(3, 0.012, 0.015),
            prism(5, 0.012, 0.014),
            hull_mesh(ellipsoid_points(8, 1, (0.012, 0.015, 0.009))),
            hull_mesh(ellipsoid_points(12, 2, (0.02, 0.014, 0.012))),
            hull_mesh(wedge),
            hull_mesh(cut),
        )
    ]


def read_counts() -> list[list[list[int]]]:
    """Counts by plate, part and pose, as `python -m study.plates.friction` writes
    them.
    """
    counts: list[list[list[int]]] = json.loads(FILE.read_text(encoding="utf-8"))
    return counts


def count_poses(
    part: Part, plate: RealPlate, drops: int, seed: tuple[int, ...]
) -> Index:
    """How many of some drops (P,) end in each pose, by `index`."""
    resting = resting_poses(part)
    random = np.random.default_rng(seed)
    turns = rotation_matrices(_unit(random.standard_normal((drops, 4))))
    spin = plate.spin * _unit(random.standard_normal((drops, 3)))
    radius = resting.body.radius
    faces = resting.equilibria
    pose = resting.clusters.pose
    barrier = np.array([stable_pose.barrier for stable_pose in resting.poses])[pose]
    rest_energy = radius * faces.heights + np.minimum(NEAR * barrier, radius)
    inverse = np.asarray(np.linalg.inv(resting.inertia * radius * radius), np.float64)
    body = Body(resting.body.points * radius, inverse, faces.downs, rest_energy, radius)
    ends = _drop_all(body, plate, turns, spin)
    if (ends < 0).any():
        raise RuntimeError(f"a drop was still going on after {MOST_STEPS} steps")
    return np.bincount(pose[ends], minlength=len(resting.poses)).astype(np.int64)


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


class Body(NamedTuple):
    """A part as it falls, a mass of 1."""

    corners: Array  # (V, 3) about its centre of mass, metres
    inverse: Array  # (3, 3) of its inertia
    downs: Array  # (F, 3) directions that point down on its stable faces
    rest_energy: Array  # (F,) below which it stays there, as a height in metres
    radius: float


@numba.njit(cache=True)
def _drop_all(body, plate, turns, spins):  # type: ignore[no-untyped-def]
    ends = np.empty(len(turns), np.int64)
    for drop in range(len(turns)):
        ends[drop] = _drop(body, plate, turns[drop].copy(), spins[drop])
    return ends


@numba.njit(cache=True)
def _drop(body, plate, turn, spin):  # type: ignore[no-untyped-def]
    """The face, by its number among the stable ones, that a drop ends on; -1 for
    none.
    """
    radius = body.radius
    inverse = body.inverse
    shortest = SHORTEST * math.sqrt(radius / GRAVITY)
    slowest = SLOWEST * math.sqrt(GRAVITY * radius)
    arms = body.corners @ turn.T
    z = max(plate.drop_height, -arms[:, 2].min())
    velocity = np.array((plate.speed, 0.0, 0.0))
    momentum = turn @ np.linalg.solve(inverse, turn.T @ spin)
    for _ in range(MOST_STEPS):
        arms = body.corners @ turn.T
        world = turn @ inverse @ turn.T
        lowest = z + arms[:, 2].min()
        rate = world @ momentum
        spinning = math.sqrt(rate @ rate)
        falling = math.sqrt(
            velocity[2] * velocity[2] + 2.0 * GRAVITY * max(lowest, 0.0)
        )
        fastest = falling + spinning * radius + slowest
        step = max(shortest, min(lowest / fastest, TURN / max(spinning, 1e-9)))
        velocity[2] -= GRAVITY * step
        if lowest > 0.0:
            z += (
                0.5 * GRAVITY * step * step
            )  # of a flight; a touching part is held at each step
        else:
            _touch(arms, z, velocity, momentum, world, plate, slowest)
            rate = world @ momentum
            energy = z + 0.5 * (velocity @ velocity + rate @ momentum) / GRAVITY
            face = np.argmax(body.downs @ -turn[2])
            if energy < body.rest_energy[face]:
                return face
        z += velocity[2] * step
        half = _turned(turn, rate, 0.5 * step)
        turn = _turned(turn, half @ inverse @ half.T @ momentum, step)
    return -1


@numba.njit(cache=True)
def _turned(turn, rate, seconds):  # type: ignore[no-untyped-def]
    """An orientation turned about a rate for some time, by Rodrigues' formula."""
    angle = math.sqrt(rate @ rate) * seconds
    if angle == 0.0:
        return turn.copy()
    x, y, z = rate * (seconds / angle)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation = (
        np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    )
    return rotation @ turn


@numba.njit(cache=True)
def _touch(  # type: ignore[no-untyped-def]
    arms, z, velocity, momentum, world, plate, slowest
):
    """Impacts of all corners that touch and approach, the fastest first, in place."""
    for _ in range(50):
        fastest = -0.03 * slowest
        corner = -1
        rate = world @ momentum
        for number in range(len(arms)):
            if z + arms[number, 2] <= 0.0:
                rise = (
                    velocity[2] + rate[0] * arms[number, 1] - rate[1] * arms[number, 0]
                )
                if rise < fastest:
                    fastest = rise
                    corner = number
        if corner < 0:
            return
        bounce = plate.restitution if fastest < -slowest else 0.0
        strike(arms[corner], velocity, momentum, world, bounce, plate.friction)


@numba.njit(cache=True)
def strike(  # type: ignore[no-untyped-def]
    arm, velocity, momentum, world, restitution, friction
):
    """One impact at an arm, for a mass of 1; velocity and momentum change in place."""
    x, y, z = arm
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    yielding = np.eye(3) - cross @ world @ cross
    tangent = np.linalg.solve(yielding[:2, :2], -yielding[:2, 2].copy())
    slip = velocity - cross @ (world @ momentum)
    slices = SLICES if restitution > 0.0 else FEW_SLICES
    small = -slip[2] / yielding[2, 2] / slices
    impulse = np.zeros(3)
    work = 0.0
    target = math.inf
    direction = np.zeros(3)
    for _ in range(1000 * SLICES):
        sliding = math.hypot(slip[0], slip[1])
        direction[2] = 1.0
        if sliding > 2.0 * small * friction * yielding[0, 0] + 1e-12:
            direction[:2] = -friction * slip[:2] / sliding
        else:
            hold = math.hypot(tangent[0], tangent[1])
            direction[:2] = tangent * min(1.0, friction / max(hold, 1e-12))
        change = yielding @ direction * small
        if target == math.inf and slip[2] + change[2] >= 0.0 and change[2] > 0.0:
            part = -slip[2] / change[2]  # up to the greatest compression exactly
            work += 0.5 * slip[2] * small * part
            impulse += direction * small * part
            slip += change * part
            target = -work * restitution * restitution
            work = 0.0
            if target == 0.0:
                break
            continue
        work += (slip[2] + 0.5 * change[2]) * small
        impulse += direction * small
        slip += change
        if work >= target:
            break
    velocity += impulse
    momentum += cross @ impulse


if __name__ == "__main__":  # for ten minutes
    FILE.write_text(
        json.dumps(
            [
                [
                    count_poses(part, plate_of(k), DROPS, (7, k, number)).tolist()
                    for number, part in enumerate(study_parts())
                ]
                for k in range(PLATES)
            ]
        )
        + "\n",
        encoding="utf-8",
    )
