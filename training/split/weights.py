"""The file that holds the fitted weights."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ros_pose_stats.estimators.split_weights import FILE, SplitFit, pack_split_fits

from .samples import HIGHEST_DROP, HIGHEST_RESTITUTION


def write_weights(fits: Sequence[SplitFit]) -> None:
    """Put them where the estimator reads them."""
    np.savez(FILE, **pack_split_fits(fits, (HIGHEST_RESTITUTION, HIGHEST_DROP)))
