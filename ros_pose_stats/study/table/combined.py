"""The row of the table for estimate and drops together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...planning.confidence import pose_prior
from ...records import DropScene
from ...resting.poses import RestingPoses
from ..dataset import Dataset
from ..errors.partition import accuracy
from ..errors.simulated_poses import SimulatedPoses, pooled
from .results import CombinedRow

Array = NDArray[np.float64]


def combined_row(dataset: Dataset, poses: list[RestingPoses], first: int) -> CombinedRow:
    """Hybrid of the first drops, held against all the others.

    Parameters
    ----------
    dataset : Dataset
        With more drops than the first ones.
    poses : list of RestingPoses
        Of all bodies.
    first : int
        How many drops are the first.
    """
    rest = {one: dataset.rest(one, first) for one in dataset.spec.restitutions}
    told = {one: _told(poses, dataset.simulated(one, first),
                       DropScene(one, dataset.spec.drop_height, 0.0)) for one in rest}
    every = accuracy(np.concatenate(list(told.values())), pooled(list(rest.values())))
    return CombinedRow(f"hybrid, {first} drops", every,
                       {one: accuracy(told[one], rest[one]) for one in rest})


def _told(poses: list[RestingPoses], counted: SimulatedPoses, scene: DropScene) -> Array:
    """Probabilities of all bodies' poses."""
    ends = np.cumsum([len(one.poses) for one in poses])[:-1]
    return np.concatenate([
        pose_prior(one, scene).updated(counts).probability
        for one, counts in zip(poses, np.split(counted.count, ends), strict=True)])
