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

"""Drops a second of parts as designers send them, and of files in folders.

.venv/bin/python -m lab.benchmarks.part_rates [FOLDER ...] [--quick] [--write]

Prints each part as it is dropped. The page names no files, only how many there are.
"""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lab.bodies.catalogue_parts import random_part
from lab.frame.results import Row, Section, Target
from lab.frame.timing import timed
from ros_pose_stats import Part, part_from_mesh
from ros_pose_stats.core.records import DropScene
from ros_pose_stats.core.simulation.drop_body import drop_body
from ros_pose_stats.core.simulation.drops import (
    compute_drops,
    drop_rules,
    release_directions,
)

from .drops.dropper import paper_seconds
from .files import files_in, loaded
from .program import benchmark_parser, run_benchmark

SEED = 31
SERIES = 4321
"""Of the drops, and of the bodies."""

PARTS = 60
DROPS = 1_000
QUICK_PARTS = 6
QUICK_DROPS = 100

LEAST_TENTH = 8_000.0
LEAST_OF_ALL = 1_500.0
"""Drops a second that all but a tenth of the parts are to reach, and every part."""

ABOUT = (
    "Default scene, {} drops of each part, on one thread and warm. `drops/s` are by "
    "processor time: of the slowest part, of the one that a tenth of the parts are "
    "slower than, of the middle one. `times`: the time of their drops over that of one "
    "of the paper's random polyhedra at the same restitution, {:.0f} µs. `events`: "
    "impacts and steps a drop, of the middle part and of the one with most. "
    "`designed`: six kinds of turned, milled and toothed parts with random proportions "
    "(`lab/bodies/catalogue_parts.py`)."
)


class PartCost(NamedTuple):
    """What a drop of a part costs."""

    seconds: float  # processor time
    events: float  # impacts and steps


def part_cost(part: Part, drops: int) -> PartCost | None:
    """Mean cost of a drop in the default scene; none of a part of a single pose."""
    scene = DropScene()
    body = drop_body(part, scene)
    if len(body.resting.poses) < 2:
        return None
    rules = drop_rules(scene, body.radius, draws=True)
    downs = release_directions(body, SEED, 0, drops)
    outcomes, seconds = timed(partial(compute_drops, body, rules, downs))
    return PartCost(seconds / drops, float(outcomes.events.mean()))


def part_costs(parts: Iterable[tuple[str, Part]], drops: int) -> list[PartCost]:
    """Costs of all parts that can lie in two ways; each is printed with its name."""
    costs = []
    for name, part in parts:
        cost = part_cost(part, drops)
        if cost is not None:
            print(
                f"{name}: {1.0 / cost.seconds:.0f} drops/s, {cost.events:.0f} events",
                flush=True,
            )
            costs.append(cost)
    return costs


def rate_row(name: str, costs: Sequence[PartCost], paper_cost: float) -> Row:
    """The slowest part, the slowest tenth and the middle of some parts."""
    seconds = np.array([cost.seconds for cost in costs])
    events = np.array([cost.events for cost in costs])
    most, tenth, middle = np.quantile(seconds, (1.0, 0.9, 0.5)).tolist()
    least_rate = 1.0 / most
    tenth_rate = 1.0 / tenth
    return Row(
        name,
        {
            "parts": len(costs),
            "drops/s, least": least_rate,
            "tenth": tenth_rate,
            "median": 1.0 / middle,
            "times, most": most / paper_cost,
            "times, tenth": tenth / paper_cost,
            "times, median": middle / paper_cost,
            "events, median": float(np.median(events)),
            "events, most": float(events.max()),
        },
        (
            Target("least drops/s", least_rate, LEAST_OF_ALL, at_least=True),
            Target("tenth drops/s", tenth_rate, LEAST_TENTH, at_least=True),
        ),
    )


def designed_parts(number: int) -> Iterator[tuple[str, Part]]:
    """The first parts of a series, by their place in it."""
    for place in range(number):
        surface = random_part(SERIES, place)
        yield f"designed {place}", part_from_mesh(*surface, unit="mm")


def sections(is_quick: bool, folders: Sequence[Path]) -> Iterator[Section]:
    """Measure, and yield the table."""
    drops = QUICK_DROPS if is_quick else DROPS
    paper_cost = paper_seconds(DropScene().restitution, SEED)
    designed = designed_parts(QUICK_PARTS if is_quick else PARTS)
    kinds = {
        "designed": part_costs(designed, drops),
        "real files": part_costs(loaded(files_in(folders)), drops),
    }
    yield Section(
        "part_rates",
        "Drops a second of parts",
        ABOUT.format(drops, 1e6 * paper_cost),
        tuple(
            rate_row(name, costs, paper_cost) for name, costs in kinds.items() if costs
        ),
    )


def main() -> None:
    """Read the arguments and measure."""
    parser = benchmark_parser(
        "lab.benchmarks.part_rates", __doc__ or "", "few parts and drops"
    )
    parser.add_argument("folders", nargs="*", type=Path, metavar="FOLDER")
    run_benchmark(parser, lambda options: sections(options.quick, options.folders))


if __name__ == "__main__":
    main()
