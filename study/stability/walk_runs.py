"""Every estimator and the simulation along the walks; expected errors against true ones."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators import estimate_all
from ros_pose_stats.core.estimators.expected import expected_error
from ros_pose_stats.core.planning.hybrid import hybrid
from ros_pose_stats.core.records import DropScene, PoseStatistics
from ros_pose_stats.core.resting.poses import resting_poses
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

Array = NDArray[np.float64]

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
    """The simulation along a walk: (k,) arrays; `low` and `high` bound 95 % intervals."""

    values: Array
    low: Array
    high: Array
    settled: NDArray[np.int64]


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
    values: Array
    poses: NDArray[np.int64]
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
        Whether to take every third value, few drops and one dataset, to see that it works.
    on_progress : callable, optional
        Called with the title of each walk.
    """
    found = []
    for walk in walks():
        on_progress(walk.title)
        found.append(measured(walk, QUICK_DROPS if quick else DROPS, 3 if quick else 1))
    on_progress("expected errors against true ones")
    datasets = [shipped_dataset()] if quick else shipped_datasets()
    return StabilityResults(tuple(found), reliability(datasets))


def measured(walk: Walk, drops: int, stride: int = 1) -> WalkResults:
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
    told = [_estimated(walk, step) for step in steps]
    places = np.array([walk.place(value) for value in values.tolist()])

    @lru_cache(maxsize=4096)
    def between(place: float) -> dict[str, float]:
        return _estimated(walk, walk.make(walk.value(place)))

    def curve(method: str) -> Curve:
        probabilities = np.array([one[method] for one in told])
        return Curve(
            method,
            probabilities,
            change(
                places, probabilities, lambda place: between(place)[method], walk.whole
            ),
        )

    poses = [
        len(resting_poses(step.part, walk.tolerance(step), walk.round_sides).poses)
        for step in steps
    ]
    return WalkResults(
        walk,
        values,
        np.array(poses),
        tuple(map(curve, told[0])),
        _simulated(walk, steps, drops),
        _combined(walk, steps),
    )


def _estimated(walk: Walk, step: Step) -> dict[str, float]:
    """Probability of what is watched, by each estimator."""
    found = estimate_all(
        step.part,
        restitution=step.restitution,
        drop_height=step.drop_height,
        cluster_tolerance=walk.tolerance(step),
        round_sides=walk.round_sides,
    )
    return {one.method: _watched(walk, one) for one in found}


def _combined(walk: Walk, steps: Sequence[Step]) -> Array:
    """Probability by an estimate with a few fresh drops, at each step."""
    return np.array(
        [
            _watched(
                walk,
                hybrid(
                    step.part,
                    COMBINED_DROPS,
                    step.restitution,
                    COMBINED_SEED + place,
                    step.drop_height,
                    cluster_tolerance=walk.tolerance(step),
                    round_sides=walk.round_sides,
                ),
            )
            for place, step in enumerate(steps)
        ]
    )


def _watched(walk: Walk, found: PoseStatistics) -> float:
    seen = walk.watched(np.array([pose.down for pose in found.poses]))
    return float(
        sum(
            pose.probability for pose, yes in zip(found.poses, seen, strict=True) if yes
        )
    )


def _simulated(walk: Walk, steps: Sequence[Step], drops: int) -> SimulatedCurve:
    """Fresh drops at each step, so that neighbours scatter independently."""
    counts = []
    settled = []
    for seed, step in enumerate(steps):
        found = simulate(
            step.part,
            drops,
            step.restitution,
            seed,
            step.drop_height,
            cluster_tolerance=walk.tolerance(step),
            round_sides=walk.round_sides,
        )
        seen = walk.watched(np.array([pose.down for pose in found.poses]))
        counts.append(
            sum(pose.count for pose, yes in zip(found.poses, seen, strict=True) if yes)
        )
        settled.append(found.drops - found.unsettled)
    low, high = jeffreys_interval(np.array(counts), np.array(settled), LEVEL)
    return SimulatedCurve(
        np.array(counts) / np.array(settled), low, high, np.array(settled)
    )


BINS = 10
FEW_DROPS = 100
SIMULATION = "simulation, n = 100"


class ReliabilityBin(NamedTuple):
    """Parts of about the same expected error.

    Attributes
    ----------
    expected, true : float
        Root mean squares over the parts and restitutions, fractions; `true` has the noise of
        the reference taken off.
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

    Every part counts once at each restitution. The simulation's first 100 drops are judged by
    the others.
    """
    expected: dict[str, list[float]] = {}
    squares: dict[str, list[Array]] = {}
    for dataset in datasets:
        for name, told, found in _judged(dataset):
            expected.setdefault(name, []).extend(told)
            squares.setdefault(name, []).append(found)
    return {
        name: _bins(np.array(told), np.concatenate(squares[name]))
        for name, told in expected.items()
    }


def _judged(dataset: Dataset) -> Iterator[tuple[str, list[float], Array]]:
    """Name, expected errors (B,) and true mean squares (B,), at each restitution."""
    poses = restings(dataset)
    ends = dataset.pose_starts[1:-1]
    for restitution, told_by in scene_estimates(dataset, poses).items():
        scene = DropScene(restitution, dataset.spec.drop_height, 0.0, 0)
        for name, values in told_by.items():
            told = [
                expected_error(name, one, some, scene).part_error
                for one, some in zip(poses, np.split(values, ends), strict=True)
            ]
            yield name, told, square_errors(values, dataset.simulated(restitution))
    for restitution in dataset.spec.restitutions:
        few = dataset.simulated(restitution, FEW_DROPS)
        told = [
            root_mean_square(standard_errors(some, int(some.sum())))
            for some in np.split(few.count, ends)
        ]
        others = dataset.rest(restitution, FEW_DROPS)
        yield SIMULATION, told, square_errors(few.probability, others)


def _bins(expected: Array, squares: Array) -> tuple[ReliabilityBin, ...]:
    found = []
    for some in np.array_split(np.argsort(expected, kind="stable"), BINS):
        mean = float(squares[some].mean())
        scatter = float(squares[some].std(ddof=1)) / math.sqrt(len(some))
        true = math.sqrt(max(mean, 0.0))
        found.append(
            ReliabilityBin(
                math.sqrt(float(np.mean(np.square(expected[some])))),
                true,
                0.5 * scatter / true if true > 0.0 else math.sqrt(scatter),
                len(some),
            )
        )
    return tuple(found)
