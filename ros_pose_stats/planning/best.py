"""Which estimate is the best before anything is known of the part."""

from __future__ import annotations

import numpy as np

from ..estimators import ESTIMATORS
from ..estimators.error_weights import USUAL_AT, USUAL_ERRORS


def best_method(restitution: float) -> str:
    """The estimator that errs least on the reference parts at a restitution."""
    def usual(name: str) -> float:
        squares = np.square(USUAL_ERRORS[name])
        return float(np.interp(restitution, USUAL_AT, squares))

    return min((name for name in ESTIMATORS if name in USUAL_ERRORS), key=usual)
