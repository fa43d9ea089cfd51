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

"""Drops that are ended as soon as their outcome is certain, against the same ones run
on, and what is left of them.

.venv/bin/python -m lab.benchmarks.rolls [--quick] [--write]
"""

import hashlib
from collections.abc import Iterator
from functools import partial

import numpy as np

from lab.bodies.families import family_part
from lab.bodies.rolling import ROLLING, SERIES, run_on
from lab.frame.results import Row, Section, Target
from lab.frame.timing import timed
from ros_pose_stats import Part
from ros_pose_stats.core.kernels.drops import layout
from ros_pose_stats.core.records import Array, DropScene, Index, Mask
from ros_pose_stats.core.records.scene import DEFAULT_CLUSTER_TOLERANCE
from ros_pose_stats.core.simulation.drop_body import PreparedBody, drop_body
from ros_pose_stats.core.simulation.drops import (
    DropOutcomes,
    compute_drops,
    drop_rules,
    release_directions,
)

from .drops.dropper import paper_seconds
from .program import benchmark_parser, run_benchmark

SEED = 31
DROPS = 30_000
FIRST_DROPS = 1_000
QUICK_DROPS = 100
RESTITUTION = 0.5
TAPED_DROPS = 20
TAPE_ROWS = 60_000
MOST_TIMES = 30.0
"""Drops of a body, those of one that ends none of the first early, and those whose
impacts are looked at; a drop may cost so many times one of the paper's bodies."""

ROLLS = (
    "Restitution {:g}, release 20 radii up. `run on`: events a drop, impacts and "
    "steps, where nothing but the way out of a pose ends it; `events`: as drops are "
    "ended. `early`, `drawn`: per cent that ended sooner, and whose pose was then "
    "drawn. `elsewhere`: those that run on end in another pose, or in one of another "
    "unit where it was drawn. `times`: processor time of a drop over that of one of "
    "the paper's random polyhedra. `one edge`: per cent of the impacts that are in a "
    "series that strikes the ends of a single edge until it is over. `digest`: of "
    "the units of the drops that were run on."
)
WEIGHTS = (
    "What it would bring to follow all drops until a cluster of poses is certain, and "
    "a fraction of them to its pose, with weights: by what factor fewer events give "
    "the same mean square error over the poses, with the best clusters and the best "
    "fraction. Poses of one unit count as pooled. Mean and most over {} bodies a "
    "family, by {} drops each."
)
WEIGHTED = (
    "flat balls",
    "cut eggs",
    "cap nuts",
    "springs",
    "rounds",
    "stepped",
    "domes",
    "fine ellipsoids",
    "cut cylinders",
    "machined",
)
WEIGHT_BODIES = 4
WEIGHT_DROPS = 200


def rolls(drops: int) -> Section:
    """A row for each body that rolls or rocks for long."""
    paper_cost = paper_seconds(RESTITUTION, SEED)
    rows = tuple(
        _roll_row(name, make(), drops, paper_cost) for name, make in ROLLING.items()
    )
    return Section(
        "rolls",
        "Drops that end as soon as they are certain",
        ROLLS.format(RESTITUTION),
        rows,
    )


def _roll_row(name: str, part: Part, drops: int, paper_cost: float) -> Row:
    scene = DropScene(RESTITUTION)
    body = drop_body(part, scene)
    rules = drop_rules(scene, body.radius, draws=True)
    downs = release_directions(body, SEED, 0, drops)
    unit = body.resting.unit
    first = compute_drops(body, rules, downs[:FIRST_DROPS])
    if not _ends_early(body, first).any():
        downs = downs[:FIRST_DROPS]
        drops = len(downs)
    outcomes, seconds = timed(partial(compute_drops, body, rules, downs))
    is_early = _ends_early(body, outcomes)
    whole = compute_drops(run_on(body), rules, downs[is_early])
    early_pose = outcomes.pose[is_early]
    is_elsewhere = np.where(
        outcomes.drawn[is_early],
        unit[early_pose] != unit[whole.pose],
        early_pose != whole.pose,
    )
    units = unit[outcomes.pose]
    units[is_early] = unit[whole.pose]
    elsewhere = int(is_elsewhere.sum())
    times = seconds / drops / paper_cost
    whole_events = whole.events.sum() + outcomes.events[~is_early].sum()
    return Row(
        name,
        {
            "drops": drops,
            "run on": float(whole_events / drops),
            "events": float(outcomes.events.mean()),
            "early": 100.0 * float(is_early.mean()),
            "drawn": 100.0 * float(outcomes.drawn.mean()),
            "elsewhere": elsewhere,
            "times": times,
            "one edge": 100.0 * _one_edge_share(body, downs[:TAPED_DROPS]),
            "digest": units_digest(units),
        },
        (Target("elsewhere", elsewhere, 1), Target("times", times, MOST_TIMES)),
    )


