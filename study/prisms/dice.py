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

"""How far methods are from the dice that Budden rolled."""

import numpy as np
from numpy.typing import ArrayLike

from lab.bodies.dice import DICE
from ros_pose_stats.core.records import Array, Index

REPLICATES = 4000
"""Replicates of the bootstrap; they give a standard error to about a hundredth of
itself.
"""

MEASURED: Array = np.array([die.on_sides for die in DICE])
ROLLS: Index = np.array([die.rolls for die in DICE])


def root_mean_square(predicted: ArrayLike) -> float:
    """Root mean square difference of a prediction (15,) from the dice; 0 to 1."""
    return float(np.sqrt(np.mean(np.square(np.asarray(predicted) - MEASURED))))


def standard_error(
    predicted: ArrayLike, trials: ArrayLike | None = None, *, seed: int
) -> float:
    """Standard error of `root_mean_square` by parametric bootstrap.

    The dice are rolled again, binomially at their measured frequencies, and a
    prediction that was itself counted is counted again. The answer is the standard
    deviation of the root mean square over these replicates.

    Parameters
    ----------
    predicted : (15,) array
        Probability of the four sides of each die.
    trials : (15,) array of int, optional
        Drops behind each prediction; none for an estimator, which has no error of
        sampling.
    seed : int
        At least 0. One seed gives every method the same dice.
    """
    of_dice, of_drops = (np.random.default_rng((seed, stream)) for stream in (0, 1))
    shape = REPLICATES, len(DICE)
    rolled = of_dice.binomial(ROLLS, MEASURED, shape) / ROLLS
    shares = np.asarray(predicted, dtype=np.float64)
    if trials is not None:
        counts = np.asarray(trials)
        shares = of_drops.binomial(counts, shares, shape) / counts
    return float(np.sqrt(np.mean(np.square(shares - rolled), axis=1)).std())


def sampling_noise() -> float:
    """Root mean square binomial error of the dice's frequencies; 0 to 1."""
    return float(np.sqrt(np.mean(MEASURED * (1.0 - MEASURED) / ROLLS)))
