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

"""Drops a second: on one core, with several workers, and against the number of
vertices.
"""

import time
from collections.abc import Callable, Sequence
from itertools import count
from statistics import fmean

from lab.bodies.curved import Body
from lab.frame.results import Row, Section, Target
from lab.frame.timing import Contender, Pace, race

from .dropper import RESTITUTIONS, Dropper

LEAST = {0.2: 12_000.0, 0.5: 8_500.0, 0.8: 4_000.0}
AIM = {0.5: 20_000.0}


def rates(droppers: Sequence[Dropper], drops: int, pace: Pace) -> Section:
    """A row for each restitution; every body is dropped as often."""
    corners = [dropper.vertices for dropper in droppers]
    timed = (
        f"{len(droppers)} random polyhedra as in the paper: hulls of 4 normally "
        "distributed points and as many more as a coin of 0.1 fails before its first "
        "success, homogeneous, at least two stable faces; "
        f"{min(corners)} to {max(corners)} vertices, {fmean(corners):.1f} on average. "
        "Cluster tolerance 0, release 20 radii up. Timed is what one worker does, on "
        f"one thread and warm: making random starting directions and dropping, {drops} "
        "drops of each body a round, others each round. `drops/s` is the median over "
        "the rounds, `best` the fastest one. `steps` are those of the motion between "
        "impacts."
    )
    return Section(
        "drop_rates",
        "Drops a second on one core",
        timed,
        tuple(_rows(droppers, drops, pace)),
    )


def _rows(droppers: Sequence[Dropper], drops: int, pace: Pace) -> list[Row]:
    timings = race(
        [
            Contender(str(restitution), _caller(droppers, restitution, drops))
            for restitution in RESTITUTIONS
        ],
        pace,
    )
    rows = []
    for restitution in RESTITUTIONS:
        number = drops * len(droppers)
        name = str(restitution)
        efforts = [
            dropper.effort(dropper.rules(restitution), 0, drops) for dropper in droppers
        ]
        impacts, steps = (fmean(counts) for counts in zip(*efforts, strict=True))
        rate = number / timings.median(name)
        targets = [Target("drops/s", rate, LEAST[restitution], at_least=True)]
        if restitution in AIM:
            targets.append(
                Target("aim: drops/s", rate, AIM[restitution], at_least=True)
            )
        rows.append(
            Row(
                f"restitution {restitution}",
                {
                    "drops/s": rate,
                    "best": number / min(timings.seconds[name]),
                    "impacts a drop": impacts,
                    "steps a drop": steps,
                    "µs an impact": 1e6 / rate / impacts,
                    "rounds": len(timings.seconds[name]),
                },
                tuple(targets),
            )
        )
    return rows


def _caller(
    droppers: Sequence[Dropper], restitution: float, drops: int
) -> Callable[[object], object]:
    seeds = count()
    rules = [dropper.rules(restitution) for dropper in droppers]

    def call(_: object) -> None:
        seed = next(seeds)
        for dropper, rule in zip(droppers, rules, strict=True):
            dropper.drop(rule, seed, drops)

    return call


RESTITUTION = 0.5
FEWEST = 8
PILOT = 4
COST = "µs a drop"
IMPACTS = "impacts a drop"
STEPS = "steps a drop"
EACH = "µs an event"

GROWTH = (
    f"Restitution {RESTITUTION}, release 20 radii up. `ellipsoid`: random points on "
    "one of axes 1, 0.7, 0.5, at the cluster tolerance of the row: the more facets, "
    "the lower the barriers between those that are stable, and at tolerance 0 a drop "
    "goes on until the last one is decided. The rounded box, from "
    "`lab/bodies/curved.py`, has six flats that stay the only stable faces however "
    "fine the rest becomes, at the default cluster tolerance. `events` are impacts and "
    "steps of the motion between them. Time of dropping on one thread, the median over "
    "rounds of other drops."
)


def growth(
    families: Sequence[tuple[str, float, Sequence[Body]]], seconds: float, pace: Pace
) -> Section:
    """A row for each body.

    Parameters
    ----------
    families : sequence of (name, cluster tolerance, bodies by rising vertices)
    seconds : float
        About as long are the drops of a body in one round.
    pace : Pace
    """
    rows = [
        _row(name, Dropper(body, tolerance), seconds, pace)
        for name, tolerance, bodies in families
        for body in bodies
    ]
    return Section(
        "drop_growth", "Cost of a drop against vertices", GROWTH, tuple(rows)
    )


def _row(name: str, dropper: Dropper, seconds: float, pace: Pace) -> Row:
    rules = dropper.rules(RESTITUTION)
    begin = time.perf_counter()
    dropper.drop(rules, 0, PILOT)
    drops = max(FEWEST, int(seconds * PILOT / (time.perf_counter() - begin)))

    def call(seed: int) -> object:
        return dropper.drop(rules, seed, drops)

    seeds = count(1)
    timings = race([Contender("drop", call, lambda: next(seeds))], pace)
    effort = dropper.effort(rules, 1, drops)
    cost = 1e6 * timings.median("drop") / drops
    return Row(
        f"{name}, {dropper.vertices} vertices",
        {
            "vertices": dropper.vertices,
            "poses": dropper.poses,
            COST: cost,
            IMPACTS: effort.impacts,
            STEPS: effort.steps,
            EACH: cost / (effort.impacts + effort.steps),
            "drops a round": drops,
        },
    )
