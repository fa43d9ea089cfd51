"""The file that holds the fitted expected errors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.estimators.error_weights import FILE, ErrorFit, pack_error_fits

from .fit import RESTITUTIONS

Array = NDArray[np.float64]


def write_weights(fits: Mapping[str, ErrorFit], usual: Mapping[str, Array]) -> None:
    """Put them where the estimators read them."""
    np.savez(FILE, **pack_error_fits(fits, RESTITUTIONS, usual))
