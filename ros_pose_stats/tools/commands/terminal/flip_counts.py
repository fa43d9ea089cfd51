"""Flips that a cell has counted: the option `--counts`, and its file."""

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from ....base.errors import RequestError
from . import arguments, running

if TYPE_CHECKING:
    from ....core.records import FlipStatistics, Index, Part
    from ....core.simulation.request import DropRequest


def add_counts_option(command: argparse._ActionsContainer) -> None:
    """Add `--counts`."""
    command.add_argument(
        "--counts",
        metavar="FILE",
        help="CSV file of flips that were counted, "
        "with the columns speed (its name), from and to (index of a pose), count",
    )


def read_flips(file: str | None, pose_count: int) -> "dict[str, Index]":
    """Flips (K, K) from pose to pose by the feeder's speed; none without a file."""
    if file is None:
        return {}
    import numpy as np

    from ....core.plates.counts import read_table

    flips: dict[str, Index] = {}
    rows = read_table(Path(file), "speed, from, to, count", "slow,3,0,41")
    for speed, (start, end, count) in rows:
        if max(start, end) >= pose_count:
            raise RequestError(
                f"poses 0 to {pose_count - 1}",
                f"{max(start, end)} in {file}",
                "count with the numbers that estimate shows",
            )
        if speed not in flips:
            flips[speed] = np.zeros((pose_count, pose_count), np.int64)
        flips[speed][start, end] += count
    for speed, counts in flips.items():
        if not counts.any():
            raise RequestError(
                "flips at every speed",
                f"none at {speed} in {file}",
                "count some, or leave the speed out",
            )
    return flips


def kick_from_heights(
    part: "Part",
    kicks: "Iterable[float]",
    flip_request: "DropRequest",
    should_stop: "Callable[[], bool]",
    bar: running.ProgressBar,
    options: argparse.Namespace,
) -> "list[FlipStatistics]":
    """Flips at each kick height, under a bar."""
    from ....core.simulation import flips, request

    return flips.flips_by_kick(
        part,
        arguments.drop_scene(options),
        kicks,
        flip_request,
        request.Watch(should_stop=should_stop),
        lambda index, total: bar.draw(index / total, f"kick {index + 1} of {total}"),
    )


def learn_speeds(
    simulated_flips: "list[FlipStatistics]", counted_flips: "dict[str, Index]"
) -> "list[FlipStatistics]":
    """Flips at each of a feeder's speeds, from those of the model and those counted."""
    from ....core.statistics.feeding import learn_flips

    return [
        learn_flips(simulated_flips, counts, speed)
        for speed, counts in counted_flips.items()
    ]
