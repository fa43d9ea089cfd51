"""Predictions beside each other, and beside what cameras counted."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...statistics.chi_square import ChiSquare, goodness_of_fit, homogeneity
from ...statistics.errors import root_mean_square
from ...statistics.intervals import jeffreys_interval
from .camera_counts import CameraCounts
from .results import Array, Index, PoseTable, Prediction, ResultHistory


@dataclass(frozen=True, eq=False)
class Comparison:
    """A prediction set against counts: those of a simulation, or a camera's.

    Attributes
    ----------
    prediction : Prediction
    share : (K,) array
        The counts as fractions of their sum, in the order of the pose table.
    rms, largest : float
        Root mean square and largest difference of probability and share over the poses, as
        fractions; NaN without counts.
    largest_pose : int
        Index of the pose with the largest difference.
    by_pose, by_group : ChiSquare
        Whether chance explains the differences. A simulation as prediction has its own chance.
    unforeseen : int
        Counts in poses whose predicted probability is 0.
    """

    prediction: Prediction
    share: Array
    rms: float
    largest: float
    largest_pose: int
    by_pose: ChiSquare
    by_group: ChiSquare
    unforeseen: int


@dataclass(frozen=True, eq=False)
class SimulationComparison:
    """Estimates set against one simulation."""

    simulation: Prediction
    estimates: tuple[Comparison, ...]


@dataclass(frozen=True, eq=False)
class CountComparison:
    """What cameras counted, set against every prediction of the same poses.

    Attributes
    ----------
    counts : CameraCounts
    cluster_tolerance : float
        Of the poses; NaN where the counts cannot be compared.
    index, count : (K,) arrays of int
        Poses in the order of the pose table; empty where the counts cannot be compared.
    share, low, high : (K,) arrays
        Fraction of all counts in stable poses, and the bounds of its 90 % interval.
    predictions : tuple of Comparison
    problem : str
        Why the counts cannot be compared; empty where they can.
    remarks : tuple of str
        What to bear in mind.
    """

    counts: CameraCounts
    cluster_tolerance: float
    index: Index
    count: Index
    share: Array
    low: Array
    high: Array
    predictions: tuple[Comparison, ...]
    problem: str
    remarks: tuple[str, ...]


def compare(prediction: Prediction, counts: NDArray[np.int64], poses: PoseTable) -> Comparison:
    """Set a prediction against counts (K,) in the order of the pose table."""
    share = _shares(counts)
    apart = np.abs(prediction.probability - share)
    known = bool(np.isfinite(apart).all())
    groups = np.unique(poses.group, return_inverse=True)[1]
    by_pose, by_group = (_test(prediction, counts, bins)
                         for bins in (np.arange(counts.size), groups))
    return Comparison(
        prediction, share, root_mean_square(apart), float(apart.max()),
        int(poses.index[apart.argmax()]) if known else -1, by_pose, by_group,
        int(counts[prediction.probability == 0.0].sum()))


def _shares(counts: Index) -> Array:
    total = counts.sum()
    return counts / total if total else np.full(counts.shape, math.nan)


def _test(prediction: Prediction, counts: Index, bins: Index) -> ChiSquare:
    observed = np.bincount(bins, counts)
    if prediction.counted:
        return homogeneity(observed, np.bincount(bins, prediction.count))
    probability = np.nan_to_num(np.bincount(bins, prediction.probability))
    if not probability.sum() > 0.0:
        return goodness_of_fit(np.zeros(1), np.ones(1))  # nothing was predicted
    return goodness_of_fit(observed, probability)


def simulation_comparisons(history: ResultHistory) -> Iterator[SimulationComparison]:
    """Every simulation beside all methods that are not counted."""
    estimates = [one for one in history.predictions if not one.counted]
    for simulation in history.predictions:
        if simulation.counted and estimates:
            yield SimulationComparison(simulation, tuple(
                compare(one, simulation.count, history.poses) for one in estimates))


def count_comparison(counts: CameraCounts, history: ResultHistory) -> CountComparison:
    """Counts beside every prediction of the poses that they number."""
    index = history.poses.index
    aligned = np.zeros(index.shape, dtype=np.int64)
    aligned[np.searchsorted(index, counts.index)] = counts.count
    low, high = jeffreys_interval(aligned, aligned.sum())
    return CountComparison(
        counts, history.cluster_tolerance, index, aligned, _shares(aligned), low, high,
        tuple(compare(one, aligned, history.poses) for one in history.predictions), "",
        tuple(_remarks(counts, history)))


def incomparable(counts: CameraCounts, problem: str) -> CountComparison:
    """Counts that no prediction of the bags is about."""
    none, nothing = np.empty(0, dtype=np.int64), np.empty(0)
    return CountComparison(counts, math.nan, none, none, nothing, nothing, nothing, (), problem,
                           ())


def _remarks(counts: CameraCounts, history: ResultHistory) -> Iterator[str]:
    if np.unique(history.poses.group).size < history.poses.index.size:
        yield ("poses of one group look alike: a camera that cannot tell them apart is judged by "
               "group alone")
    plates = sorted({one.plate for one in history.predictions if one.plate})
    if counts.plate and plates and counts.plate not in plates:
        yield f"counted on plate {counts.plate}, predicted for {', '.join(plates)}"
    for one in history.predictions:
        if math.isfinite(counts.drop_height) and math.isfinite(one.drop_height) and not (
                math.isclose(counts.drop_height, one.drop_height, rel_tol=0.05)):
            yield (f"counted after drops from {counts.drop_height * 1e3:.4g} mm, {one.method} "
                   f"from {one.drop_height * 1e3:.4g} mm")
