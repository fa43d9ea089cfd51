"""What error to expect of an estimate, from what is known of this very part and scene.

A drop taken for an estimate errs by p (1 - p) in the square. How many drops an estimate is worth
is read off the part: by how far the methods are apart on it (where they agree they are
mostly right), how many poses there are and how shallow, inertia and corners, restitution and drop
height. The function (`ErrorFit`) was fitted to drops of many families of parts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..records import DropScene
from ..resting.poses import RestingPoses
from .fitted_inputs import error_inputs, error_scale, known_answers, single_drop
from .fitted_weights import ERROR_FITS, USUAL_AT, USUAL_ERRORS
from .solid_angles import Array

UNUSUAL = 2.0
"""Expected error over the usual one from which on the methods disagree."""

LEAST_SHARE = 0.05
"""Of the square distance from MEAE: at least so much of it is taken to be the estimate's error.
It matters where a method is certain of what others are not, which the fit has seldom seen."""

DECIDED = 1e-12
"""Doubt below which symmetry decides all."""


class ExpectedError(NamedTuple):
    """Root mean square error over a part's poses, fractions; NaN for unmeasured methods.

    Attributes
    ----------
    here : float
        Of this part.
    usual : float
        Of the method on the reference datasets.
    apart : float
        Largest difference of two of EAE, MEAE and QSE for a pose.
    """

    here: float
    usual: float
    apart: float

    @property
    def unusual(self) -> bool:
        """Whether the methods disagree on this part by far more than they usually do."""
        return self.here > UNUSUAL * self.usual


def expected_error(name: str, resting: RestingPoses, probability: Array,
                   scene: DropScene) -> ExpectedError:
    """Expected error of one estimate.

    Beyond the restitutions, drop heights and shapes that were measured it is that of the
    nearest ones.

    Parameters
    ----------
    name : str
        Of the method.
    resting : RestingPoses
    probability : (P,) array
        Its estimate, in the order of `index`.
    scene : DropScene
    """
    if name not in ERROR_FITS:
        return ExpectedError(math.nan, math.nan, math.nan)
    known = known_answers(resting)
    unsure = error_scale(resting, probability, known)
    doubt, square = float(unsure.mean()), 0.0
    if doubt > DECIDED:
        inputs = error_inputs(resting, probability, scene, known, unsure)
        square = max(doubt * math.exp(float(ERROR_FITS[name](inputs))),
                     LEAST_SHARE * float(np.mean(np.square(probability - known[1]))))
    return ExpectedError(math.sqrt(square), math.sqrt(_usual_square(name, scene.restitution)),
                         float(np.ptp(known, axis=0).max()))


def best_method(restitution: float) -> str:
    """The estimator that errs least on the reference parts at a restitution."""
    return min(USUAL_ERRORS, key=lambda name: _usual_square(name, restitution))


def explain_best(method: str) -> str:
    """Why the best estimate answers where no error was asked for."""
    return (f"{method} is expected to be the most accurate estimate of this part, and no target "
            f"error was asked for.")


def _usual_square(name: str, restitution: float) -> float:
    return float(np.interp(restitution, USUAL_AT, np.square(USUAL_ERRORS[name])))


def pose_errors(resting: RestingPoses, probability: Array, expected: float) -> Array:
    """Expected error (P,) of each pose, with the root mean square `expected`.

    It is shared as p (1 - p) is, which is what drops would have; poses that symmetry makes
    equal share what they err together. Where symmetry decides all, nothing errs; where an
    estimate is certain and may be wrong, all poses may err alike.
    """
    spread = single_drop(resting, probability)
    total = float(spread.sum())
    if not total > DECIDED:
        return np.full(spread.shape, expected)
    return np.asarray(expected * np.sqrt(spread * (spread.size / total)))
