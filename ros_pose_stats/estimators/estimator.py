"""What an estimator is: a function from resting poses to probabilities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..records import DropScene
from ..resting.poses import RestingPoses

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimator:
    """A registered estimator.

    Attributes
    ----------
    name : str
        As in the contract, lower case.
    title : str
        For tables and figures.
    source : str
        Where it comes from, with the equation.
    function : callable
        From `RestingPoses` and `DropScene` to probabilities (P,), in the order of `index`,
        summing to 1.
    knows_restitution, knows_drop_height : bool
        Whether the scene changes its answer; the paper's estimators are blind to both.
    """

    name: str
    title: str
    source: str
    function: Callable[[RestingPoses, DropScene], Array]
    knows_restitution: bool = False
    knows_drop_height: bool = False


def blind(function: Callable[[RestingPoses], Array]) -> Callable[[RestingPoses, DropScene], Array]:
    """An estimator's function that looks at the poses alone, as one of poses and scene."""
    return lambda resting, _: function(resting)


def normalized(weights: Array) -> Array:
    """Weights (P,) scaled to sum to 1."""
    return np.asarray(weights / weights.sum())
