"""Numbers of the prior, written by `python -m training.fit_posterior`."""

from __future__ import annotations

from typing import Final

FITTED_METHOD: Final = "split"
"""The estimator that they belong to."""

FITTED_AT: Final = (0.2, 0.5, 0.8)
"""Restitutions of the rows below."""

FITTED: Final = (
    (-0.1417, 0.3601, 5.309e-05, 0.03487, 0.2468),
    (-0.175, 0.3525, 1.497e-05, 0.05173, 0.2839),
    (0.008729, 0.4301, 6.063e-05, 0.02717, 0.2533),
)
"""`PriorFit.center`, `spread`, `overrated`, `rare_below` and `unsure_share` at each."""
