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

"""The expected error of an estimate, from features of this very part and scene.

The share of a pose in n drops has the square error p (1 - p) / n. How many drops an
estimate is worth depends on how far the methods are apart on this part (where they
agree they are mostly right), on the number of its poses and their depths, on inertia
and corners, restitution and drop height. The function of these (`ErrorFit`) was fitted
to drops of many families of parts. Beyond the parts and scenes of the fit the error
grows.

Of parts of which the same is expected some are estimated better than others. That
scatter is fitted too, and gives the intervals of poses and the bound that all of them
keep together.
"""

import math
from collections.abc import Sequence
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from ..records import Array, DropScene, Index
from ..records.shares import Shares
from ..resting.poses import RestingPoses
from ..statistics.errors import DEFAULT_LEVEL, largest_error, largest_errors
from . import fitted

UNUSUAL_RATIO = 2.0
"""Expected error over the usual one, from which on METHODS_DISAGREE warns."""

SMALLEST_SHARE = 0.05
"""Least expected square error, as a share of the square distance from MEAE. It matters
where a method is certain and others are not, which is rare in the samples of the
fit."""

SYMMETRY_SCALE = 1e-12  # mean error scale below which symmetry alone decides

EXTRAPOLATION_GROWTH = 10.0
"""Beyond the range of an input in the fit, by a tenth of that range, the error
doubles."""

EXTRAPOLATION_WARNING = 0.02  # share of the range from which on OUTSIDE_FIT warns

ROLLING_GAIN = 50.0
"""By how much the odds of a pose may grow by rolling, over how far the centre of mass
lies beside the axis in radii; chosen so that told errors are true
(docs/decisions.md)."""

LARGEST_OFFSET = 0.12  # offset in radii beyond which they grow no more
RARE_SHARE = 0.2
"""Share of a pose below which its odds may grow by more, with the root of the ratio."""

ROCKING_FACTOR = 0.55
"""Error over the scatter of curves among poses; fitted (docs/decisions.md)."""
SMALL_ERROR = 1e-3  # an error far from the ends of what a probability can be off by

SCATTER_NODES = np.linspace(-3.0, 3.0, 13)
"""Where the scatter of square errors over parts is looked at, in its standard
deviations."""


class ExpectedError(NamedTuple):
    """Errors of one estimate, as fractions; NaN for unmeasured methods."""

    part_error: float  # root mean square over the poses, of this very estimate
    usual_error: float  # root mean square of the method on the reference datasets
    disagreement: float  # largest difference of two of EAE, MEAE and QSE for a pose
    pose_errors: Array  # (P,); of each pose, with the root mean square `part_error`
    reach: float = math.nan  # half of the 90 % interval of a pose, in its error
    # bound that the errors of all poses keep together with 90 % confidence
    largest_error: float = math.nan
    # how far part and scene lie beyond those of the fit, in ranges of its inputs
    extrapolation: float = 0.0
    # root mean square of what lopsided parts may gain by rolling, part of `part_error`
    rolling_error: float = 0.0

    def shares(self, probability: Array) -> Shares:
        """Probabilities (P,) with their errors, and 90 % intervals cut at 0 and 1."""
        half_width = self.reach * self.pose_errors
        return Shares(
            probability,
            np.maximum(probability - half_width, 0.0),
            np.minimum(probability + half_width, 1.0),
            self.pose_errors,
            np.zeros(len(probability), dtype=np.int64),
            self.part_error,
            self.largest_error,
        )

    @property
    def is_unmeasured(self) -> bool:
        """Whether the method was never measured on such a part or scene."""
        return (
            self.extrapolation > EXTRAPOLATION_WARNING
            or self.rolling_error > self.measured_error
        )

    @property
    def measured_error(self) -> float:
        """Root mean square of a part that is not lopsided."""
        rolling_square = self.rolling_error * self.rolling_error
        return math.sqrt(max(self.part_error * self.part_error - rolling_square, 0.0))

    @property
    def is_unusual(self) -> bool:
        """Whether the methods disagree on this part far more than usually."""
        return self.measured_error > UNUSUAL_RATIO * self.usual_error


