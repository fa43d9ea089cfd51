"""Energy absorption estimators: a walk down the splitting graph (section 4.D)."""

from __future__ import annotations

from typing import Final

from ..resting.poses import RestingPoses
from .quasi_static import nqse
from .solid_angles import Array, normalized

COMBINED_WEIGHT: Final = 0.75
"""c of Eq. 9 as published: the weight of MEAE beside NQSE (section 4.E)."""


def eae(resting: RestingPoses) -> Array:
    """Energy absorption estimator, Eqs. 7 and 8.

    At each split of the reachable set {R < E} the two components are taken with
    probabilities proportional to their centroid solid angles. Continuous where a face
    becomes marginal; ties between saddles give the same answer in any order.
    """
    _, probability = resting.passage_R
    return normalized(resting.clusters.gather(probability))


def meae(resting: RestingPoses) -> Array:
    """Modified energy absorption estimator: Eq. 8 with r in place of R (Appendix C)."""
    _, probability = resting.passage_r
    return normalized(resting.clusters.gather(probability))


def combined(resting: RestingPoses) -> Array:
    """Combined estimator, Eq. 9 with the published c = 0.75."""
    return COMBINED_WEIGHT * meae(resting) + (1.0 - COMBINED_WEIGHT) * nqse(resting)
