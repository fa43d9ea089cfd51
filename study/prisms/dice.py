"""Budden's dice, fifteen square prisms rolled by a class, and how far methods are from them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SOURCE = (
    "Budden, 1980; table in Mungan and Lipscombe, Mathematical Gazette 97 (2013), "
    "note 97.16"
)


class Die(NamedTuple):
    """A square prism that was rolled.

    Attributes
    ----------
    ratio : float
        Length over width: the third side over the side of the square.
    on_squares : float
        Frequency of the two square faces together, as published, 0 to 1.
    rolls : int
    """

    ratio: float
    on_squares: float
    rolls: int

    @property
    def on_sides(self) -> float:
        """Frequency of the four sides together, 0 to 1."""
        return 1.0 - self.on_squares

    @property
    def rolls_on_sides(self) -> int:
        """Rolls that ended on a side: the whole number that the published frequency rounds."""
        return self.rolls - round(self.on_squares * self.rolls)


DICE = (
    Die(0.47, 0.916, 332),
    Die(0.63, 0.738, 840),
    Die(0.75, 0.548, 799),
    Die(0.81, 0.496, 740),
    Die(0.93, 0.399, 516),
    Die(0.97, 0.385, 530),
    Die(1.16, 0.148, 1011),
    Die(1.23, 0.154, 532),
    Die(1.44, 0.052, 654),
    Die(1.55, 0.040, 606),
    Die(1.60, 0.017, 702),
    Die(1.71, 0.031, 609),
    Die(1.87, 0.009, 680),
    Die(2.12, 0.007, 275),
    Die(2.65, 0.006, 503),
)
"""The dice by rising ratio; the source is `SOURCE`."""


REPLICATES = 4000
"""Replicates of the bootstrap; they give a standard error to about a hundredth of itself."""

MEASURED: Array = np.array([die.on_sides for die in DICE])
ROLLS: NDArray[np.int64] = np.array([die.rolls for die in DICE])


def root_mean_square(predicted: ArrayLike) -> float:
    """Root mean square difference of a prediction (15,) from the dice; 0 to 1."""
    return float(np.sqrt(np.mean(np.square(np.asarray(predicted) - MEASURED))))


def standard_error(
    predicted: ArrayLike, trials: ArrayLike | None = None, *, seed: int
) -> float:
    """Standard error of `root_mean_square` by parametric bootstrap.

    The dice are rolled again, binomially at their measured frequencies, and a prediction that
    was itself counted is counted again. The answer is the standard deviation of the root mean
    square over these replicates.

    Parameters
    ----------
    predicted : (15,) array
        Probability of the four sides of each die.
    trials : (15,) array of int, optional
        Drops behind each prediction; none for an estimator, which has no error of sampling.
    seed : int
        At least 0. One seed gives every method the same dice.
    """
    of_dice, of_drops = (np.random.default_rng((seed, stream)) for stream in (0, 1))
    shape = REPLICATES, len(DICE)
    rolled = of_dice.binomial(ROLLS, MEASURED, shape) / ROLLS
    known = np.asarray(predicted, dtype=np.float64)
    if trials is not None:
        counts = np.asarray(trials)
        known = of_drops.binomial(counts, known, shape) / counts
    return float(np.sqrt(np.mean(np.square(known - rolled), axis=1)).std())


def sampling_noise() -> float:
    """Root mean square binomial error of the dice's frequencies; 0 to 1."""
    return float(np.sqrt(np.mean(MEASURED * (1.0 - MEASURED) / ROLLS)))
