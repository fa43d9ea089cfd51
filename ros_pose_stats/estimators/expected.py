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

from ..geometry.poses import RestingPoses
from ..records import DropScene
from .energy_absorption import eae, meae
from .error_weights import ERROR_FITS, USUAL_AT, USUAL_ERRORS
from .estimator import Array, normalized
from .quasi_static import nonlinear, qse
from .scene_inputs import body_inputs, corner_inputs, scene_inputs

UNUSUAL = 2.0
"""Expected error over the usual one from which on the methods disagree."""

LEAST_APART = 1e-3
"""Mean square distance of two methods, over `doubt`, that logarithms start from."""

SHALLOWEST = 1e-3
"""Barrier of a pose, in radii, that logarithms start from."""

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
    known = _known(resting)
    unsure, square = _doubt(resting, probability, known), 0.0
    if unsure > DECIDED:
        inputs = _inputs(resting, probability, scene, known)
        square = max(unsure * math.exp(float(ERROR_FITS[name](inputs))),
                     LEAST_SHARE * float(np.mean(np.square(probability - known[1]))))
    usual = np.square(USUAL_ERRORS[name])
    return ExpectedError(math.sqrt(square),
                         math.sqrt(np.interp(scene.restitution, USUAL_AT, usual)),
                         float(np.ptp(known, axis=0).max()))


def pose_errors(resting: RestingPoses, probability: Array, expected: float) -> Array:
    """Expected error (P,) of each pose, with the root mean square `expected`.

    It is shared as p (1 - p) is, which is what drops would have; poses that symmetry makes
    equal share what they err together. Where symmetry decides all, nothing errs; where an
    estimate is certain and may be wrong, all poses may err alike.
    """
    spread = _spread(resting, probability)
    total = float(spread.sum())
    if not total > DECIDED:
        return np.full(spread.shape, expected)
    return np.asarray(expected * np.sqrt(spread * (spread.size / total)))


def error_inputs(resting: RestingPoses, probability: Array, scene: DropScene) -> Array:
    """Inputs (17,) of `ErrorFit`; the estimate must leave something undecided.

    Restitution and log of the drop height in radii; logs of the mean square distance of the
    estimate from MEAE, and of MEAE from NQSE, EAE and QSE, over the doubt; logs of the number of
    poses and of the doubt of all poses together; means of the logs of the poses' barriers in
    radii, weighed by the poses' doubt and by p; then body and corners as `split` has them.
    """
    return _inputs(resting, probability, scene, _known(resting))


def doubt(resting: RestingPoses, probability: Array) -> float:
    """Mean over the poses of p (1 - p) and of the square distance from MEAE.

    The first is the square error of a single drop, the second is for an estimate that is
    certain and wrong. Poses that symmetry makes equal count as one in p (1 - p), shared evenly:
    symmetry makes no errors.
    """
    return _doubt(resting, probability, _known(resting))


def _doubt(resting: RestingPoses, probability: Array, known: Array) -> float:
    return float(np.mean(_doubts(resting, probability, known)))


def _doubts(resting: RestingPoses, probability: Array, known: Array) -> Array:
    """Of each pose (P,)."""
    return np.asarray(_spread(resting, probability) + np.square(probability - known[1]))


def _known(resting: RestingPoses) -> Array:
    """Answers (3, P) of EAE, MEAE and QSE."""
    return np.stack([eae(resting), meae(resting), qse(resting)])


def _inputs(resting: RestingPoses, probability: Array, scene: DropScene, known: Array) -> Array:
    energy, around, toppled = known
    unsure = _doubts(resting, probability, known)
    apart = np.stack([probability - around, around - normalized(nonlinear(toppled)),
                      around - energy, around - toppled])
    far = np.log(np.mean(apart * apart, axis=1) / unsure.mean() + LEAST_APART)
    depth = np.log(np.minimum(resting.clusters.barrier, 1.0) + SHALLOWEST)
    poses = (math.log(unsure.size), math.log(unsure.sum()), unsure @ depth / unsure.sum(),
             probability @ depth)
    return np.concatenate((scene_inputs(resting, scene), far, poses, body_inputs(resting),
                           corner_inputs(resting)))


def _spread(resting: RestingPoses, probability: Array) -> Array:
    """P (1 - p) of each pose; those that symmetry makes equal count as one, shared evenly."""
    group = np.array([pose.group for pose in resting.poses])
    together = np.bincount(group, probability)[group]
    size = np.bincount(group)[group]
    return np.asarray(together * np.maximum(1.0 - together, 0.0) / (size * size))
