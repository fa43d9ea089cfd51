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

"""Whether counts differ by more than chance: Pearson's test, rare bins pooled."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc

from ...base.errors import RequestError
from ..records import Array, Index

SMALLEST_EXPECTED = 5.0
"""Expected count below which a bin is pooled: the usual rule (Cochran 1954).

Below it the statistic no longer follows the chi-square distribution.
"""

ROUNDING = 1e-9


@dataclass(frozen=True)
class ChiSquare:
    """Outcome of a test."""

    statistic: float  # NaN where there are too few counts for two bins
    degrees_of_freedom: int  # bins less one; 0 where there are too few counts
    # chance of a statistic this large if the counts do follow the prediction; NaN where
    # there are too few, or where the error of the prediction is not known
    p_value: float
    bins: int  # that were compared, after pooling
    pooled: int  # bins that were put together into one; 0 for none

    @property
    def has_too_few_counts(self) -> bool:
        """Whether the counts do not suffice for a test."""
        return self.degrees_of_freedom == 0


SMALLEST_EXPECTED_SHARE = 1e-4  # the sum of squares hardly feels a rarer one


def distance_chance(square: Array, shares: Array, counts: ArrayLike) -> Array:
    """Chance of shares that lie as far or farther from the expected ones.

    Parameters
    ----------
    square : array
        Sums of the squares of the differences.
    shares : array (..., G)
        Expected.
    counts : array
        As many as whose shares scatter so.

    Returns
    -------
    array
        By a gamma distribution with the moments of the sum (Satterthwaite, 1946).
    """
    expected = np.maximum(shares, SMALLEST_EXPECTED_SHARE)
    expected = expected / expected.sum(axis=-1, keepdims=True)
    second = np.square(expected).sum(axis=-1)
    third = (expected**3).sum(axis=-1)
    mean = 1.0 - second  # of the sum, times the counts
    half_variance = second - 2.0 * third + np.square(second)
    return np.asarray(
        chdtrc(
            mean**2 / half_variance, square * np.asarray(counts) * mean / half_variance
        )
    )


def goodness_of_fit(
    counts: ArrayLike,
    probabilities: ArrayLike,
    errors: ArrayLike | None = None,
    unit: ArrayLike | None = None,
) -> ChiSquare:
    """Compare counts with probabilities, exact ones or some with an error of their own.

    Errors are taken to be correlated as those of shares are: then the inverse of the
    covariance parts into a sum over units and one over the bins within each. A bin of
    probability 0 is pooled if something was counted there, else left out; `unit`: bins
    of one number share their error.
    """
    count = _check_row("counts", counts)
    weight = _check_row("probabilities", probabilities)
    if count.shape != weight.shape or not weight.sum() > 0.0:
        raise RequestError(
            "as many probabilities as counts, not all 0",
            f"{weight.size} of sum {weight.sum():g} for {count.size} counts",
            "number both by the same poses",
        )
    expected = weight * (count.sum() / weight.sum())
    is_tested = (count > 0.0) | (expected > 0.0)
    bins, pooled = pool_bins(expected[is_tested])
    bin_count, bin_expected = (
        np.bincount(bins, values[is_tested]).astype(np.float64)
        for values in (count, expected)
    )
    if _has_small_bin(bin_expected):
        return _untestable(pooled)

    share_error: Array = np.zeros(count.size)
    if errors is not None:
        share_error = np.asarray(errors, dtype=np.float64)
    unit_label = np.arange(count.size) if unit is None else np.asarray(unit)
    unit_of_bin, variance = _join_errors(
        bins, pooled, np.nan_to_num(share_error[is_tested]), unit_label[is_tested]
    )

    total = bin_expected.sum()
    unit_expected = np.bincount(unit_of_bin, bin_expected)
    unit_excess = np.bincount(unit_of_bin, bin_count) - unit_expected
    remaining_share = np.maximum(1.0 - unit_expected / total, np.finfo(float).tiny)
    scatter = np.where(
        remaining_share > ROUNDING, variance * total * total / remaining_share, 0.0
    )
    bin_excess = (
        bin_count
        - bin_expected
        - (unit_excess / unit_expected)[unit_of_bin] * bin_expected
    )
    among_units = (unit_excess * unit_excess / (unit_expected + scatter)).sum()
    within_units = (bin_excess * bin_excess / bin_expected).sum()
    outcome = _outcome(float(among_units + within_units), bin_expected.size, pooled)
    if np.isnan(share_error[is_tested]).any():
        return replace(outcome, p_value=math.nan)
    return outcome


def _join_errors(
    bins: Index, pooled: int, errors: Array, shared: Index
) -> tuple[Index, Array]:
    """Unit of each new bin, and variance of each unit.

    Bins put together are a unit of their own.
    """
    unit_label = np.where((bins == 0) & (pooled > 0), -1, shared)
    _, first_share, part_of_bin = np.unique(
        np.stack((unit_label, shared)), axis=1, return_index=True, return_inverse=True
    )
    part_error = np.bincount(part_of_bin.reshape(-1), errors)
    labels, unit_of_share = np.unique(unit_label, return_inverse=True)
    variance: Array = np.bincount(
        unit_of_share[first_share], part_error * part_error, minlength=labels.size
    ).astype(np.float64)
    unit_of_bin = np.empty(int(bins.max(initial=-1)) + 1, dtype=np.int64)
    unit_of_bin[bins] = unit_of_share
    return unit_of_bin, variance


def homogeneity(first: ArrayLike, second: ArrayLike) -> ChiSquare:
    """Compare two sets of counts, both with their own chance.

    Bins that are empty in both are left out.
    """
    rows = [_check_row("counts", first), _check_row("counts", second)]
    if rows[0].shape != rows[1].shape:
        raise RequestError(
            "two equally long sets of counts",
            f"{rows[0].size} and {rows[1].size}",
            "number both by the same poses",
        )
    table = np.stack(rows)
    table = table[:, table.sum(axis=0) > 0.0]
    if not table.sum(axis=1).all():
        return _untestable(0)
    shares = table.sum(axis=1) / table.sum()
    bins, pooled = pool_bins(shares.min() * table.sum(axis=0))
    bin_counts: Array = np.array([np.bincount(bins, row) for row in table], float)
    expected = np.outer(shares, bin_counts.sum(axis=0))
    if _has_small_bin(expected):
        return _untestable(pooled)
    return _outcome(
        float((np.square(bin_counts - expected) / expected).sum()),
        bin_counts.shape[1],
        pooled,
    )


def pool_bins(expected: ArrayLike) -> tuple[Index, int]:
    """Pool bins below the bound, and the smallest others until the sum reaches it.

    Returns the new bin (K,) of each old one, and how many old ones share a new one.
    """
    values = np.asarray(expected, dtype=np.float64)
    order = np.argsort(values, kind="stable")
    pooled_count = int(np.count_nonzero(values < SMALLEST_EXPECTED))
    if pooled_count:
        cumulative = np.cumsum(values[order])
        # Rounding must not drag another bin in.
        sufficient_counts = np.flatnonzero(
            cumulative >= SMALLEST_EXPECTED * (1.0 - 1e-12)
        )
        pooled_count = (
            max(pooled_count, int(sufficient_counts[0]) + 1)
            if sufficient_counts.size
            else values.size
        )
    bins = np.empty(values.size, dtype=np.int64)
    bins[order[:pooled_count]] = 0
    bins[order[pooled_count:]] = np.arange(values.size - pooled_count) + min(
        pooled_count, 1
    )
    return bins, pooled_count if pooled_count > 1 else 0


def _has_small_bin(expected: Array) -> bool:
    return expected.shape[-1] < 2 or expected.min() < SMALLEST_EXPECTED * (
        1.0 - ROUNDING
    )


def _outcome(statistic: float, bins: int, pooled: int) -> ChiSquare:
    return ChiSquare(
        statistic, bins - 1, float(chdtrc(bins - 1, statistic)), bins, pooled
    )


def _untestable(pooled: int) -> ChiSquare:
    return ChiSquare(math.nan, 0, math.nan, 1, pooled)


def _check_row(name: str, values: ArrayLike) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 1 or not np.all((array >= 0.0) & np.isfinite(array)):
        raise RequestError(
            f"finite {name} from 0 up, in one row",
            f"{array.tolist()}",
            "leave unknown ones out",
        )
    return array
