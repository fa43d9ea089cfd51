"""Points of the chart: time of a method against its error, on the bodies of one
size.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from statistics import median
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats import estimate
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

Array = NDArray[np.float64]

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


class Effort(NamedTuple):
    """How much to measure.

    Attributes
    ----------
    parts : int
        Most parts on which estimators are timed.
    drops_timed : int
        Drops that the simulation is timed on, about, for each number of drops and restitution.
    drops : tuple of int
        Numbers of drops, each a point of the simulation.
    combined : tuple of int
        Numbers of drops, each a point of an estimate with as many drops.
    fewest : int
        Least number of parts that are timed, however many drops that takes.
    """

    parts: int = MOST_PARTS
    drops_timed: int = DROPS_TIMED
    drops: tuple[int, ...] = DROPS
    combined: tuple[int, ...] = COMBINED
    fewest: int = 4

    def time_call(self, drops: int) -> int:
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
                for mesh in pick_meshes(size.meshes, effort.time_call(drops))
            ]
        )
        noise = noise_of(simulated, drops)
        yield ChartPoint(
            f"n = {drops:,}".replace(",", " "),
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
    return estimate(
        mesh.part(),
        name,
        cluster_tolerance=size.cluster_tolerance,
        round_sides=size.round_sides,
    )


def _run_simulation(size: Size, mesh: Mesh, drops: int, restitution: float) -> object:
    return simulate(
        mesh.part(),
        drops,
        restitution,
        1,
        size.height,
        workers=1,
        cluster_tolerance=size.cluster_tolerance,
        round_sides=size.round_sides,
    )


def pick_meshes(meshes: Sequence[Mesh], number: int) -> list[Mesh]:
    """Pick at most so many meshes, evenly spread."""
    number = min(number, len(meshes))
    return [meshes[(2 * k + 1) * len(meshes) // (2 * number)] for k in range(number)]


SERIES = "hybrid"
SEED = 31
"""Seed of the drops, with the body's number; the reference has other seeds."""


def combined_points(size: Size, effort: Effort) -> Iterator[ChartPoint]:
    """A point for each number of drops, measured against the reference on all bodies.

    The reference has other drops, so that its noise can be taken off.
    """
    simulated = pooled(list(size.simulated.values()))
    for drops in effort.combined:
        took = medians(
            [
                {"": partial(_run_hybrid, size, mesh, drops, restitution, 1)}
                for restitution in size.simulated
                for mesh in pick_meshes(size.meshes, effort.time_call(drops))
            ]
        )
        values = [
            _combined_shares(size, mesh, drops, restitution, number)
            for restitution in size.simulated
            for number, mesh in enumerate(size.meshes)
        ]
        yield measured_point(
            f"n = {drops:,}".replace(",", " "),
            "hybrid",
            took[""],
            accuracy(np.concatenate(values), simulated),
            SERIES,
        )


def _combined_shares(
    size: Size, mesh: Mesh, drops: int, restitution: float, number: int
) -> Array:
    """Probabilities (P,) by `index`, of hybrid with drops of its own."""
    seed = np.random.SeedSequence((SEED, number, round(restitution * 1e9)))
    statistics = _run_hybrid(
        size, mesh, drops, restitution, int(seed.generate_state(1, np.uint64)[0])
    )
    return np.array(
        [
            pose.probability
            for pose in sorted(statistics.poses, key=lambda one: one.index)
        ]
    )


def _run_hybrid(
    size: Size, mesh: Mesh, drops: int, restitution: float, seed: int
) -> PoseStatistics:
    return hybrid(
        mesh.part(),
        drops,
        restitution,
        seed,
        size.height,
        workers=1,
        cluster_tolerance=size.cluster_tolerance,
        round_sides=size.round_sides,
    )


Call = Callable[[], object]
Result = TypeVar("Result")


def medians(parts: Sequence[Mapping[str, Call]], times: int = 1) -> dict[str, float]:
    """Seconds of each method: the median over parts of the median of a few calls.

    Parameters
    ----------
    parts : sequence of mappings
        For each part, from a method's name to a call of it; the same names everywhere.
    times : int
        Calls of each method for a part, all methods taking turns.
    """
    gc.collect()
    for call in parts[0].values():  # the first call prepares what is made only once
        call()
    seconds_of: dict[str, list[float]] = {name: [] for name in parts[0]}
    for calls in parts:
        turns = [
            {name: _time_once(call) for name, call in calls.items()}
            for _ in range(times)
        ]
        for name, seconds in seconds_of.items():
            seconds.append(median(turn[name] for turn in turns))
    return {name: median(seconds) for name, seconds in seconds_of.items()}


def time_call(call: Callable[[], Result]) -> tuple[float, Result]:
    """Seconds of a call, the garbage collector held off as in `timeit`, and its
    result.
    """
    is_enabled = gc.isenabled()
    gc.disable()
    try:
        begin = time.perf_counter()
        result = call()
        return time.perf_counter() - begin, result
    finally:
        if is_enabled:
            gc.enable()


def _time_once(call: Call) -> float:
    return time_call(call)[0]  # freeing the result is not timed
