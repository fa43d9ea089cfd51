"""Numbers of the prior, written by `python -m benchmarks.fit_posterior`."""

from __future__ import annotations

from typing import Final

FITTED_METHOD: Final = "split"
"""The estimator that they belong to."""

FITTED_AT: Final = (0.2, 0.5, 0.8)
"""Restitutions of the rows below."""

FITTED: Final = (
    (-0.09829, 0.3468, 8e-05, 0.04084, 0.1912),
    (-0.06526, 0.4363, 8.905e-05, 0.04126, 0.2181),
    (-0.1398, 0.5084, 0.0002937, 0.07232, 0.2633),
)
"""`PriorFit.center`, `spread`, `faint`, `sure` and `loose` at each."""
