"""Least, median and 99th percentile of times."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

from lab.frame.results import Cell

P99 = 0.99


def percentile(values: Sequence[float], share: float) -> float:
    """Smallest of the values that at least this share of them does not exceed.

    Raises
    ------
    ValueError
        If there are no values, or the share is not above 0 and at most 1.
    """
    if not values or not 0.0 < share <= 1.0:
        raise ValueError(f"no percentile {share} of {len(values)} values")
    return sorted(values)[math.ceil(share * len(values)) - 1]


def p99(seconds: Sequence[float]) -> float:
    """99th percentile in milliseconds; of fewer than 100 the largest."""
    return 1e3 * percentile(seconds, P99)


def spread(seconds: Sequence[float]) -> dict[str, Cell]:
    """Cells of a table: how many, and least, median and 99th percentile in
    milliseconds.
    """
    return {
        "runs": len(seconds),
        "least, ms": 1e3 * min(seconds),
        "median, ms": 1e3 * median(seconds),
        "p99, ms": p99(seconds),
    }


def beyond(seconds: Sequence[float], others: Sequence[float]) -> float:
    """Median over the rounds of one time less another of the same round, in
    milliseconds.
    """
    return 1e3 * median(
        seconds_of - baseline
        for seconds_of, baseline in zip(seconds, others, strict=False)
    )
