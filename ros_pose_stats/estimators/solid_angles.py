"""Estimators that weigh each stable face by its size (section 4.B)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..resting.poses import RestingPoses

Array = NDArray[np.float64]


def normalized(weights: Array) -> Array:
    """Weights (P,) scaled to sum to 1."""
    return np.asarray(weights / weights.sum())


def area(resting: RestingPoses) -> Array:
    """Probabilities (P,) proportional to the surface area of the stable faces [24].

    The paper names it in section 4.B beside Eq. 5, with an error of 0.112. The estimate jumps
    where a face becomes stable.
    """
    found = resting.equilibria
    return normalized(resting.gather(found.body.arrays.area[found.faces]))


def csae(resting: RestingPoses) -> Array:
    """Centroid solid angle estimator, Eq. 5 [27].

    Probabilities (P,) proportional to the centroid solid angle of the stable faces. It jumps
    where a face becomes stable.
    """
    found = resting.equilibria
    return normalized(resting.gather(found.body.arrays.angle[found.faces]))


def adre(resting: RestingPoses) -> Array:
    """Angle-distance ratio estimator [28], [29]: Eq. 5 with the ratio of section 4.B.

    Probabilities (P,) proportional to the centroid solid angle of a stable face over its
    distance from the centre of mass. It jumps where a face becomes stable.
    """
    found = resting.equilibria
    arrays = found.body.arrays
    return normalized(resting.gather(arrays.angle[found.faces] / arrays.distance[found.faces]))
