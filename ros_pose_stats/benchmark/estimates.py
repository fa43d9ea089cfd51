"""What every estimator says of the bodies of a dataset."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..estimators.registry import ESTIMATORS
from ..geometry.poses import RestingPoses
from ..statistics.simulated_poses import SimulatedPoses
from .dataset import Dataset

Array = NDArray[np.float64]


def restings(dataset: Dataset,
             on_progress: Callable[[int], object] = lambda _: None) -> list[RestingPoses]:
    """Stable poses of every body, in the order of the counts.

    Parameters
    ----------
    dataset : Dataset
    on_progress : callable, optional
        Told how many bodies are done.
    """
    found = []
    for number in range(dataset.spec.bodies):  # threads would wait for the lock and be slower
        found.append(dataset.resting(number))
        on_progress(number + 1)
    return found


def estimates(poses: list[RestingPoses]) -> dict[str, Array]:
    """Probabilities (P,) of all bodies' poses by the name of the method.

    Of the registered methods those that are blind to the scene: one answer for all
    restitutions, as in the paper.
    """
    return {name: np.concatenate([entry.function(one) for one in poses])
            for name, entry in ESTIMATORS.items()
            if not (entry.knows_restitution or entry.knows_drop_height)}


def square_errors(values: Array, reference: SimulatedPoses) -> Array:
    """Mean square error (B,) of each body, the reference's noise taken off.

    Chance makes some negative.

    Parameters
    ----------
    values : (P,) array
        Probabilities in the order of the reference.
    reference : SimulatedPoses
        Of bodies 0 ... B - 1 at one restitution.
    """
    away = np.square(values - reference.probability) - reference.noise_variance(unbiased=True)
    return np.bincount(reference.body, away) / np.bincount(reference.body)
