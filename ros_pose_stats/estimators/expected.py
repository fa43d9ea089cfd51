"""What error to expect of an estimate, from what is known of this very part and scene.

A drop taken for an estimate errs by p (1 - p) in the square. Of how many drops an estimate is
worth is read off the part: by how far the methods are apart on it (where they agree they are
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
"""Mean square distance of two methods, over the mean p (1 - p), that logarithms start from."""

SHALLOWEST = 1e-3
"""Barrier of a pose, in radii, that logarithms start from."""

DECIDED = 1e-12
"""Mean p (1 - p) below which symmetry decides all."""


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
    single = single_drop_square(resting, probability)
    square = 0.0
    if single > DECIDED:
        inputs = _inputs(resting, probability, scene, known)
        square = single * math.exp(float(ERROR_FITS[name](inputs)))
    usual = np.square(USUAL_ERRORS[name])
    return ExpectedError(math.sqrt(square),
                         math.sqrt(np.interp(scene.restitution, USUAL_AT, usual)),
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


def error_inputs(resting: RestingPoses, probability: Array, scene: DropScene) -> Array:
    """Inputs (17,) of `ErrorFit`; the estimate must leave something undecided.

    Restitution and log of the drop height in radii; logs of the mean square distance of the
    estimate from MEAE, and of MEAE from NQSE, EAE and QSE, over the mean p (1 - p); logs of the
    number of poses and of the sum of p (1 - p); means of the logs of the poses' barriers in
    radii, weighed by p (1 - p) and by p; then body and corners as `split` has them. In p (1 - p)
    poses that symmetry makes equal count as one, shared evenly: symmetry makes no errors.
    """
    return _inputs(resting, probability, scene, _known(resting))


def single_drop_square(resting: RestingPoses, probability: Array) -> float:
    """Mean square error over the poses of a single drop: p (1 - p), symmetry allowed for."""
    return float(np.mean(_spread(resting, probability)))


def _known(resting: RestingPoses) -> Array:
    """Answers (3, P) of EAE, MEAE and QSE."""
    return np.stack([eae(resting), meae(resting), qse(resting)])


def _inputs(resting: RestingPoses, probability: Array, scene: DropScene, known: Array) -> Array:
    energy, around, toppled = known
    spread = _spread(resting, probability)
    apart = np.stack([probability - around, around - normalized(nonlinear(toppled)),
                      around - energy, around - toppled])
    far = np.log(np.mean(apart * apart, axis=1) / spread.mean() + LEAST_APART)
    depth = np.log(np.minimum(resting.clusters.barrier, 1.0) + SHALLOWEST)
    poses = (math.log(spread.size), math.log(spread.sum()), spread @ depth / spread.sum(),
             probability @ depth)
    return np.concatenate((scene_inputs(resting, scene), far, poses, body_inputs(resting),
                           corner_inputs(resting)))


def _spread(resting: RestingPoses, probability: Array) -> Array:
    """P (1 - p) of each pose; those that symmetry makes equal count as one, shared evenly."""
    group = np.array([pose.group for pose in resting.poses])
    together = np.bincount(group, probability)[group]
    size = np.bincount(group)[group]
    return np.asarray(together * np.maximum(1.0 - together, 0.0) / (size * size))
