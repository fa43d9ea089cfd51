"""Analytic estimators of pose statistics (section 4): one signature, one registry."""

from .estimate import estimate, estimate_all
from .estimator import Estimator
from .registry import DEFAULT_METHOD, ESTIMATORS, estimator

__all__ = ["DEFAULT_METHOD", "ESTIMATORS", "Estimator", "estimate", "estimate_all", "estimator"]
