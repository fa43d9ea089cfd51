"""What error to expect of an estimator."""

from __future__ import annotations

import math

import numpy as np

from .coefficients import EXPECTED_AT, EXPECTED_ERRORS


def expected_error(name: str, restitution: float, poses: int) -> float:
    """Root mean square error over a part's poses that a method showed on random polyhedra.

    Measured against the drop simulation at three restitutions; between them straight, beyond
    them as at the nearest one.

    Parameters
    ----------
    name : str
        Of the method.
    restitution : float
    poses : int
        Of the part; a single one is certain.

    Returns
    -------
    float
        As a fraction; NaN where the method has not been measured.
    """
    if poses == 1:
        return 0.0
    if name not in EXPECTED_ERRORS:
        return math.nan
    return float(np.interp(restitution, EXPECTED_AT, EXPECTED_ERRORS[name]))
