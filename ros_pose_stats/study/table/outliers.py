"""The largest deviations of the combined estimator, dropped again more often (section 4.F)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ...simulation.simulate import simulate
from ..dataset import Dataset
from .results import Outlier

Array = NDArray[np.float64]

NUMBER = 3
MORE_DROPS = (1_000, 10_000)


def outliers(dataset: Dataset, estimate: Array, first: int) -> list[Outlier]:
    """The largest deviations among the first drops, of different bodies, dropped again.

    Parameters
    ----------
    dataset : Dataset
    estimate : (P,) array
        The estimator's probabilities.
    first : int
        How many the first drops are.
    """
    seen = np.stack([dataset.simulated(one, first).probability
                     for one in dataset.spec.restitutions], axis=1)
    return [_again(dataset, float(estimate[pose]), pose, which, float(seen[pose, which]))
            for pose, which in _largest(dataset, np.abs(seen - estimate[:, None]))]


def _largest(dataset: Dataset, away: Array) -> Iterator[tuple[int, int]]:
    """Poses and places of restitutions, the worst first, each body once."""
    seen: set[int] = set()
    for place in np.argsort(-away, axis=None, kind="stable").tolist():
        pose, which = divmod(place, away.shape[1])
        body = int(dataset.body[pose])
        if body not in seen:
            seen.add(body)
            yield pose, which
        if len(seen) == NUMBER:
            return


def _again(dataset: Dataset, estimate: float, pose: int, which: int, first: float) -> Outlier:
    """Fresh drops: those by which an outlier was found are biased."""
    spec, body = dataset.spec, int(dataset.body[pose])
    restitution, number = spec.restitutions[which], pose - int(dataset.pose_starts[body])
    part = dataset.part(body)
    found = []
    for run, drops in enumerate(MORE_DROPS, 1):
        told = simulate(part, drops, restitution, spec.drop_seed(body, restitution, run),
                        spec.drop_height, cluster_tolerance=0.0)
        found.append((drops, next(one.probability for one in told.poses
                                  if one.index == number)))
    return Outlier(body, number, restitution, estimate, first, tuple(found))
