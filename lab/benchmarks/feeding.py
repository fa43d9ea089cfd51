"""The fill of a plate, simulated: `python -m lab.benchmarks.feeding [--write]`.

Six parts on three plates: how many of the parts on the plate can be picked, as told and
with true outlines thrown on the plate.
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
    "A part on a plate with sides and clearance in part radii, its two likeliest poses "
    "wanted. `best`: the number of parts that leaves most of them free to pick; "
    "`free`: how many those are, as told; `thrown`: the mean over plates full of true "
    "outlines, bays and holes included, thrown anywhere and turned anyhow, by the "
    "poses' shares; `off, %`: told over thrown, less one; `error, %`: its standard "
    "error."
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

    def free(
        self, pose: NDArray[np.int64], is_wanted: Flags, random: Generator
    ) -> Flags:
        """Throw parts (N,) that come to rest in these poses; which of those wanted are
        free.
        """
        positions = random.uniform(size=(len(pose), 2)) * self.size
        turn = random.uniform(0.0, 360.0, len(pose))
        reach = self.reach[pose]
        may_touch = (
            np.hypot(*(positions[:, None] - positions).T)
            < reach[:, None] + reach + self.clearance
        )
        np.fill_diagonal(may_touch, False)
        free = is_wanted[pose]
        for part in np.flatnonzero(free):
            grown = self.grown[pose[part]].rotate(turn[part])
            free[part] = all(
                (
                    grown
                    ^ self.outlines[pose[neighbour]]
                    .rotate(turn[neighbour])
                    .translate(positions[neighbour] - positions[part])
                ).is_empty()
                for neighbour in np.flatnonzero(may_touch[part])
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
    is_wanted = np.zeros(len(poses), dtype=np.bool_)
    is_wanted[[pose.index for pose in dropped.poses[:2]]] = True
    long, wide, clearance = (radii * dropped.radius for radii in plate)
    numbers = np.arange(1, 200)
    fill = plate_fill(
        [pose.outline for pose in poses],
        shares,
        (long, wide),
        clearance,
        blocking_with_bays(part, poses, shares, np.flatnonzero(is_wanted), clearance),
    )
    free_parts = numbers * (fill.free_probability(numbers) @ (shares * is_wanted))
    best = int(free_parts.argmax())
    thrown = Plate(
        [
            [ring for polygon in outline_at(part, pose) for ring in polygon]
            for pose in poses
        ],
        (long, wide),
        clearance,
    )
    thrown_free = []
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        pose = random.choice(len(poses), numbers[best], p=shares / shares.sum())
        thrown_free.append(int(thrown.free(pose, is_wanted, random).sum()))
    mean = float(np.mean(thrown_free))
    error = float(np.std(thrown_free)) / len(thrown_free) ** 0.5
    percent_off = 100.0 * (free_parts[best] / mean - 1.0)
    return Row(
        f"{name}, {plate[0]:g} x {plate[1]:g}, {plate[2]:g}",
        {
            "best": int(numbers[best]),
            "free": float(free_parts[best]),
            "thrown": mean,
            "off, %": percent_off,
            "error, %": 100.0 * error / mean,
        },
        (Target("free parts off, %", abs(percent_off), LIMIT),),
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
