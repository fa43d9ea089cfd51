"""Whether a larger expected error means a larger true one, over the reference datasets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...estimators.expected import expected_error
from ...records import DropScene
from ...statistics.errors import expected_error as error_of_drops
from ...statistics.errors import standard_errors
from ..dataset import Dataset
from ..estimates import restings, scene_estimates, square_errors

Array = NDArray[np.float64]

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
    return {name: _bins(np.array(told), np.concatenate(squares[name]))
            for name, told in expected.items()}


def _judged(dataset: Dataset) -> Iterator[tuple[str, list[float], Array]]:
    """Name, expected errors (B,) and true mean squares (B,), at each restitution."""
    poses = restings(dataset)
    ends = dataset.pose_starts[1:-1]
    for restitution, told_by in scene_estimates(dataset, poses).items():
        scene = DropScene(restitution, dataset.spec.drop_height, 0.0)
        for name, values in told_by.items():
            told = [expected_error(name, one, some, scene).here
                    for one, some in zip(poses, np.split(values, ends), strict=True)]
            yield name, told, square_errors(values, dataset.simulated(restitution))
    for restitution in dataset.spec.restitutions:
        few = dataset.simulated(restitution, FEW_DROPS)
        told = [error_of_drops(standard_errors(some, int(some.sum())))
                for some in np.split(few.count, ends)]
        others = dataset.rest(restitution, FEW_DROPS)
        yield SIMULATION, told, square_errors(few.probability, others)


def _bins(expected: Array, squares: Array) -> tuple[ReliabilityBin, ...]:
    found = []
    for some in np.array_split(np.argsort(expected, kind="stable"), BINS):
        mean = float(squares[some].mean())
        scatter = float(squares[some].std(ddof=1)) / math.sqrt(len(some))
        true = math.sqrt(max(mean, 0.0))
        found.append(ReliabilityBin(
            math.sqrt(float(np.mean(np.square(expected[some])))), true,
            0.5 * scatter / true if true > 0.0 else math.sqrt(scatter), len(some)))
    return tuple(found)
