"""The fill of a plate and the plan of a cell, simulated: `python -m lab.benchmarks.feeding`.

Six parts on three plates: how many of the parts on the plate can be picked, and how many are
picked a minute, as told and with true outlines thrown on the plate.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from manifold3d import CrossSection, JoinType
from numpy.random import Generator
from numpy.typing import NDArray

from lab.frame.results import Row, Section, Target
from ros_pose_stats import (
    FeederCell,
    FlipStatistics,
    Part,
    PoseStatistics,
    estimate,
    outline_at,
    part_from_mesh,
    plan_feeding,
    simulate_flips,
)
from ros_pose_stats.core.planning.feeding_plan import KickPlan
from ros_pose_stats.core.planning.plate_fill import blocking_with_bays, plate_fill
from ros_pose_stats.core.shapes import demo_parts

from .program import benchmark_parser, run_benchmark

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

PARTS = ("clamp", "bracket", "hex_bolt", "gear", "prism", "cylinder")
PLATES = ((8.0, 6.0, 0.0), (12.0, 9.0, 0.3), (20.0, 8.0, 0.1))
"""Sides, and the clearance of the gripper, in part radii."""

KICK = 0.5
FLIPS = 2000
SEED = 17
LIMIT = 5.0
"""Kick in radii, flips a pose, and percent that told numbers may be off."""

MEASURED = (
    "A part on a plate with sides and clearance in part radii, its two likeliest poses wanted. "
    "`best`: the number of parts that leaves most of them free to pick; `free`: how many those "
    "are, as told; `thrown`: the mean over plates full of true outlines, bays and holes included, "
    "thrown anywhere and turned anyhow, by the poses' shares; `off, %`: told over thrown, less "
    "one; `error, %`: its standard error; `convex, %`: off by as much if silhouettes counted as "
    "convex. `parts`, "
    "`kicks`, `a minute`: the plan for a kick of half a radius; `simulated`: whole cycles of it, "
    "part by part, thrown anew at each kick."
)


class Plate:
    """Parts of one kind with their outlines.

    A part is blocked where another one reaches into its outline grown by the clearance.
    """

    def __init__(
        self,
        outlines: Sequence[Sequence[Array]],
        size: tuple[float, float],
        clearance: float,
    ) -> None:
        self.size = np.array(size)
        self.outlines = [CrossSection(rings) for rings in outlines]
        self.grown = [
            outline.offset(clearance, JoinType.Round, circular_segments=48)
            for outline in self.outlines
        ]
        self.reach = np.array(
            [
                max(np.hypot(*ring.T).max() for ring in outline.to_polygons())
                for outline in self.outlines
            ]
        )
        self.clearance = clearance

    def free(self, pose: NDArray[np.int64], wanted: Flags, random: Generator) -> Flags:
        """Throw parts (N,) that come to rest in these poses; which of those wanted are free."""
        place = random.uniform(size=(len(pose), 2)) * self.size
        turn = random.uniform(0.0, 360.0, len(pose))
        far = self.reach[pose]
        near = (
            np.hypot(*(place[:, None] - place).T) < far[:, None] + far + self.clearance
        )
        np.fill_diagonal(near, False)
        free = wanted[pose]
        for mine in np.flatnonzero(free):
            here = self.grown[pose[mine]].rotate(turn[mine])
            free[mine] = all(
                (
                    here
                    ^ self.outlines[pose[other]]
                    .rotate(turn[other])
                    .translate(place[other] - place[mine])
                ).is_empty()
                for other in np.flatnonzero(near[mine])
            )
        return free


def row(
    name: str,
    part: Part,
    dropped: PoseStatistics,
    flips: FlipStatistics,
    plate: tuple[float, float, float],
    seconds: float,
    random: Generator,
) -> Row:
    """One part on one plate; `seconds`: spent on each of two simulations."""
    poses = sorted(dropped.poses, key=lambda pose: pose.index)
    shares = np.array([pose.probability for pose in poses])
    wanted = np.zeros(len(poses), dtype=np.bool_)
    wanted[[pose.index for pose in dropped.poses[:2]]] = True
    long, wide, clearance = (radii * dropped.radius for radii in plate)
    numbers = np.arange(1, 200)
    told, convex = (
        numbers
        * (
            plate_fill(
                [pose.outline for pose in poses],
                shares,
                (long, wide),
                clearance,
                blocking,
            ).free(numbers)
            @ (shares * wanted)
        )
        for blocking in (
            blocking_with_bays(part, poses, shares, np.flatnonzero(wanted), clearance),
            1.0,
        )
    )
    best = int(told.argmax())
    thrown = Plate(
        [
            [ring for polygon in outline_at(part, pose) for ring in polygon]
            for pose in poses
        ],
        (long, wide),
        clearance,
    )
    seen = []
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        pose = random.choice(len(poses), numbers[best], p=shares / shares.sum())
        seen.append(int(thrown.free(pose, wanted, random).sum()))
    mean = float(np.mean(seen))
    error = float(np.std(seen)) / len(seen) ** 0.5
    cell = FeederCell(60.0, (long, wide), clearance)
    plan = plan_feeding(
        dropped, np.flatnonzero(wanted).tolist(), cell, [flips], part
    ).options[1]
    rate = simulated_rate(
        plan,
        cell,
        thrown,
        shares / shares.sum(),
        wanted,
        flips.transition,
        seconds,
        random,
    )
    off = 100.0 * (told[best] / mean - 1.0)
    rate_off = 100.0 * (plan.per_minute.value / rate - 1.0)
    return Row(
        f"{name}, {plate[0]:g} x {plate[1]:g}, {plate[2]:g}",
        {
            "best": int(numbers[best]),
            "free": float(told[best]),
            "thrown": mean,
            "off, %": off,
            "error, %": 100.0 * error / mean,
            "convex, %": 100.0 * (convex[best] / mean - 1.0),
            "parts": plan.parts,
            "kicks": plan.kicks,
            "a minute": plan.per_minute.value,
            "simulated": rate,
            "rate off, %": rate_off,
        },
        (
            Target("free parts off, %", abs(off), LIMIT),
            Target("rate off, %", abs(rate_off), LIMIT),
        ),
    )


def simulated_rate(
    plan: KickPlan,
    cell: FeederCell,
    plate: Plate,
    shares: Array,
    wanted: Flags,
    moves: Array,
    seconds: float,
    random: Generator,
) -> float:
    """Parts picked a minute over whole cycles, at least one."""
    ends = moves.cumsum(axis=1)
    picked = 0
    took = 0.0
    until = time.monotonic() + seconds
    while not picked or time.monotonic() < until:
        pose = random.choice(len(shares), plan.parts, p=shares)
        fresh = plan.parts
        for kick in range(plan.kicks + 1):
            free = plate.free(pose, wanted, random)
            taken = int(free.sum())
            picked += taken
            took += (
                cell.drop_time
                + cell.camera_time
                + cell.pick_time * taken
                + 60.0 / cell.rate * fresh
                + cell.cycle_time * (kick > 0)
            )
            pose = (random.random((plan.parts, 1)) > ends[pose]).sum(axis=1)
            pose = pose.clip(0, len(shares) - 1)
            pose[free] = random.choice(len(shares), taken, p=shares)
            fresh = taken
    return 60.0 * picked / took


def measure(seconds: float) -> Section:
    """All parts on all plates."""
    rows = []
    random = np.random.default_rng(SEED)
    for name in PARTS:
        vertices, triangles = getattr(demo_parts, name)()
        part = part_from_mesh(vertices * 1e-3, triangles, part_id=name)
        dropped = estimate(part, "split")
        flips = simulate_flips(part, KICK * dropped.radius, FLIPS, seed=SEED)
        rows += [
            row(name, part, dropped, flips, plate, seconds, random) for plate in PLATES
        ]
    return Section("feeding", "Parts on a plate", MEASURED, tuple(rows))


def main() -> None:
    """Read the arguments and measure."""
    parser = benchmark_parser("lab.benchmarks.feeding", __doc__)
    parser.add_argument(
        "--seconds",
        type=float,
        default=4.0,
        help="of each of two simulations of each case (default: %(default)s)",
    )
    run_benchmark(parser, lambda options: [measure(options.seconds)])


if __name__ == "__main__":
    main()
