"""Whether counts contradict an estimate beyond both errors."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc

Array = NDArray[np.float64]

FALSE_ALARMS: Final = 0.002
"""Chance at each look that some pose of a part is said to be contradicted though the estimate is
as far off as it says, at most; Bonferroni's bound over the units and both sides."""

SMALLEST: Final = 1e-9


def contradicted_units(counts: Array, mean: Array, weight: Array, strength: Array
                       ) -> NDArray[np.bool_]:
    """Units whose count is too far from its estimate to be explained by both errors.

    A count of n drops with a probability from a Beta distribution of strength s scatters like
    a share from a Beta distribution of strength n (s + 1) / (s + n) - 1; which strength holds is
    not known, so its tails are averaged.

    `counts, mean` (G,): settled drops in each unit, and its estimated probability, above 0;
    `weight` (K, M): of the strengths, summing to 1; `strength` (K, M, G): pseudo-drops that the
    estimate of each unit is worth, above 0. Returns (G,) bool.
    """
    total = counts.sum()
    if not total or mean.size == 1:
        return np.zeros(mean.shape, dtype=bool)
    together = total * (strength + 1.0) / (strength + total) - 1.0
    first = np.maximum(together * mean, SMALLEST)
    second = np.maximum(together * (1.0 - mean), SMALLEST)
    above = 1.0 - betainc(first, second, np.clip((counts - 0.5) / total, 0.0, 1.0))
    below = betainc(first, second, np.clip((counts + 0.5) / total, 0.0, 1.0))
    tails = np.minimum(np.tensordot(weight, above, 2), np.tensordot(weight, below, 2))
    return np.asarray(2.0 * tails * mean.size < FALSE_ALARMS)