def _ends_early(body: PreparedBody, outcomes: DropOutcomes) -> Mask:
    """Whether drops ended before their energy was below the way out of their pose."""
    return outcomes.drawn | (outcomes.energy_left >= body.arrays.way_out[outcomes.pose])


def units_digest(units: Index) -> str:
    """Digest of the units in which drops ended."""
    return hashlib.sha256(units.astype("<i4").tobytes()).hexdigest()[:12]


def _one_edge_share(body: PreparedBody, downs: Array) -> float:
    """Share of the impacts that are in a series on one edge, brought to its end."""
    rules = drop_rules(DropScene(RESTITUTION), body.radius, draws=True)
    tape = np.zeros((TAPE_ROWS, layout.TAPE))
    impacts = 0
    on_edge = 0
    for down in downs:
        compute_drops(body, rules, down[None], tape)
        rows = tape[1 : int(tape[0, 0]) + 1]
        series: list[float] = []
        for event, vertex in rows[:, [layout.TAPE_EVENT, layout.TAPE_VERTEX]].tolist():
            if event == layout.IMPACT:
                series.append(vertex)
                impacts += 1
            elif event == layout.STOP:
                if len(set(series)) <= 2:
                    on_edge += len(series)
                series = []
    return on_edge / max(impacts, 1)


def weights(bodies: int) -> Section:
    """A row for each family."""
    rows = []
    for family in WEIGHTED:
        gains = [
            _weight_gain(family_part(family, SERIES, number))
            for number in range(bodies)
        ]
        rows.append(
            Row(family, {"mean": float(np.mean(gains)), "most": float(np.max(gains))})
        )
    return Section(
        "weights",
        "A fraction of the drops followed to the end",
        WEIGHTS.format(bodies, WEIGHT_DROPS),
        tuple(rows),
    )


def _weight_gain(part: Part) -> float:
    """Factor of events that the best clusters and fraction would save, at least 1."""
    body, outcomes = _drop_at(part, DEFAULT_CLUSTER_TOLERANCE)
    resting = body.resting
    events = float(outcomes.events.mean())
    rises = resting.clusters.barrier / resting.heights
    unit_size = np.bincount(resting.unit)[resting.unit]
    unit_count = np.bincount(
        resting.unit, np.bincount(outcomes.pose, minlength=rises.size)
    )
    share = (unit_count[resting.unit] + 0.5) / unit_size
    share /= share.sum()
    gain = 1.0
    for rise in np.unique(rises[np.isfinite(rises)]).tolist():
        if (1.0 + 1e-4) * rise >= 1.0:
            break
        coarse, coarse_outcomes = _drop_at(part, (1.0 + 1e-4) * rise)
        cluster = coarse.resting.pose_of_face[resting.faces]
        early = float(coarse_outcomes.events.mean())
        if cluster.max() == 0 or early >= events:
            continue
        gain = max(gain, _factor(share, resting.unit, cluster, early, events - early))
    return gain


def _drop_at(part: Part, tolerance: float) -> tuple[PreparedBody, DropOutcomes]:
    """Drops until a pose at some cluster tolerance is certain."""
    scene = DropScene(RESTITUTION, cluster_tolerance=tolerance)
    body = drop_body(part, scene)
    rules = drop_rules(scene, body.radius, draws=True)
    downs = release_directions(body, SEED, 0, WEIGHT_DROPS)
    return body, compute_drops(body, rules, downs)


def _factor(
    share: Array, unit: Index, cluster: Index, early: float, late: float
) -> float:
    """By two-phase sampling with the best fraction of the drops in the second phase.

    The variance of a share is a part between clusters, over all drops, and one within
    them, over those that are followed on.
    """
    between = 0.0
    within = 0.0
    for number in np.unique(unit).tolist():
        is_unit = unit == number
        for group in np.unique(cluster[is_unit]).tolist():
            whole = share[cluster == group].sum()
            inside = share[is_unit & (cluster == group)].sum() / whole
            scale = 1.0 / is_unit.sum()
            between += scale * inside**2 * whole * (1.0 - whole)
            within += scale * whole * inside * (1.0 - inside)
    if within * early >= between * late:
        return 1.0  # all of them are
    cost = (np.sqrt(between * early) + np.sqrt(within * late)) ** 2
    return float((between + within) * (early + late) / cost)


def sections(is_quick: bool) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    yield rolls(QUICK_DROPS if is_quick else DROPS)
    yield weights(1 if is_quick else WEIGHT_BODIES)


def main() -> None:
    """Read the arguments and measure."""
    parser = benchmark_parser(
        "lab.benchmarks.rolls", __doc__ or "", "few drops and bodies"
    )
    run_benchmark(parser, lambda options: sections(options.quick))


if __name__ == "__main__":
    main()
