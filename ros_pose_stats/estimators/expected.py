"""The expected error of an estimate, from features of this very part and scene.

The share of a pose in n drops has the square error p (1 - p) / n. How many drops an estimate is
worth depends on how far the methods are apart on this part (where they agree they are mostly
right), on the number of its poses and their depths, on inertia and corners, restitution and drop
height. The function of these (`ErrorFit`) was fitted to drops of many families of parts.
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
"""Ratio of the expected error to the usual one from which on METHODS_DISAGREE warns."""

LEAST_SHARE = 0.05
"""Least expected square error, as a share of the square distance from MEAE. It matters where a
method is certain and others are not, which is rare in the samples of the fit."""

DECIDED = 1e-12
"""Mean error scale below which symmetry alone decides the probabilities."""


class ExpectedError(NamedTuple):
    """Root mean square error over a part's poses, fractions; NaN for unmeasured methods.

    Attributes
    ----------
    here : float
        Of this estimate, on this part.
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

    Beyond the restitutions, drop heights and shapes of the samples it is the error of the
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
    scale = error_scale(resting, probability, known)
    mean_scale, square = float(scale.mean()), 0.0
    if mean_scale > DECIDED:
        inputs = error_inputs(resting, probability, scene, known, scale)
        square = max(mean_scale * math.exp(float(ERROR_FITS[name](inputs))),
                     LEAST_SHARE * float(np.mean(np.square(probability - known[1]))))
    return ExpectedError(math.sqrt(square), math.sqrt(_usual_square(name, scene.restitution)),
                         float(np.ptp(known, axis=0).max()))


def best_method(restitution: float) -> str:
    """The estimator that errs least on the reference parts at a restitution."""
    return min(USUAL_ERRORS, key=lambda name: _usual_square(name, restitution))


def explain_best(method: str) -> str:
    """Say why the best estimator answers where no error was asked for."""
    return (f"{method} is expected to be the most accurate estimate of this part, and no target "
            f"error was asked for.")


def _usual_square(name: str, restitution: float) -> float:
    return float(np.interp(restitution, USUAL_AT, np.square(USUAL_ERRORS[name])))


def pose_errors(resting: RestingPoses, probability: Array, expected: float) -> Array:
    """Expected error (P,) of each pose, with the root mean square `expected`.

    Its square is shared among the poses in proportion to p (1 - p), as for drops; poses that
    symmetry makes equal share the error of their sum. Where symmetry decides all, no pose has an
    error; where an estimate is certain and may be wrong, all poses have the same.
    """
    spread = single_drop(resting, probability)
    total = float(spread.sum())
    if not total > DECIDED:
        return np.full(spread.shape, expected)
    return np.asarray(expected * np.sqrt(spread * (spread.size / total)))
