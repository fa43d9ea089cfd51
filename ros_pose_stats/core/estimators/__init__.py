"""Estimators of pose statistics (section 4 of the paper, and `split`)."""

from .estimate import ESTIMATORS, Estimator, estimate_all, estimate_in, estimator
from .expected import best_method

__all__ = [
    "ESTIMATORS",
    "Estimator",
    "best_method",
    "estimate_all",
    "estimate_in",
    "estimator",
]