def unknown_error(probability: Array) -> ExpectedError:
    """Of probabilities (P,) of which nobody knows how wrong they are."""
    return ExpectedError(
        math.nan, math.nan, math.nan, np.full(probability.shape, math.nan)
    )


def expected_error(
    name: str,
    resting: RestingPoses,
    probability: Array,
    scene: DropScene,
    fits: dict[str, fitted.ErrorFit] = fitted.ERROR_FITS,
) -> ExpectedError:
    """Expected error of one estimate (P,), by index."""
    return expected_errors([name], resting, probability[None], scene, fits)[0]


def expected_errors(
    names: Sequence[str],
    resting: RestingPoses,
    probability: Array,
    scene: DropScene,
    fits: dict[str, fitted.ErrorFit] = fitted.ERROR_FITS,
) -> list[ExpectedError]:
    """Expected errors of estimates (M, P) by several methods, by index."""
    if not all(name in fits for name in names):
        return [
            expected_error(name, resting, estimate, scene, fits)
            if name in fits
            else unknown_error(estimate)
            for name, estimate in zip(names, probability, strict=True)
        ]
    if fits is fitted.ERROR_FITS:
        chosen_fits = _own_fits(tuple(names))
    else:
        chosen_fits = fitted.stack_fits([fits[name] for name in names])
    scatters: list[float] = chosen_fits.scatter.tolist()
    answers = fitted.reference_answers(resting)
    measured_errors, extrapolation = _measured_errors(
        chosen_fits, resting, probability, scene, answers
    )

    # Shared as for drops, in proportion to p (1 - p); where symmetry decides all, no
    # pose has an error, and where an estimate is certain and may be wrong, all have the
    # same.
    spread = fitted.single_drop_variance(resting, probability)
    total_spread = spread.sum(axis=1, keepdims=True)
    is_open = total_spread > SYMMETRY_SCALE
    evenness = spread.shape[1] / np.where(is_open, total_spread, 1.0)
    relative_spread = np.where(is_open, spread * evenness, 1.0)
    pose_errors = measured_errors[:, None] * np.sqrt(relative_spread)

    part_errors = measured_errors.tolist()
    rolling = rolling_errors(resting, probability)
    for extra_errors in (rocking_errors(resting, probability), rolling):
        if extra_errors.any():
            part_errors = list(map(math.hypot, part_errors, _row_means(extra_errors)))
            pose_errors = np.hypot(pose_errors, extra_errors)
    pose_errors = np.minimum(pose_errors, 1.0)
    rolling_means = _row_means(rolling)
    disagreement = float(np.ptp(answers, axis=0).max())
    bounds = bound_pose_errors(pose_errors, resting.group, scatters)
    return [
        ExpectedError(
            min(part_errors[k], 1.0),
            math.sqrt(_usual_square(name, scene.restitution)),
            disagreement,
            pose_errors[k],
            interval_reach(scatters[k]),
            bounds[k],
            extrapolation[k],
            rolling_means[k],
        )
        for k, name in enumerate(names)
    ]


@lru_cache
def _own_fits(names: tuple[str, ...]) -> fitted.StackedFits:
    """Fits of the package, one below the other."""
    return fitted.stack_fits([fitted.ERROR_FITS[name] for name in names])


def _measured_errors(
    fits: fitted.StackedFits,
    resting: RestingPoses,
    probability: Array,
    scene: DropScene,
    answers: Array,
) -> tuple[Array, list[float]]:
    """Root mean square (M,) as on the parts of the fit, 0 where symmetry decides.

    How far each lies beyond the fit, too.
    """
    scale = fitted.error_scale(resting, probability, answers)
    poses = scale.shape[1]
    mean_scale = scale.sum(axis=1) / poses
    is_open = mean_scale > SYMMETRY_SCALE
    if not is_open.any():
        return np.zeros(len(scale)), [0.0] * len(scale)
    inputs = fits.lowest.copy()  # within the fit, where symmetry decides
    inputs[is_open] = fitted.error_inputs(
        resting, probability[is_open], scene, answers, scale[is_open]
    )
    logarithms, extrapolation = fits(inputs)
    distance = np.square(probability - answers[1]).sum(axis=1) / poses
    factors = [math.exp(logarithm) for logarithm in logarithms.tolist()]
    square_errors = np.maximum(mean_scale * factors, SMALLEST_SHARE * distance)
    growth = 1.0 + EXTRAPOLATION_GROWTH * extrapolation
    errors = np.where(is_open, np.sqrt(square_errors) * growth, 0.0)
    return errors, extrapolation.tolist()


