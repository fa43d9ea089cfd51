"""What the benchmark of square prisms found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEVEL = 0.95
"""Of the intervals, as in Fig. 5."""


class SidesPoint(NamedTuple):
    """How often a square prism came to rest on one of its four sides.

    Attributes
    ----------
    ratio : float
        Length over width.
    probability : float
        Share of the trials, 0 to 1.
    low, high : float
        Bounds of its 95 % Jeffreys interval.
    trials : int
        Rolls, or drops that settled.
    """

    ratio: float
    probability: float
    low: float
    high: float
    trials: int


class Misfit(NamedTuple):
    """How far a method is from the dice.

    Attributes
    ----------
    method : str
        Name of an estimator, or `simulation`.
    title : str
        For people.
    restitution : float or None
        None for an estimator.
    rms : float
        Root mean square over the dice of the difference in the probability of the four sides.
    standard_error : float
        Of `rms`, from the finite numbers of rolls and drops.
    fitted : bool
        Whether a coefficient of the method was fitted to these dice, so that `rms` flatters it.
    """

    method: str
    title: str
    restitution: float | None
    rms: float
    standard_error: float
    fitted: bool


@dataclass(frozen=True, eq=False)
class PrismResults:
    """Fig. 5 in numbers. All probabilities are those of the four sides together, 0 to 1.

    Attributes
    ----------
    ratios : (k,) array
        Length over width of the estimated curves, rising.
    estimated : dict of str to (k,) array
        By the estimator's name.
    simulated : dict of float to tuple of SidesPoint
        By restitution; by rising ratio.
    dice : tuple of SidesPoint
        As they were rolled, by rising ratio.
    dice_estimated : dict of str to (15,) array
        The estimators at the ratios of the dice.
    dice_simulated : dict of float to tuple of SidesPoint
        The simulation at the ratios of the dice.
    misfits : tuple of Misfit
        Best first. A restitution at which not all dice were simulated is left out.
    sampling_noise : float
        Root mean square binomial error of the dice, below which no method can be told apart.
    drops, dice_drops, seed : int
        As they were asked for.
    release_radii : float
        Height of the centre of mass at release, in radii of the prism.
    stopped : bool
        Whether simulations are missing because the run was stopped.
    seconds : float
        That the run took.
    """

    ratios: Array
    estimated: dict[str, Array]
    simulated: dict[float, tuple[SidesPoint, ...]]
    dice: tuple[SidesPoint, ...]
    dice_estimated: dict[str, Array]
    dice_simulated: dict[float, tuple[SidesPoint, ...]]
    misfits: tuple[Misfit, ...]
    sampling_noise: float
    drops: int
    dice_drops: int
    seed: int
    release_radii: float
    stopped: bool
    seconds: float

    def as_dict(self) -> dict[str, Any]:
        """The results as plain values that JSON can hold; every number is finite."""
        plain = ("sampling_noise", "drops", "dice_drops", "seed", "release_radii", "stopped",
                 "seconds")
        return {
            "level": LEVEL,
            "ratios": self.ratios.tolist(),
            "estimated": _lists(self.estimated),
            "simulated": _by_restitution(self.simulated),
            "dice": _points(self.dice),
            "dice_estimated": _lists(self.dice_estimated),
            "dice_simulated": _by_restitution(self.dice_simulated),
            "misfits": [misfit._asdict() for misfit in self.misfits],
            **{name: getattr(self, name) for name in plain},
        }


def _lists(curves: dict[str, Array]) -> dict[str, list[float]]:
    return {name: curve.tolist() for name, curve in curves.items()}


def _points(points: tuple[SidesPoint, ...]) -> list[dict[str, Any]]:
    return [point._asdict() for point in points]


def _by_restitution(points: dict[float, tuple[SidesPoint, ...]]) -> list[dict[str, Any]]:
    """A list, since the keys of a JSON object are no numbers."""
    return [{"restitution": restitution, "points": _points(some)}
            for restitution, some in points.items()]
