"""The fill of a plate, simulated: `python -m lab.benchmarks.feeding [--write]`.

Six parts on three plates: how many of the parts on the plate can be picked, as told and with
true outlines thrown on the plate.
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
    Part,
    PoseStatistics,
    estimate,
    outline_at,
    part_from_mesh,
)
from ros_pose_stats.core.planning.plate_fill import blocking_with_bays, plate_fill
from ros_pose_stats.core.shapes import demo_parts

from .program import benchmark_parser, run_benchmark

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

PARTS = ("clamp", "bracket", "hex_bolt", "gear", "prism", "cylinder")
PLATES = ((8.0, 6.0, 0.0), (12.0, 9.0, 0.3), (20.0, 8.0, 0.1))
"""Sides, and the clearance of the gripper, in part radii."""

SEED = 17
LIMIT = 5.0
"""Percent that told numbers may be off."""

MEASURED = (
    "A part on a plate with sides and clearance in part radii, its two likeliest poses wanted. "
    "`best`: the number of parts that leaves most of them free to pick; `free`: how many those "
    "are, as told; `thrown`: the mean over plates full of true outlines, bays and holes included, "
    "thrown anywhere and turned anyhow, by the poses' shares; `off, %`: told over thrown, less "
    "one; `error, %`: its standard error."
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
    plate: tuple[float, float, float],
    seconds: float,
    random: Generator,
) -> Row:
    """One part on one plate; `seconds`: spent on the simulation."""
    poses = sorted(dropped.poses, key=lambda pose: pose.index)
    shares = np.array([pose.probability for pose in poses])
    wanted = np.zeros(len(poses), dtype=np.bool_)
    wanted[[pose.index for pose in dropped.poses[:2]]] = True
    long, wide, clearance = (radii * dropped.radius for radii in plate)
    numbers = np.arange(1, 200)
    fill = plate_fill(
        [pose.outline for pose in poses],
        shares,
        (long, wide),
        clearance,
        blocking_with_bays(part, poses, shares, np.flatnonzero(wanted), clearance),
    )
    told = numbers * (fill.free_probability(numbers) @ (shares * wanted))
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
    off = 100.0 * (told[best] / mean - 1.0)
    return Row(
        f"{name}, {plate[0]:g} x {plate[1]:g}, {plate[2]:g}",
        {
            "best": int(numbers[best]),
            "free": float(told[best]),
            "thrown": mean,
            "off, %": off,
            "error, %": 100.0 * error / mean,
        },
        (Target("free parts off, %", abs(off), LIMIT),),
    )


def measure(seconds: float) -> Section:
    """All parts on all plates."""
    rows = []
    random = np.random.default_rng(SEED)
    for name in PARTS:
        vertices, triangles = getattr(demo_parts, name)()
        part = part_from_mesh(vertices * 1e-3, triangles, part_id=name)
        dropped = estimate(part, "split")
        rows += [row(name, part, dropped, plate, seconds, random) for plate in PLATES]
    return Section("feeding", "Parts on a plate", MEASURED, tuple(rows))


def main() -> None:
    """Read the arguments and measure."""
    parser = benchmark_parser("lab.benchmarks.feeding", __doc__)
    parser.add_argument(
        "--seconds",
        type=float,
        default=4.0,
        help="of the simulation of each case (default: %(default)s)",
    )
    run_benchmark(parser, lambda options: [measure(options.seconds)])


if __name__ == "__main__":
    main()
