"""Fitted numbers of the estimators, each with its origin."""

from __future__ import annotations

from typing import Final

NQSE_COEFFICIENTS: Final = (-0.874, 8.03, -16.3, 7.70)
"""c0 … c3 of Eq. 6 as published (section 4.C)."""

COMBINED_WEIGHT: Final = 0.75
"""c of Eq. 9 as published: the weight of MEAE beside NQSE (section 4.E)."""

PQSE_SHARE: Final = 0.555
"""Redistributed share of PQSE in this project's reading.

Fitted to Budden's measured dice by `benchmarks/fit_pqse.py`.
"""

EXPECTED_AT: Final = (0.2, 0.5, 0.8)
"""Restitutions of `EXPECTED_ERRORS`."""

EXPECTED_ERRORS: Final[dict[str, tuple[float, ...]]] = {
    "area": (0.162, 0.175, 0.194),
    "csae": (0.104, 0.114, 0.132),
    "adre": (0.084, 0.088, 0.099),
    "qse": (0.096, 0.101, 0.119),
    "pqse": (0.069, 0.070, 0.085),
    "nqse": (0.089, 0.095, 0.112),
    "eae": (0.103, 0.080, 0.057),
    "meae": (0.054, 0.036, 0.031),
    "combined": (0.047, 0.034, 0.042),
}
"""Error of each method on random polyhedra, as a fraction, at three restitutions.

Measured on the reference datasets by `benchmarks/fit_expected_errors.py`.
"""