def _row_means(values: Array) -> list[float]:
    """Root mean squares of rows (M, P)."""
    sums = (values * values).sum(axis=1)
    means: list[float] = np.sqrt(sums / values.shape[1]).tolist()
    return means


def rocking_errors(resting: RestingPoses, probability: Array) -> Array:
    """Errors (M, P) of parts that rock on curves which are no full turn.

    There a part keeps its energy, and a flat takes it in one blow. No estimator knows
    how often, so its error grows with the scatter of curves over the poses that the
    part may come to rest in.
    """
    curvature = np.square(resting.curves[0])
    mean_curvature = fitted.scalar_products(probability, curvature)
    return np.asarray(
        ROCKING_FACTOR
        * np.sqrt(probability)
        * np.abs(curvature - mean_curvature[:, None])
    )


def rolling_errors(resting: RestingPoses, probability: Array) -> Array:
    """Errors (M, P) of parts that roll with the centre of mass beside the axis.

    Without friction nothing turns a part about the vertical, so it cannot lie down
    before it has lost the spin of its roll. No estimator knows of it. The error is what
    the probabilities would change by if the odds of poses that roll so grew.
    """
    offset = np.minimum(resting.axis_offsets, LARGEST_OFFSET)
    if not offset.any():
        return np.zeros(probability.shape)
    gain = (
        ROLLING_GAIN
        * offset
        * np.sqrt(probability * np.maximum(probability, RARE_SHARE))
    )
    grown = probability + gain
    change: Array = grown / grown.sum(axis=1, keepdims=True) - probability
    return np.abs(change)


def bound_pose_errors(
    errors: Array, group: Index, scatters: Sequence[float]
) -> list[float]:
    """Bounds that errors (M, P) of poses keep together with 90 % confidence.

    Poses of one `group` share their error; `scatters` (M,) as in `ErrorFit`.
    """
    mixtures = [scatter_mixture(scatter) for scatter in scatters]
    factors = np.array([factor for _, factor in mixtures])
    unit_size = np.bincount(group)
    unit_errors = np.zeros((len(errors), unit_size.shape[0]))
    unit_errors[:, group] = errors
    return largest_errors(
        factors[:, :, None] * unit_errors[:, None, :] * unit_size,
        DEFAULT_LEVEL,
        weight=mixtures[0][0],  # of all
        size=unit_size,
    )


@cache
def interval_reach(width: float) -> float:
    """Bound of a pose's error with 90 % confidence, over its expected error."""
    weight, factor = scatter_mixture(width)
    return (
        largest_error(SMALL_ERROR * factor[:, None], DEFAULT_LEVEL, weight=weight)
        / SMALL_ERROR
    )


@cache
def scatter_mixture(width: float) -> tuple[Array, Array]:
    """Weights and errors (13,) of parts with one expected error, mean square 1."""
    weight = np.exp(-0.5 * SCATTER_NODES * SCATTER_NODES)
    square = np.exp(width * SCATTER_NODES)
    weight /= weight.sum()
    return weight, np.sqrt(square / (weight @ square))


@lru_cache
def best_method(restitution: float) -> str:
    """The estimator that errs least on the reference parts at a restitution."""
    return min(fitted.USUAL_ERRORS, key=lambda name: _usual_square(name, restitution))


@lru_cache
def _usual_square(name: str, restitution: float) -> float:
    return float(
        np.interp(restitution, fitted.USUAL_AT, np.square(fitted.USUAL_ERRORS[name]))
    )
