# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Estimators that weigh each stable face by its size (section 4.B)."""

import numpy as np

from ..kernels.levels.equilibria import perturbed_shares, settle_on_stable
from ..records import Array, Index
from ..resting import poses


def normalize(weights: Array) -> Array:
    """Weights (P,) scaled to sum to 1."""
    return np.asarray(weights / weights.sum())


def area(resting: poses.RestingPoses) -> Array:
    """Probabilities (P,) in proportion to the stable faces' area [24], beside Eq. 5."""
    return _share_by(resting, resting.body.arrays.area)


def _share_by(resting: poses.RestingPoses, size: Array) -> Array:
    """Probabilities (P,) in proportion to a size (F,) of the stable faces."""
    return normalize(resting.gather(size[resting.equilibria.faces]))


def group_sums(values: Array, group: Index) -> Array:
    """Sums (..., G) of values of poses (..., P) over their groups (P,)."""
    groups = int(group.max()) + 1
    rows = values.reshape(-1, group.size)
    bins = groups * np.arange(len(rows))[:, None] + group
    sums = np.bincount(bins.ravel(), rows.ravel(), groups * len(rows))
    return sums.reshape(*values.shape[:-1], groups).astype(np.float64, copy=False)


def share_in_groups(values: Array, group: Index) -> Array:
    """Values of poses (..., P), shared evenly among those of one group (P,)."""
    if group.max() + 1 == group.size:  # each is a group of its own
        return values
    # Rows lie one after the other, as they would not by an index: sums round by that.
    shares: Array = group_sums(values, group) / np.bincount(group)
    return shares.take(group, axis=-1)


def csae(resting: poses.RestingPoses) -> Array:
    """Centroid solid angle estimator, Eq. 5 [27].

    It jumps where a face becomes stable.
    """
    return _share_by(resting, resting.body.arrays.angle)


def adre(resting: poses.RestingPoses) -> Array:
    """Angle-distance ratio estimator [28], [29].

    It is Eq. 5 with the solid angle over the distance.
    """
    arrays = resting.body.arrays
    return _share_by(resting, arrays.angle / arrays.distance)


NQSE_COEFFICIENTS = (
    -0.874,
    8.03,
    -16.3,
    7.70,
)  # c0 … c3 of Eq. 6 as published (section 4.C).

PQSE_SHARE = 0.4
"""Redistributed share of PQSE: with it the estimator errs on the paper's kind of bodies
as in the paper's Table I, and neither over- nor underestimates large faces (`python -m
study table`)."""


SMALLEST_SHARE = 1e-12  # of a face of a body; below it is rounding


def qse(resting: poses.RestingPoses) -> Array:
    """Quasi-static estimator [26], section 4.B.

    Solid angles are carried down the toppling graph.
    """
    return _share_by(resting, resting.equilibria.arrays.toppled)


def nqse(resting: poses.RestingPoses) -> Array:
    """Nonlinear quasi-static estimator, Eq. 6 with the published coefficients.

    Summed over the faces of a pose first, so that a finer tessellation does not count
    for less.
    """
    return normalize(nonlinear(qse(resting)))


def pqse(resting: poses.RestingPoses) -> Array:
    """Perturbed quasi-static estimator [25], in this project's reading.

    The paper says that probability moves between each pair of adjacent faces to the
    larger one, by a simple rule. In our reading the side between faces i and j moves by
    an angle, and the strip that it sweeps changes hands: i takes `share * arc / (4 pi)
    * (area_i - area_j) / mean` from j, where arc is the angle that the side spans seen
    from the centre of mass, and mean the area of all faces over their number. A face
    that would give more than it has gives all it has, in proportion (the paper's remedy
    against negative probabilities). The result then topples as in the quasi-static
    estimator. The faces of one pose count as one surface.
    """
    equilibria = resting.equilibria
    surface = np.arange(resting.body.faces)
    surface[equilibria.faces] = resting.faces[resting.clusters.pose]
    first_share = perturbed_shares(resting.body.arrays, surface, PQSE_SHARE)
    # What rounding leaves to a face that gives all is no share that may be wrong.
    first_share[first_share < SMALLEST_SHARE] = 0.0
    stable_share = settle_on_stable(
        first_share, equilibria.arrays.target, equilibria.arrays.share
    )
    return _share_by(resting, stable_share)


def nonlinear(share: Array) -> Array:
    """The function f of Eq. 6, never below 0; its argument is a probability."""
    c0, c1, c2, c3 = NQSE_COEFFICIENTS
    bend = c0 + share * (c1 + share * (c2 + share * c3))
    return np.maximum(share + share * (1.0 - share) * bend, 0.0)


COMBINED_WEIGHT = 0.75
"""C of Eq. 9 as published: the weight of MEAE beside NQSE (section 4.E).."""


def eae(resting: poses.RestingPoses) -> Array:
    """Energy absorption estimator, Eqs. 7 and 8, by the reachable set {R < E}."""
    return normalize(resting.clusters.gather(resting.passage_R[1]))


def meae(resting: poses.RestingPoses) -> Array:
    """Modified energy absorption estimator: Eq. 8 with r in place of R (Appendix C)."""
    return normalize(resting.clusters.gather(resting.passage_r[1]))


def combined(resting: poses.RestingPoses) -> Array:
    """Combined estimator, Eq. 9 with the published c = 0.75."""
    return COMBINED_WEIGHT * meae(resting) + (1.0 - COMBINED_WEIGHT) * nqse(resting)
