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

"""Points of the chart: time of a method against its error, on the bodies of one
size.
"""

import gc
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from statistics import median
from typing import NamedTuple

import numpy as np

from lab.frame.timing import timed
from ros_pose_stats import auto, estimate
from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.planning.hybrid import hybrid
from ros_pose_stats.core.records import PoseStatistics
from ros_pose_stats.core.simulation.simulate import simulate

from .. import paper
from ..errors.partition import Accuracy, accuracy, noise_of
from ..errors.simulated_poses import pooled
from ..estimates import estimates
from ..figures.speed_accuracy import ChartPoint
from .bodies import Mesh, Size

REPEATS = 3
"""Calls of an estimator for a part, of which the median counts."""

DROPS = (10, 100, 1_000, 10_000)
DROPS_TIMED = 20_000
"""Drops that are timed for each number of drops; the fewer a part takes, the more
parts.
"""

COMBINED = (10, 100, 1_000)
"""Numbers of drops with an estimate; after more drops the estimate no longer
matters.
"""

MOST_PARTS = 60
MOST_ANSWERED = 200


class Effort(NamedTuple):
    """How much to measure.

    Attributes
    ----------
    parts : int
        Most parts on which estimators are timed.
    drops_timed : int
        Drops that the simulation is timed on, about, for each number of drops and
        restitution.
    drops : tuple of int
        Numbers of drops, each a point of the simulation.
    combined : tuple of int
        Numbers of drops, each a point of an estimate with as many drops.
    fewest : int
        Least number of parts that are timed, however many drops that takes.
    answered : int
        Most bodies for which answers with drops of their own are measured.
    """

    parts: int = MOST_PARTS
    drops_timed: int = DROPS_TIMED
    drops: tuple[int, ...] = DROPS
    combined: tuple[int, ...] = COMBINED
    fewest: int = 4
    answered: int = MOST_ANSWERED

    def parts_timed(self, drops: int) -> int:
        """Number of parts to time where each takes so many drops."""
        return min(max(self.drops_timed // drops, self.fewest), self.parts)


def estimator_points(size: Size, effort: Effort) -> Iterator[ChartPoint]:
    """A point for each estimator; the time is from the mesh arrays to the
    statistics.
    """
    simulated = pooled(list(size.simulated.values()))
    values = {rho: estimates(size.restings, size.scene(rho)) for rho in size.simulated}
    names = list(next(iter(values.values())))
    # The methods take turns, so that other load of the machine affects all of them
    # alike.
    took = medians(
        [
            {name: partial(_run_estimate, size, mesh, name) for name in names}
            for mesh in pick_meshes(size.meshes, effort.parts)
        ],
        REPEATS,
    )
    for name in names:
        error = accuracy(
            np.concatenate([shares[name] for shares in values.values()]), simulated
        )
        kind = "paper" if name in paper.ERRORS else "estimator"
        yield measured_point(ESTIMATORS[name].title, kind, took[name], error)


def simulation_points(size: Size, effort: Effort) -> Iterator[ChartPoint]:
    """A point for each number of drops; the error is the noise of that many independent
    drops.
    """
    simulated = pooled(list(size.simulated.values()))
    for drops in effort.drops:
        took = medians(
            [
                {"": partial(_run_simulation, size, mesh, drops, restitution)}
                for restitution in size.simulated
                for mesh in pick_meshes(size.meshes, effort.parts_timed(drops))
            ]
        )
        noise = noise_of(simulated, drops)
        yield ChartPoint(
            _drops_text(drops),
            "simulation",
            took[""],
            noise.error,
            noise.low,
            noise.high,
            "drop simulation",
        )


def measured_point(
    name: str, kind: str, seconds: float, error: Accuracy, series: str | None = None
) -> ChartPoint:
    """Make a point of a measured error, without an interval where there is a single
    body.
    """
    bounds = (
        (error.error, error.error) if math.isnan(error.low) else (error.low, error.high)
    )
    return ChartPoint(name, kind, seconds, error.error, *bounds, series)


def _run_estimate(size: Size, mesh: Mesh, name: str) -> object:
    return estimate(mesh.part(), name, **size.options)


def _run_simulation(size: Size, mesh: Mesh, drops: int, restitution: float) -> object:
    return simulate(
        mesh.part(),
        drops,
        restitution,
        1,
        size.height,
        workers=1,
        **size.options,
    )


def pick_meshes(meshes: Sequence[Mesh], number: int) -> list[Mesh]:
    """Pick at most so many meshes, evenly spread."""
    number = min(number, len(meshes))
    return [meshes[(2 * k + 1) * len(meshes) // (2 * number)] for k in range(number)]


SERIES = "hybrid"
SEED = 31
"""Seed of the drops, with the body's number; the reference has other seeds."""

Answer = Callable[[Mesh, float, int], PoseStatistics]
"""Of a body, a restitution and the body's number."""


def combined_points(size: Size, effort: Effort) -> Iterator[ChartPoint]:
    """A point for each number of drops beside an estimate."""
    for drops in effort.combined:
        yield _answered_point(
            size,
            _drops_text(drops),
            "hybrid",
            *_answers(size, partial(_run_hybrid, size, drops)),
            SERIES,
        )


def default_point(size: Size) -> ChartPoint:
    """The point of `auto` without a target, as everybody gets it: it decides itself how
    often to drop, and has seed 1 for every part. Its name tells the median of the
    drops.
    """
    answers, seconds = _answers(size, partial(_run_auto, size))
    drops = round(median(statistics.drops for statistics in answers))
    return _answered_point(
        size, f"default answer, {_drops_text(drops)}", "default", answers, seconds
    )


def _drops_text(drops: int) -> str:
    return f"n = {drops:,}".replace(",", " ")


def _answers(size: Size, answer: Answer) -> tuple[list[PoseStatistics], float]:
    """Answers at each restitution for all bodies, and their median time in seconds."""
    answers, seconds = zip(
        *(
            timed(partial(answer, mesh, restitution, number))
            for restitution in size.simulated
            for number, mesh in enumerate(size.meshes)
        ),
        strict=True,
    )
    return list(answers), median(seconds)


def _answered_point(
    size: Size,
    name: str,
    kind: str,
    answers: Sequence[PoseStatistics],
    seconds: float,
    series: str | None = None,
) -> ChartPoint:
    """Make a point of answers with drops of their own.

    The reference has other drops, so that its noise can be taken off.
    """
    probabilities = [
        pose.probability
        for statistics in answers
        for pose in statistics.by_index.values()
    ]
    simulated = pooled(list(size.simulated.values()))
    return measured_point(
        name, kind, seconds, accuracy(probabilities, simulated), series
    )


def _run_hybrid(
    size: Size, drops: int, mesh: Mesh, restitution: float, number: int
) -> PoseStatistics:
    seed = np.random.SeedSequence((SEED, number, round(restitution * 1e9)))
    return hybrid(
        mesh.part(),
        drops,
        restitution,
        int(seed.generate_state(1, np.uint64)[0]),
        size.height,
        workers=1,
        **size.options,
    )


def _run_auto(size: Size, mesh: Mesh, restitution: float, _: int) -> PoseStatistics:
    return auto(
        mesh.part(),
        restitution=restitution,
        drop_height=size.height,
        workers=1,
        **size.options,
    )


Call = Callable[[], object]


def medians(parts: Sequence[Mapping[str, Call]], times: int = 1) -> dict[str, float]:
    """Processor time of each method, seconds: the median over parts of the median of a
    few calls.

    Parameters
    ----------
    parts : sequence of mappings
        For each part, from a method's name to a call of it; the same names everywhere.
    times : int
        Calls of each method for a part, all methods taking turns.
    """
    gc.collect()
    # The first call prepares what is made only once.
    for call in parts[0].values():
        call()
    seconds_of: dict[str, list[float]] = {name: [] for name in parts[0]}
    for calls in parts:
        turns = [
            {name: timed(call)[1] for name, call in calls.items()} for _ in range(times)
        ]
        for name, seconds in seconds_of.items():
            seconds.append(median(turn[name] for turn in turns))
    return {name: median(seconds) for name, seconds in seconds_of.items()}
