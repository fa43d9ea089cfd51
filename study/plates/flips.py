"""Flips counted on feeders with friction, learnt from: `python -m study.plates.flips`."""

from __future__ import annotations

import math
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from numpy.random import default_rng

from ros_pose_stats import estimate, learn_flips, simulate_flips
from ros_pose_stats.core.mesh.vectors import rotation_matrices
from ros_pose_stats.core.records.scene import GRAVITY
from ros_pose_stats.core.resting.poses import RestingPoses, resting_poses
from ros_pose_stats.core.simulation.flips import usual_kicks

from ..output import markdown_table, points, write_page
from .friction import Array, RealPlate, plate_of, poses_reached, strike, study_parts

FEEDERS = (1, 6)
KICKS = (0.2, 0.5, 1.5)  # plates of the study; mean energies, in part radii
TRUE = 300
MODEL = 500
COUNTED = (30, 100, 300)
DRAWS = 10
PARTS = range(0, 12, 2)

PAGE = """# Counted flips

Written by `python -m study.plates.flips`; edits here are lost. How flips are learnt:
[counted flips](../simulation.md#counted-flips). A feeder is simulated with friction: its plate
comes up at one speed and hits parts at points of their contact polygons, and they fall back on it.
Kicks: mean energy over the weight, in part radii. Six kinds of parts, two feeders ({}).
Of {} flips out of each pose so many are drawn, out of all poses alike, {} times. Errors in points:
root mean square from group to group of poses, against all flips; model: flips at the same energy
and the default restitution. Told / true: flips that a part in another group needs until it lies in
the most probable one, over those by all flips; geometric means.

"""


@cache
def kick_parts(
    resting: RestingPoses, plate: RealPlate, kick: float, seed: int
) -> Array:
    """Counts (K, K) from pose to pose of parts that a plate kicks at one speed."""
    random = default_rng(seed)
    radius = resting.body.radius
    poses = resting.poses
    pose = np.repeat(np.arange(len(poses)), TRUE)
    turns = rotation_matrices(np.array([each.orientation for each in poses]))[pose]
    yielding = (
        turns
        @ np.linalg.inv(resting.inertia * radius * radius)
        @ turns.transpose(0, 2, 1)
    )
    height = np.array([each.height for each in poses])[pose]
    velocity = np.tile((0.0, 0.0, -1.0), (len(pose), 1))
    momentum = np.zeros((len(pose), 3))
    for number, index in enumerate(
        pose.tolist()
    ):  # as a plate sees parts that comes up at 1 m/s
        corners = poses[index].support_polygon
        first = corners[1:-1] - corners[0]
        second = corners[2:] - corners[0]
        area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
        triangle = random.choice(len(area), p=area / area.sum())
        out = math.sqrt(random.random())
        along = random.random()
        at = corners[0] + out * (
            (1.0 - along) * first[triangle] + along * second[triangle]
        )
        strike(
            np.array([*at, -height[number]]),
            velocity[number],
            momentum[number],
            yielding[number],
            plate.restitution,
            plate.friction,
        )
    velocity[:, 2] += 1.0
    spin = np.einsum("nij,nj->ni", yielding, momentum)
    energy = 0.5 * ((velocity**2).sum(axis=1) + (spin * momentum).sum(axis=1)).mean()
    speed = math.sqrt(
        GRAVITY * kick * radius / energy
    )  # an impact is in proportion to it
    ends = poses_reached(resting, plate, turns, height, speed * velocity, speed * spin)
    found = np.zeros((len(poses), len(poses)))
    np.add.at(found, (pose, ends), 1.0)
    return found


def measure(number: int) -> dict[tuple[float, int], Array]:
    """Square errors of a part by model, counts and both, and logarithms of told over true."""
    part = study_parts()[number]
    random = default_rng(number)
    found = {}
    resting = resting_poses(part)
    radius = resting_poses(part).body.radius
    kicks = [
        simulate_flips(part, height, MODEL, seed=number)
        for height in usual_kicks(radius)
    ]
    member = np.equal.outer(resting.group, np.unique(resting.group)).astype(float)
    wanted = resting.group[estimate(part, "split").poses[0].index]

    def judge(flips: Array) -> tuple[Array, float]:
        """Shares (G, G) from group to group, and flips that a part needs."""
        together = member.T @ (flips + 0.5 / len(flips) ** 2) @ member
        moves = together / together.sum(axis=1, keepdims=True)
        stay = np.delete(np.delete(moves, wanted, axis=0), wanted, axis=1)
        return moves, np.linalg.solve(
            np.eye(len(stay)) - stay, np.ones(len(stay))
        ).mean()

    for kick, counted in product(KICKS, COUNTED):
        model = simulate_flips(part, kick * radius, MODEL, seed=number).counts
        rows = []
        for truth in DRAWS * [
            kick_parts(resting, plate_of(feeder), kick, number) for feeder in FEEDERS
        ]:
            out = random.multinomial(counted, np.full(len(truth), 1.0 / len(truth)))
            counts = random.multinomial(out, truth / TRUE)
            right, needed = judge(truth)
            told = [
                judge(np.asarray(each, float))
                for each in (model, counts, learn_flips(kicks, counts).counts)
            ]
            rows.append(
                [
                    *(np.square(moves - right).mean() for moves, _ in told),
                    *(math.log(flips / needed) for _, flips in told),
                ]
            )
        found[kick, counted] = np.mean(rows, axis=0)
    return found


def main() -> None:
    """Measure and write the page."""
    rows = []
    every = [measure(number) for number in PARTS]
    for kick, counted in product(KICKS, COUNTED):
        mean = np.mean([each[kick, counted] for each in every], axis=0)
        rows.append(
            [
                f"{kick:g}",
                f"{counted}",
                *map(points, np.sqrt(mean[:3]).tolist()),
                *(f"{each:.2f}" for each in np.exp(mean[3:]).tolist()),
            ]
        )
    heads = [
        "kick",
        "flips counted",
        *(
            f"{of}{way}"
            for of in ("", "told / true, ")
            for way in ("model", "counts", "learnt")
        ),
    ]
    feeders = " and ".join(
        f"restitution {one.restitution:.2f}, friction {one.friction:.2f}"
        for one in map(plate_of, FEEDERS)
    )
    text = PAGE.format(feeders, TRUE, DRAWS) + markdown_table(heads, rows)
    print(text)
    write_page(Path("docs"), "flips.md", f"{text}\n", {}, {"flips": [heads, *rows]})


if __name__ == "__main__":  # for ten minutes
    main()
