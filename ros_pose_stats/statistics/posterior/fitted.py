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

BOUND_FACTORS: Final[dict[str, tuple[float, ...]]] = {
    "area": (1.18, 1.13, 1.14),
    "csae": (1.25, 1.19, 1.17),
    "adre": (1.3, 1.23, 1.23),
    "qse": (1.28, 1.21, 1.19),
    "pqse": (1.38, 1.32, 1.26),
    "nqse": (1.32, 1.23, 1.22),
    "eae": (1.35, 1.34, 1.41),
    "meae": (1.51, 1.49, 1.52),
    "combined": (1.48, 1.43, 1.46),
    "split": (1.46, 1.52, 1.61),
}
"""By which factor the error stays below the expected one in 90 % of the parts, at each."""
