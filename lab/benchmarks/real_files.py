"""Drops and estimates of files of one's own: `python -m lab.benchmarks.real_files
FOLDER ...`.

The page names no files, only how many there are and what tells the slow ones apart.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median

import numpy as np

from lab.frame.results import Row, Section, Target
from lab.frame.timing import timed
from ros_pose_stats import (
    Part,
    estimate,
    load_part,
    part_from_mesh,
    resting_poses,
    simulate,
)
from ros_pose_stats.base.errors import PoseStatsError
from ros_pose_stats.core.mesh.files import SUFFIXES
from ros_pose_stats.core.simulation.drops import DropChunk

from .program import benchmark_parser, run_benchmark

FIRST = 100
SECONDS = 1.0
CALLS = 5
MEDIAN = 15_000.0
TENTH = 4_000.0
LEAST = 1_000.0
MILLISECONDS = 10.0
"""Aims: drops a second, and milliseconds that nine of ten estimates are to stay
below.
"""

MEASURED = (
    "`drops/s`: drops in a second of processor time of one core, at restitution 0.5 "
    "and default settings, the poses known, over about a second. `estimate, ms`: "
    "processor time of `estimate(part, 'split')` on a part made from the loaded "
    "arrays, nothing remembered, so that convex body, round surfaces, poses and "
    "symmetries are in it; median of five. Kernels were compiled before. `events`: "
    "impacts and steps of a drop, on the average. `corners`, `poses`: of the convex "
    "body that is dropped."
)


def files_in(folders: Sequence[Path]) -> list[Path]:
    """Every mesh and STEP file under some folders, and files given by name."""
    files = {
        file
        for folder in folders
        for file in (folder.rglob("*") if folder.is_dir() else [folder])
        if file.suffix.lower() in SUFFIXES
    }
    return sorted(files)


def loaded(files: Sequence[Path]) -> Iterator[tuple[str, Part]]:
    """Parts that can be loaded; others are told of on standard error."""
    for file in files:
        try:
            yield file.name, load_part(file, "auto")
        except PoseStatsError as error:
            print(f"left out: {error}", file=sys.stderr)


def measure(part: Part) -> dict[str, float | int]:
    """The cells of a part."""
    took = median(_estimate_seconds(part) for _ in range(CALLS))
    events: list[int] = []

    def count(chunk: DropChunk) -> None:
        events.append(int(chunk.outcomes.events.sum()))

    def drop(drops: int) -> float:
        events.clear()
        return timed(lambda: simulate(part, drops, seed=1, workers=1, on_drops=count))[
            1
        ]

    estimate(part, "split")
    drop(FIRST)
    drops = max(FIRST, min(100_000, round(SECONDS * FIRST / drop(FIRST))))
    seconds = drop(drops)
    resting = resting_poses(part)
    return {
        "triangles": len(part.triangles),
        "corners": len(np.unique(resting.body.arrays.corner)),
        "poses": len(resting.poses),
        "events": sum(events) / drops,
        "drops/s": drops / seconds,
        "estimate, ms": 1e3 * took,
    }


def _estimate_seconds(part: Part) -> float:
    new_part = part_from_mesh(part.vertices, part.triangles)
    return timed(lambda: estimate(new_part, "split"))[1]


def summary(rows: Sequence[Row]) -> Section:
    """Median, tenth percentile and least of all files, with the targets."""
    rates = [float(row.cells["drops/s"]) for row in rows]
    times = [float(row.cells["estimate, ms"]) for row in rows]
    names = ("median", "worst tenth", "worst")
    rate = dict(zip(names, np.percentile(rates, (50, 10, 0)).tolist(), strict=True))
    took = dict(zip(names, np.percentile(times, (50, 90, 100)).tolist(), strict=True))
    aims = zip(names, (MEDIAN, TENTH, LEAST), strict=True)
    return Section(
        "real_files",
        "Files of real parts",
        MEASURED,
        (
            Row(
                "drops/s",
                {"files": len(rows), **rate},
                tuple(
                    Target(name, rate[name], aim, at_least=True) for name, aim in aims
                ),
            ),
            Row(
                "estimate, ms",
                {"files": len(rows), **took},
                (Target("worst tenth", took["worst tenth"], MILLISECONDS),),
            ),
        ),
    )


def sections(folders: Sequence[Path]) -> Iterator[Section]:
    """Measure every file, and print its name; the tables have none.

    Raises
    ------
    SystemExit
        If there is no file that can be loaded.
    """
    rows = []
    for name, part in loaded(files_in(folders)):
        if not rows:
            measure(part)  # compiles or loads every kernel
        cells = measure(part)
        rows.append(Row(name, cells))
        print(name, {key: round(cell, 1) for key, cell in cells.items()}, flush=True)
    if not rows:
        sys.exit("there is no mesh or STEP file that can be loaded")
    rows.sort(key=lambda row: float(row.cells["drops/s"]))
    yield summary(rows)
    yield Section(
        "real_files_each",
        "Files, the slowest first",
        MEASURED,
        tuple(Row(str(rank), row.cells) for rank, row in enumerate(rows, start=1)),
    )


def main() -> None:
    """Read the arguments and measure."""
    parser = benchmark_parser("lab.benchmarks.real_files", __doc__)
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    run_benchmark(parser, lambda options: sections(options.folders))


if __name__ == "__main__":
    main()
