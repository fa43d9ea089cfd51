"""Estimators of pose statistics (section 4 of the paper, and `split`), and their registry."""

from .estimate import estimate_all, estimate_in
from .expected import best_method
from .registry import ESTIMATORS, Estimator, estimator

__all__ = ["ESTIMATORS", "Estimator", "best_method", "estimate_all", "estimate_in", "estimator"]
