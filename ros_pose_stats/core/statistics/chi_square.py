"""Whether counts differ by more than chance: Pearson's chi-square, with rare bins pooled."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc

from ...base.errors import RequestError
from ..records import Array, Index

LEAST_EXPECTED = 5.0
"""Expected count below which a bin is pooled: the usual rule (Cochran 1954).

Below it the statistic no longer follows the chi-square distribution.
"""

ROUNDING = 1e-9


@dataclass(frozen=True)
class ChiSquare:
    """Outcome of a test."""

    statistic: float  # NaN where there are too few counts for two bins
    # bins less one; nothing is fitted to the counts. 0 where there are too few
    degrees_of_freedom: int
    # chance of a statistic this large if the counts do follow the prediction; NaN where there are
    # too few, or where the error of the prediction is not known
    p_value: float
    bins: int  # that were compared, after pooling
    pooled: int  # bins that were put together into one; 0 for none

    @property
    def too_few(self) -> bool:
        """Whether the counts do not suffice for a test."""
        return self.degrees_of_freedom == 0


def goodness_of_fit(
    counts: ArrayLike,
    probabilities: ArrayLike,
    errors: ArrayLike | None = None,
    unit: ArrayLike | None = None,
) -> ChiSquare:
    """Compare counts with probabilities, exact ones or some with an error of their own.

    Errors are taken to be correlated as those of shares are: then the inverse of the covariance
    parts into a sum over units and one over the bins within each. A bin of probability 0 is pooled
    if something was counted there, else left out; `unit`: bins of one number share their error.
    """
    observed = _checked("counts", counts)
    weights = _checked("probabilities", probabilities)
    if observed.shape != weights.shape or not weights.sum() > 0.0:
        raise RequestError(
            "as many probabilities as counts, not all 0",
            f"{weights.size} of sum {weights.sum():g} for {observed.size} counts",
            "number both by the same poses",
        )
    expected = weights * (observed.sum() / weights.sum())
    told = (observed > 0.0) | (expected > 0.0)
    bins, pooled = pooled_bins(expected[told])
    joined, foreseen = (
        np.bincount(bins, values[told]).astype(np.float64)
        for values in (observed, expected)
    )
    if _too_small(foreseen):
        return _too_few(pooled)
    apart = (
        np.zeros(observed.size)
        if errors is None
        else np.asarray(errors, dtype=np.float64)
    )
    shared = np.arange(observed.size) if unit is None else np.asarray(unit)
    owner, variance = _join_errors(
        bins, pooled, np.nan_to_num(apart[told]), shared[told]
    )
    total = foreseen.sum()
    whole = np.bincount(owner, foreseen)
    beyond = np.bincount(owner, joined) - whole
    other = np.maximum(1.0 - whole / total, np.finfo(float).tiny)
    scatter = np.where(other > ROUNDING, variance * total * total / other, 0.0)
    inside = joined - foreseen - (beyond / whole)[owner] * foreseen
    found = _outcome(
        float(
            (beyond * beyond / (whole + scatter)).sum()
            + (inside * inside / foreseen).sum()
        ),
        foreseen.size,
        pooled,
    )
    return replace(found, p_value=math.nan) if np.isnan(apart[told]).any() else found


def _join_errors(
    bins: Index, pooled: int, errors: Array, shared: Index
) -> tuple[Index, Array]:
    """Unit of each new bin, and variance of each unit; bins put together are one of their own."""
    label = np.where((bins == 0) & (pooled > 0), -1, shared)
    _, first, place = np.unique(
        np.stack((label, shared)), axis=1, return_index=True, return_inverse=True
    )
    whole = np.bincount(place.reshape(-1), errors)
    labels, owner = np.unique(label, return_inverse=True)
    variance: Array = np.bincount(
        owner[first], whole * whole, minlength=labels.size
    ).astype(np.float64)
    unit = np.empty(int(bins.max(initial=-1)) + 1, dtype=np.int64)
    unit[bins] = owner
    return unit, variance


def homogeneity(first: ArrayLike, second: ArrayLike) -> ChiSquare:
    """Compare two sets of counts, both with their own chance; bins empty in both are left out."""
    rows = [_checked("counts", first), _checked("counts", second)]
    if rows[0].shape != rows[1].shape:
        raise RequestError(
            "two equally long sets of counts",
            f"{rows[0].size} and {rows[1].size}",
            "number both by the same poses",
        )
    table = np.stack(rows)
    table = table[:, table.sum(axis=0) > 0.0]
    if not table.sum(axis=1).all():
        return _too_few(0)
    shares = table.sum(axis=1) / table.sum()
    bins, pooled = pooled_bins(shares.min() * table.sum(axis=0))
    joined: Array = np.stack([np.bincount(bins, row) for row in table]).astype(
        np.float64
    )
    expected = np.outer(shares, joined.sum(axis=0))
    if _too_small(expected):
        return _too_few(pooled)
    return _outcome(
        float((np.square(joined - expected) / expected).sum()), joined.shape[1], pooled
    )


def pooled_bins(expected: ArrayLike) -> tuple[Index, int]:
    """Put bins below the bound together, and the smallest others until the new one reaches it.

    Returns the new bin (K,) of each old one, and how many old ones share a new one.
    """
    values = np.asarray(expected, dtype=np.float64)
    order = np.argsort(values, kind="stable")
    small = int(np.count_nonzero(values < LEAST_EXPECTED))
    if small:
        together = np.cumsum(values[order])
        # Rounding must not drag another bin in.
        enough = np.flatnonzero(together >= LEAST_EXPECTED * (1.0 - 1e-12))
        small = max(small, int(enough[0]) + 1) if enough.size else values.size
    bins = np.empty(values.size, dtype=np.int64)
    bins[order[:small]] = 0
    bins[order[small:]] = np.arange(values.size - small) + min(small, 1)
    return bins, small if small > 1 else 0


def _too_small(expected: Array) -> bool:
    return expected.shape[-1] < 2 or expected.min() < LEAST_EXPECTED * (1.0 - ROUNDING)


def _outcome(statistic: float, bins: int, pooled: int) -> ChiSquare:
    return ChiSquare(
        statistic, bins - 1, float(chdtrc(bins - 1, statistic)), bins, pooled
    )


def _too_few(pooled: int) -> ChiSquare:
    return ChiSquare(math.nan, 0, math.nan, 1, pooled)


def _checked(what: str, values: ArrayLike) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 1 or not np.all((array >= 0.0) & np.isfinite(array)):
        raise RequestError(
            f"finite {what} from 0 up, in one row",
            f"{array.tolist()}",
            "leave unknown ones out",
        )
    return array
