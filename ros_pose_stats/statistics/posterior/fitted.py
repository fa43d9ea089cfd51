"""Numbers of the prior, written by `python -m benchmarks.fit_posterior`."""

from __future__ import annotations

from typing import Final

FITTED_METHOD: Final = "combined"
"""The estimator that they belong to."""

FITTED_AT: Final = (0.2, 0.5, 0.8)
"""Restitutions of the rows below."""

FITTED: Final = (
    (-0.2, 0.4, 0.0064, 0.0159),
    (-0.1, 0.62, 0.0106, 0.0081),
    (0.45, 0.56, 0.0388, 0.0056),
)
"""`PriorFit.center`, `spread`, `faint` and `sure` at each."""
