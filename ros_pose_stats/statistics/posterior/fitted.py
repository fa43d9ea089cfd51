"""Numbers of the prior, written by `python -m benchmarks.fit_posterior`."""

from __future__ import annotations

from typing import Final

FITTED_METHOD: Final = "split"
"""The estimator that they belong to."""

FITTED_AT: Final = (0.2, 0.5, 0.8)
"""Restitutions of the rows below."""

FITTED: Final = (
    (-0.1302, 0.3552, 0.000597, 0.03311),
    (0.1086, 1, 0.0002999, 0.02488),
    (-0.01456, 0.5547, 0.0005304, 0.02785),
)
"""`PriorFit.center`, `spread`, `faint` and `sure` at each."""

BOUND_FACTORS: Final[dict[str, tuple[float, ...]]] = {
    "area": (1.18, 1.13, 1.13),
    "csae": (1.25, 1.19, 1.16),
    "adre": (1.3, 1.23, 1.23),
    "qse": (1.27, 1.21, 1.19),
    "pqse": (1.39, 1.33, 1.25),
    "nqse": (1.31, 1.23, 1.21),
    "eae": (1.36, 1.39, 1.43),
    "meae": (1.51, 1.56, 1.5),
    "combined": (1.48, 1.48, 1.45),
    "split": (1.52, 1.57, 1.61),
}
"""By which factor the error stays below the expected one in 90 % of the parts, at each."""
