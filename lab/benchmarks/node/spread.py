"""Least, median and 99th percentile of times."""

import math
from collections.abc import Sequence
from statistics import median

from lab.frame.results import Cell


def p99(seconds: Sequence[float]) -> float:
    """99th percentile in milliseconds; of fewer than 100 the largest."""
    return 1e3 * sorted(seconds)[math.ceil(0.99 * len(seconds)) - 1]


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
