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

"""Flips of the model, and those that a cell has counted: options, and their file."""

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from ....base.errors import RequestError
from ....core.records.scene import DEFAULT_SEED
from . import arguments, running

if TYPE_CHECKING:
    from ....core.records import FlipStatistics, Index, Part, PoseStatistics
    from ....core.simulation.request import DropRequest


def add_flips(command: arguments.CommandParser) -> None:
    """Add the number of flips and the seed; equal ones make equal plans."""
    arguments.add_options(command, "--flips")
    arguments.add_options(
        command,
        "--seed",
        default=DEFAULT_SEED,
        help="the same seed gives the same drops and flips (default: %(default)s, as "
        "in a node)",
    )


def flip_request(options: argparse.Namespace, poses: int) -> "DropRequest":
    """How often to kick a part out of each of its poses."""
    from ....core.simulation.flips import flips_per_pose
    from ....core.simulation.request import drop_request

    return drop_request(
        flips_per_pose(poses, options.flips), options.seed, 0.0, options.workers
    )


def add_counts_option(command: argparse._ActionsContainer, also: str = "") -> None:
    """Add `--counts`; `also`: what else the file may hold."""
    command.add_argument(
        "--counts",
        metavar="FILE",
        help="CSV file of flips that were counted, "
        "with the columns setting (its name), from and to (index of a pose), count"
        f"{also}",
    )


def is_of_landings(file: str | None) -> bool:
    """Whether the table of `--counts` has parts as they lie after a drop."""
    if file is None:
        return False
    from ....core.plates.counts import is_count_table

    return is_count_table(Path(file))


def learn_landings(
    statistics: "PoseStatistics", part: "Part", options: argparse.Namespace
) -> "PoseStatistics":
    """What is observed by the table of `--counts`.

    Raises RequestError if it has no row of the part.
    """
    from ....core.planning.confidence import observe_counts
    from ....core.plates.counts import count_part, read_count_rows, shared_out

    table = Path(options.counts)
    file = Path(options.part).resolve()
    counts_by_file = {
        path.resolve(): counts for path, counts in read_count_rows(table).items()
    }
    if file not in counts_by_file:
        raise RequestError(
            f"counts of {options.part}",
            f"none in {table}",
            "name the part there as it is named here, or beside the table",
        )
    counted = count_part(
        part,
        counts_by_file[file],
        cluster_tolerance=options.cluster_tolerance,
        round_sides=options.round_sides,
    )
    return observe_counts(statistics, shared_out(counted))


def read_flips(file: str | None, pose_count: int) -> "dict[str, Index]":
    """Flips (K, K) from pose to pose by the feeder's setting; none without a file."""
    if file is None:
        return {}
    import numpy as np

    from ....core.plates.counts import read_table

    flips: dict[str, Index] = {}
    rows = read_table(Path(file), "setting, from, to, count", "slow,3,0,41")
    for setting, (start, end, count) in rows:
        if max(start, end) >= pose_count:
            raise RequestError(
                f"poses 0 to {pose_count - 1}",
                f"{max(start, end)} in {file}",
                "count with the numbers that estimate shows",
            )
        if setting not in flips:
            flips[setting] = np.zeros((pose_count, pose_count), np.int64)
        flips[setting][start, end] += count
    for setting, counts in flips.items():
        if not counts.any():
            raise RequestError(
                "flips at every setting",
                f"none at {setting} in {file}",
                "count some, or leave the setting out",
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


def learn_settings(
    simulated_flips: "list[FlipStatistics]", counted_flips: "dict[str, Index]"
) -> "list[FlipStatistics]":
    """Flips at each of a feeder's settings, of the model and counted together."""
    from ....core.statistics.feeding import learn_flips

    return [
        learn_flips(simulated_flips, counts, setting)
        for setting, counts in counted_flips.items()
    ]
