"""Fitted numbers of the estimators, each with its origin."""

from __future__ import annotations

from typing import Final

NQSE_COEFFICIENTS: Final = (-0.874, 8.03, -16.3, 7.70)
"""c0 … c3 of Eq. 6 as published (section 4.C)."""

COMBINED_WEIGHT: Final = 0.75
"""c of Eq. 9 as published: the weight of MEAE beside NQSE (section 4.E)."""

PQSE_SHARE: Final = 0.555
"""Redistributed share of PQSE in this project's reading.

Fitted to Budden's measured dice by `training/fit_pqse.py`.
"""
