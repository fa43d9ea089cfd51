"""What error to expect of an estimate: from how far the methods are apart on this very part.

Where the estimators agree they are mostly right, and where they part company at least one of
them is wrong. The expected square error is a sum of squared distances between methods and of
p (1 - p), with weights fitted to the reference datasets at three restitutions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.poses import RestingPoses
from .energy_absorption import eae, meae
from .error_weights import ERROR_AT, ERROR_WEIGHTS, USUAL_ERRORS
from .estimator import Array, normalized
from .quasi_static import nonlinear, qse

UNUSUAL = 2.0
"""Expected error over the usual one from which on the methods disagree."""


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
                   restitution: float) -> ExpectedError:
    """Expected error of one estimate.

    Between the restitutions that were measured its square is interpolated straight, beyond
    them it is that of the nearest one.

    Parameters
    ----------
    name : str
        Of the method.
    resting : RestingPoses
    probability : (P,) array
        Its estimate, in the order of `index`.
    restitution : float
    """
    if name not in ERROR_WEIGHTS:
        return ExpectedError(math.nan, math.nan, math.nan)
    known = np.stack([eae(resting), meae(resting), qse(resting)])
    squares = np.asarray(ERROR_WEIGHTS[name]) @ _terms(resting, probability, known)
    usual = np.square(USUAL_ERRORS[name])
    return ExpectedError(math.sqrt(np.interp(restitution, ERROR_AT, squares)),
                         math.sqrt(np.interp(restitution, ERROR_AT, usual)),
                         float(np.ptp(known, axis=0).max()))


def pose_errors(resting: RestingPoses, probability: Array, expected: float) -> Array:
    """Expected error (P,) of each pose, with the root mean square `expected`.

    It is shared as p (1 - p) is, which is what drops would have; poses that symmetry makes
    equal share what they err together. Where symmetry decides all, nothing errs.
    """
    spread = _spread(resting, probability)
    total = float(spread.sum())
    if not total > 0.0:
        return np.full(spread.shape, 0.0 if math.isfinite(expected) else math.nan)
    return np.asarray(expected * np.sqrt(spread * (spread.size / total)))


def error_terms(resting: RestingPoses, probability: Array) -> Array:
    """Terms (5,) of the expected square error, each a mean over the poses.

    The estimate against MEAE, MEAE against NQSE, EAE and QSE, and p (1 - p). In the last one,
    poses that symmetry makes equal count as one, shared evenly: symmetry makes no errors.
    """
    known = np.stack([eae(resting), meae(resting), qse(resting)])
    return _terms(resting, probability, known)


def _terms(resting: RestingPoses, probability: Array, known: Array) -> Array:
    """`error_terms` from the answers (3, P) of EAE, MEAE and QSE."""
    energy, around, toppled = known
    apart = np.stack([probability - around, around - normalized(nonlinear(toppled)),
                      around - energy, around - toppled])
    return np.append(np.mean(apart * apart, axis=1), np.mean(_spread(resting, probability)))


def _spread(resting: RestingPoses, probability: Array) -> Array:
    """P (1 - p) of each pose; those that symmetry makes equal count as one, shared evenly."""
    group = np.array([pose.group for pose in resting.poses])
    together = np.bincount(group, probability)[group]
    size = np.bincount(group)[group]
    return np.asarray(together * np.maximum(1.0 - together, 0.0) / (size * size))
