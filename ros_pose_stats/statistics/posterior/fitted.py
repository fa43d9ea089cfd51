"""Numbers of the prior, written by `python -m benchmarks.fit_posterior`."""

from __future__ import annotations

from typing import Final

FITTED_METHOD: Final = "split"
"""The estimator that they belong to."""

FITTED_AT: Final = (0.2, 0.5, 0.8)
"""Restitutions of the rows below."""

FITTED: Final = (
    (-0.1422, 0.3544, 5.236e-05, 0.03564, 0.2515),
    (-0.163, 0.3528, 1.383e-05, 0.05227, 0.2827),
    (-0.01208, 0.4077, 5.864e-05, 0.02757, 0.2572),
)
"""`PriorFit.center`, `spread`, `faint`, `sure` and `loose` at each."""
