"""The expected error of an estimate, from features of this very part and scene.

The share of a pose in n drops has the square error p (1 - p) / n. How many drops an estimate is
worth depends on how far the methods are apart on this part (where they agree they are mostly
right), on the number of its poses and their depths, on inertia and corners, restitution and drop
height. The function of these (`ErrorFit`) was fitted to drops of many families of parts. Beyond
the parts and scenes of the fit the error grows.

Of parts of which the same is expected some are estimated better than others. That scatter is
fitted too, and gives the intervals of poses and the bound that all of them keep together.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ..records import Array, DropScene, Index, statistics
from ..resting.poses import RestingPoses
from ..statistics.errors import DEFAULT_LEVEL, largest_error, root_mean_square
from . import fitted, published

UNUSUAL = 2.0  # ratio of the expected error to the usual one from which on METHODS_DISAGREE warns

LEAST_SHARE = 0.05
"""Least expected square error, as a share of the square distance from MEAE. It matters where a
method is certain and others are not, which is rare in the samples of the fit."""

DECIDED = 1e-12  # mean error scale below which symmetry alone decides the probabilities

GROWTH = 10.0
"""Beyond the range of an input in the fit, by a tenth of that range, the error doubles."""

OUTSIDE = 0.02  # share of the range from which on OUTSIDE_FIT warns

LOPSIDED = 50.0
"""By how much the odds of a pose may grow by rolling, over how far the centre of mass lies beside
the axis in radii; chosen so that told errors are true (docs/decisions.md)."""

MOST_LOPSIDED = 0.12  # offset in radii beyond which they grow no more
RARE = 0.2  # share of a pose below which its odds may grow by more, with the root of the ratio
ROCKING = (
    0.55  # error over the scatter of curves among poses; fitted (docs/decisions.md)
)
SMALL = 1e-3  # an error far from the ends of what a probability can be off by

SCATTER_AT = np.linspace(-3.0, 3.0, 13)
"""Where the scatter of square errors over parts is looked at, in its standard deviations."""


class ExpectedError(NamedTuple):
    """Errors of one estimate, as fractions; NaN for unmeasured methods."""

    here: float  # root mean square over the part's poses, of this estimate on this part
    usual: float  # root mean square of the method on the reference datasets
    apart: float  # largest difference of two of EAE, MEAE and QSE for a pose
    each: Array  # (P,); of each pose, with the root mean square `here`
    reach: float = math.nan  # half of the 90 % interval of a pose, in its error
    # bound that the errors of all poses keep together with 90 % confidence
    largest: float = math.nan
    # how far part and scene lie beyond those of the fit, in ranges of its inputs
    outside: float = 0.0
    # root mean square of what lopsided parts may gain by rolling; `here` has it
    rolled: float = 0.0

    def shares(self, probability: Array) -> statistics.Shares:
        """Probabilities (P,) with their errors, and 90 % intervals cut at 0 and 1."""
        away = self.reach * self.each
        return statistics.Shares(
            probability,
            np.maximum(probability - away, 0.0),
            np.minimum(probability + away, 1.0),
            self.each,
            np.zeros(len(probability), dtype=np.int64),
            self.here,
            self.largest,
        )

    @property
    def unknown(self) -> bool:
        """Whether nobody has measured how right the method is on such a part or scene."""
        return self.outside > OUTSIDE or self.rolled > self.measured

    @property
    def measured(self) -> float:
        """Root mean square of a part that is not lopsided."""
        return math.sqrt(max(self.here * self.here - self.rolled * self.rolled, 0.0))

    @property
    def unusual(self) -> bool:
        """Whether the methods disagree on this part by far more than they usually do."""
        return self.measured > UNUSUAL * self.usual


def expected_error(
    name: str,
    resting: RestingPoses,
    probability: Array,
    scene: DropScene,
    fits: dict[str, fitted.ErrorFit] = fitted.ERROR_FITS,
) -> ExpectedError:
    """Expected error of one estimate (P,), by index."""
    if name not in fits:
        return ExpectedError(
            math.nan, math.nan, math.nan, np.full(probability.shape, math.nan)
        )
    fit = fits[name]
    known = fitted.known_answers(resting)
    scale = fitted.error_scale(resting, probability, known)
    mean_scale = float(scale.mean())
    square = 0.0
    outside = 0.0
    if mean_scale > DECIDED:
        inputs = fitted.error_inputs(resting, probability, scene, known, scale)
        outside = fit.outside(inputs)
        square = max(
            mean_scale * math.exp(float(fit(inputs))),
            LEAST_SHARE * float(np.mean(np.square(probability - known[1]))),
        )
    here = math.sqrt(square) * (1.0 + GROWTH * outside)
    # Shared as for drops, in proportion to p (1 - p); where symmetry decides all, no pose has an
    # error, and where an estimate is certain and may be wrong, all have the same.
    spread = fitted.single_drop(resting, probability)
    total = float(spread.sum())
    each = (
        here * np.sqrt(spread * (spread.size / total))
        if total > DECIDED
        else np.full(spread.shape, here)
    )
    by_rolling = rolling_errors(resting, probability)
    for beside in (rocking_errors(resting, probability), by_rolling):
        if beside.any():
            here = math.hypot(here, root_mean_square(beside))
            each = np.hypot(each, beside)
    here = min(here, 1.0)
    each = np.minimum(each, 1.0)
    return ExpectedError(
        here,
        math.sqrt(_usual_square(name, scene.restitution)),
        float(np.ptp(known, axis=0).max()),
        each,
        single_reach(fit.scatter),
        largest_of(each, resting.group, fit),
        outside,
        root_mean_square(by_rolling),
    )


def rocking_errors(resting: RestingPoses, probability: Array) -> Array:
    """Error (P,) of parts that rock on curves which are no full turn.

    There a part keeps its energy, and a flat takes it in one blow. No estimator knows how often,
    so its error grows with the scatter of curves over the poses that the part may come to rest in.
    """
    curved = np.square(resting.curves[0])
    return np.asarray(
        ROCKING * np.sqrt(probability) * np.abs(curved - probability @ curved)
    )


def rolling_errors(resting: RestingPoses, probability: Array) -> Array:
    """Error (P,) of lopsided parts: those that roll with the centre of mass beside the axis.

    Without friction nothing turns a part about the vertical, so it cannot lie down before it has
    lost the spin of its roll. No estimator knows of it. The error is what the probabilities would
    change by if the odds of poses that roll so grew.
    """
    offset = np.minimum(resting.axis_offsets, MOST_LOPSIDED)
    if not offset.any():
        return np.zeros(probability.shape)
    gain = LOPSIDED * offset * np.sqrt(probability * np.maximum(probability, RARE))
    return np.asarray(np.abs(published.normalized(probability + gain) - probability))


def largest_of(
    errors: Array, group: Index, fit: fitted.ErrorFit, noise: Array | None = None
) -> float:
    """Bound that errors of poses keep together with 90 % confidence, by the scatter over parts.

    Poses of one `group` share their error; `noise`: variances of the drops to compare with.
    """
    weight, factor = scatter(fit.scatter)
    if noise is not None:  # each pose has its own
        return largest_error(
            np.sqrt(np.square(factor[:, None] * errors) + noise),
            DEFAULT_LEVEL,
            weight=weight,
        )
    size = np.bincount(group)
    whole = np.zeros(size.shape[0])
    whole[group] = errors
    return largest_error(
        factor[:, None] * whole * size, DEFAULT_LEVEL, weight=weight, size=size
    )


@cache
def single_reach(width: float) -> float:
    """Bound that the error of one pose keeps with 90 % confidence, in its expected error."""
    weight, factor = scatter(width)
    return largest_error(SMALL * factor[:, None], DEFAULT_LEVEL, weight=weight) / SMALL


@cache
def scatter(width: float) -> tuple[Array, Array]:
    """Weights and errors over the expected one (13,), mean square 1, of parts alike in that."""
    weight = np.exp(-0.5 * SCATTER_AT * SCATTER_AT)
    square = np.exp(width * SCATTER_AT)
    weight /= weight.sum()
    return weight, np.sqrt(square / (weight @ square))


def best_method(restitution: float) -> str:
    """The estimator that errs least on the reference parts at a restitution."""
    return min(fitted.USUAL_ERRORS, key=lambda name: _usual_square(name, restitution))


def _usual_square(name: str, restitution: float) -> float:
    return float(
        np.interp(restitution, fitted.USUAL_AT, np.square(fitted.USUAL_ERRORS[name]))
    )
