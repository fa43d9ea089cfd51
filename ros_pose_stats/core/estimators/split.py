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

"""The estimator `split`, after section 4.D, of restitution, drop height, inertia.

As in the energy absorption estimators the part loses energy, and its reachable set
falls apart split by split. But the probabilities at a split are not the ratio of two
solid angles: each component has a weight, the sum of two terms. One is the area of {r <
E}, the other the solid angle of the faces that hold what lands on them, each times the
exponential of a small neural network of the component's features
(`kernels.split_features`), the body and the scene. The networks were fitted to drop
simulations of many kinds of bodies (`fitted`). In the end odds fall with how far curves
that a part rocks on lie across a pose (`kernels.features.curves`).
"""

from collections.abc import Sequence

import numpy as np

from ..kernels.features.split_features import DEPTH, LEVEL, LOG_AREA, LOG_HELD, LOWEST
from ..kernels.levels.splits import descend_splits
from ..records import Array, DropScene
from ..resting.poses import RestingPoses
from . import fitted, published

HOLDING_DEPTH = 1e-3
"""Depth over level at which a component's faces hold half of what they can."""

FORGETTING_GROWTH = 30.0
"""Growth over the depth of a split at which a component keeps half of its parts'
weights."""

SHALLOWEST = 1e-14
"""Least depth, in radii or over the level, that is divided by or whose logarithm is
taken."""

STEEP_RATIO = 1e3
"""Depth over the rise of the level to a next split, by which that outgrows a shallower
one."""

CURVE_GROWTH = 13.0
"""Growth of the log odds with how far curves lie across poses
(docs/decisions.md)."""


def split(
    resting: RestingPoses,
    scene: DropScene,
    fits: Sequence[fitted.SplitFit] = fitted.SPLIT_FITS,
) -> Array:
    """Probabilities (P,) from fitted weights of the components at each split.

    They are exact where symmetry decides, and continuous in the shape where the
    modified energy absorption estimator is, but where facets of a curve break. Beyond
    the scenes of the fit they are those of the nearest.
    """
    rows = split_inputs(resting, scene)
    tree = resting.equilibria.arrays.tree
    is_split = resting.clusters.split
    weight = np.zeros((tree.level.shape[0], 3))
    weight[is_split] = component_weights(rows, fits).reshape(-1, 3)
    probability = descend_splits(weight, kept_shares(resting), tree, is_split)
    curves = resting.curves[1]
    return published.normalize(
        resting.clusters.gather(probability)
        * np.exp(CURVE_GROWTH * (curves.min() - curves))
    )


def split_inputs(resting: RestingPoses, scene: DropScene) -> Array:
    """Inputs (3 K, 26) of K splits: of both children and of the whole."""
    is_split = resting.clusters.split
    features = resting.split_features[is_split]
    rows = features.reshape(-1, features.shape[2])
    part_inputs = np.concatenate(
        (
            resting.shape_features,
            fitted.scene_inputs(resting, scene),
            fitted.corner_inputs(resting),
        )
    )
    shared_columns = np.broadcast_to(part_inputs, (rows.shape[0], part_inputs.shape[0]))
    return np.hstack((rows, shared_columns, fitted.rolling_inputs(resting)))


def kept_shares(resting: RestingPoses) -> Array:
    """Share of its children's weights that each child of a join (S - 1, 2) keeps.

    A ridge that is low against the growth of the component since its split is
    forgotten: a face that breaks in two changes nothing at first. Of splits at a level
    the shallowest ridge counts.
    """
    tree = resting.equilibria.arrays.tree
    features = resting.split_features
    leaves = resting.equilibria.order.shape[0]
    child_join = tree.child - leaves
    is_joined = resting.clusters.split[:, None] & (child_join >= 0)
    is_joined[is_joined] = resting.clusters.split[child_join[is_joined]]
    level = features[:, 0, LEVEL]
    depth = level - features[:, :2, LOWEST].max(axis=1)
    for row, child in np.argwhere(is_joined):  # from the lowest split upwards
        child_row = child_join[row, child]
        rise = level[row] - level[child_row]
        depth[row] = min(depth[row], depth[child_row] + STEEP_RATIO * rise)
    child_rows = child_join[is_joined]
    rows = np.nonzero(is_joined)[0]
    growth = (level[rows] - level[child_rows]) / np.maximum(
        FORGETTING_GROWTH * depth[child_rows], SHALLOWEST
    )
    share = np.zeros(tree.child.shape)
    share[is_joined] = 1.0 / (1.0 + growth * growth)
    return share


def component_weights(rows: Array, fits: Sequence[fitted.SplitFit]) -> Array:
    """Logarithm (n,) of the weights of components from their inputs (n, 26)."""
    area_base, holding_base = component_bases(rows)
    log_weights = [
        np.logaddexp(
            area_base + fit.area_network(rows), holding_base + fit.holding_network(rows)
        )
        for fit in fits
    ]
    return np.asarray(sum(log_weights) / len(fits))


def component_bases(rows: Array) -> tuple[Array, Array]:
    """Logarithms (n,) of the area, and of the angle that holds, by the depth."""
    depth = np.maximum(rows[:, DEPTH], SHALLOWEST)
    holding = rows[:, LOG_HELD] + np.log(depth / (depth + HOLDING_DEPTH))
    return np.asarray(rows[:, LOG_AREA]), np.asarray(holding)
