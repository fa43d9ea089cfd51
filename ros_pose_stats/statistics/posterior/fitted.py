"""Numbers of the prior, written by `python -m benchmarks.fit_posterior`."""

from __future__ import annotations

from typing import Final

FITTED_METHOD: Final = "combined"
"""The estimator that they belong to."""

FITTED_AT: Final = (0.2, 0.5, 0.8)
"""Restitutions of the rows below."""

FITTED: Final = (
    (-0.13, 0.2945, 0.006426, 0.01804),
    (-0.07537, 0.3892, 0.01071, 0.008674),
    (0.4124, 0.4355, 0.03926, 0.005972),
)
"""`PriorFit.center`, `spread`, `faint` and `sure` at each."""
