"""Numbers of the prior, written by `python -m training.fit_posterior`."""

from __future__ import annotations

from typing import Final

FITTED_METHOD: Final = "split"
"""The estimator that they belong to."""

FITTED_AT: Final = (0.2, 0.5, 0.8)
"""Restitutions of the rows below."""

FITTED: Final = (
    (-0.3601, 0.3286, 0.0001419, 0.03249, 0.1851),
    (-0.08845, 0.3175, 7.502e-14, 0.03526, 0.2344),
    (0.04288, 0.437, 1.915e-05, 0.03659, 0.2918),
)
"""`PriorFit.center`, `spread`, `overrated`, `rare_below` and `unsure_share` at each."""
