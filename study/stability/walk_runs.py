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

"""Every estimator and the simulation along the walks; expected errors against true
ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators import estimate_all
from ros_pose_stats.core.estimators.expected import expected_error
from ros_pose_stats.core.planning.hybrid import hybrid
from ros_pose_stats.core.records import Array, DropScene, Index, PoseStatistics
from ros_pose_stats.core.simulation.simulate import simulate
from ros_pose_stats.core.statistics.errors import (
    jeffreys_interval,
    root_mean_square,
    standard_errors,
)

from ..dataset import Dataset, shipped_dataset, shipped_datasets
from ..estimates import restings, scene_estimates, square_errors
from .jumps import Change, change
from .walk import Step, Walk
from .walks import walks

DROPS = 4_000
QUICK_DROPS = 200
COMBINED_DROPS = 100
COMBINED_SEED = 10_000
LEVEL = 0.95


class Curve(NamedTuple):
    """A method along a walk.

    Attributes
    ----------
    method : str
    values : (k,) array
        Probability of what is watched.
    change : Change
        How steeply it changes, and where it jumps.
    """

    method: str
    values: Array
    change: Change


class SimulatedCurve(NamedTuple):
    """The simulation along a walk: (k,) arrays; `low` and `high` bound 95 %
    intervals.
    """

    values: Array
    low: Array
    high: Array
    settled: Index


@dataclass(frozen=True, eq=False)
class WalkResults:
    """Results of one walk.

    Attributes
    ----------
    walk : Walk
    values : (k,) array
        Of the parameter, where it was measured.
    poses : (k,) array of int
        Stable poses there.
    curves : tuple of Curve
    simulated : SimulatedCurve
    combined : (k,) array
        Probability by hybrid, with `COMBINED_DROPS` drops of its own.
    """

    walk: Walk
    values: NDArray[np.floating[Any]]
    poses: Index
    curves: tuple[Curve, ...]
    simulated: SimulatedCurve
    combined: Array


@dataclass(frozen=True, eq=False)
class StabilityResults:
    """The whole study.

    Attributes
    ----------
    walks : tuple of WalkResults
    reliability : dict of str to tuple of ReliabilityBin
        By method.
    """

    walks: tuple[WalkResults, ...]
    reliability: dict[str, tuple[ReliabilityBin, ...]]


def stability(
    *, quick: bool = False, on_progress: Callable[[str], object] = lambda _: None
) -> StabilityResults:
    """Measure along all walks, then compare expected errors with true ones.

    Parameters
    ----------
    quick : bool
        Whether to take every third value, few drops and one dataset, to see that it
        works.
    on_progress : callable, optional
        Called with the title of each walk.
    """
    measured_walks = []
    for walk in walks():
        on_progress(walk.title)
        measured_walks.append(
            measure_walk(walk, QUICK_DROPS if quick else DROPS, 3 if quick else 1)
        )
    on_progress("expected errors against true ones")
    datasets = [shipped_dataset()] if quick else shipped_datasets()
    return StabilityResults(tuple(measured_walks), reliability(datasets))


def measure_walk(walk: Walk, drops: int, stride: int = 1) -> WalkResults:
    """Measure every estimator and the simulation along one walk.

    Parameters
    ----------
    walk : Walk
    drops : int
        At each value.
    stride : int
        Every so many values are taken.
    """
    values = walk.values[::stride]
    steps = [walk.make(value) for value in values.tolist()]
    estimates = [estimate_all(step.part, **walk.scene(step)) for step in steps]
    shares = [_shares(walk, answers) for answers in estimates]
    positions = np.array([walk.position(value) for value in values.tolist()])

    @lru_cache(maxsize=4096)
    def estimate_at(position: float) -> dict[str, float]:
        step = walk.make(walk.value(position))
        return _shares(walk, estimate_all(step.part, **walk.scene(step)))

    def curve(method: str) -> Curve:
        probabilities = np.array([of_step[method] for of_step in shares])
        return Curve(
            method,
            probabilities,
            change(
                positions,
                probabilities,
                lambda position: estimate_at(position)[method],
                walk.whole,
            ),
        )

    return WalkResults(
        walk,
        values,
        np.array([len(answers[0].poses) for answers in estimates]),
        tuple(map(curve, shares[0])),
        _simulated(walk, steps, drops),
        _combined(walk, steps),
    )


def _shares(walk: Walk, answers: Sequence[PoseStatistics]) -> dict[str, float]:
    """Probability of what is watched, by each estimator."""
    return {answer.method: _watched(walk, answer, "probability") for answer in answers}


def _combined(walk: Walk, steps: Sequence[Step]) -> Array:
    """Probability by an estimate with a few fresh drops, at each step."""
    answers = [
        hybrid(
            step.part, COMBINED_DROPS, seed=COMBINED_SEED + number, **walk.scene(step)
        )
        for number, step in enumerate(steps)
    ]
    return np.array([_watched(walk, answer, "probability") for answer in answers])


def _watched(walk: Walk, statistics: PoseStatistics, name: str) -> float:
    """Sum of a number of the poses that are watched."""
    downs, values = zip(
        *((pose.down, getattr(pose, name)) for pose in statistics.poses), strict=True
    )
    is_watched = walk.watched(np.array(downs))
    return float(
        sum(value for value, yes in zip(values, is_watched, strict=True) if yes)
    )


def _simulated(walk: Walk, steps: Sequence[Step], drops: int) -> SimulatedCurve:
    """Fresh drops at each step, so that neighbours scatter independently."""
    answers = [
        simulate(step.part, drops, seed=seed, **walk.scene(step))
        for seed, step in enumerate(steps)
    ]
    counts = np.array([_watched(walk, answer, "count") for answer in answers])
    settled = np.array([answer.drops - answer.unsettled for answer in answers])
    low, high = jeffreys_interval(counts, settled, LEVEL)
    return SimulatedCurve(counts / settled, low, high, settled)


BINS = 10
FEW_DROPS = 100
SIMULATION = "simulation, n = 100"


class ReliabilityBin(NamedTuple):
    """Parts of about the same expected error.

    Attributes
    ----------
    expected, true : float
        Root mean squares over the parts and restitutions, fractions; `true` has the
        noise of the reference taken off.
    error : float
        Standard error of `true`.
    parts : int
    """

    expected: float
    true: float
    error: float
    parts: int


def reliability(datasets: Sequence[Dataset]) -> dict[str, tuple[ReliabilityBin, ...]]:
    """Ten bins of parts for each estimator, and for a simulation of 100 drops.

    Every part counts once at each restitution. The simulation's first 100 drops are
    judged by the others.
    """
    expected: dict[str, list[float]] = {}
    squares: dict[str, list[Array]] = {}
    for dataset in datasets:
        for name, expected_errors, square_error in _judged(dataset):
            expected.setdefault(name, []).extend(expected_errors)
            squares.setdefault(name, []).append(square_error)
    return {
        name: _bins(np.array(expected_errors), np.concatenate(squares[name]))
        for name, expected_errors in expected.items()
    }


def _judged(dataset: Dataset) -> Iterator[tuple[str, list[float], Array]]:
    """Name, expected errors (B,) and true mean squares (B,), at each restitution."""
    poses = restings(dataset)
    ends = dataset.pose_starts[1:-1]
    for restitution, estimates_of in scene_estimates(dataset, poses).items():
        scene = DropScene(restitution, dataset.spec.drop_height, 0.0, 0)
        for name, values in estimates_of.items():
            expected_errors = [
                expected_error(name, resting, shares, scene).part_error
                for resting, shares in zip(poses, np.split(values, ends), strict=True)
            ]
            yield (
                name,
                expected_errors,
                square_errors(values, dataset.simulated(restitution)),
            )
    for restitution in dataset.spec.restitutions:
        first_drops = dataset.simulated(restitution, FEW_DROPS)
        expected_errors = [
            root_mean_square(standard_errors(shares, int(shares.sum())))
            for shares in np.split(first_drops.count, ends)
        ]
        remaining_drops = dataset.remaining_drops(restitution, FEW_DROPS)
        yield (
            SIMULATION,
            expected_errors,
            square_errors(first_drops.probability, remaining_drops),
        )


def _bins(expected: Array, squares: Array) -> tuple[ReliabilityBin, ...]:
    bins = []
    for rows in np.array_split(np.argsort(expected, kind="stable"), BINS):
        mean = float(squares[rows].mean())
        scatter = float(squares[rows].std(ddof=1)) / math.sqrt(len(rows))
        true = math.sqrt(max(mean, 0.0))
        bins.append(
            ReliabilityBin(
                math.sqrt(float(np.mean(np.square(expected[rows])))),
                true,
                0.5 * scatter / true if true > 0.0 else math.sqrt(scatter),
                len(rows),
            )
        )
    return tuple(bins)
