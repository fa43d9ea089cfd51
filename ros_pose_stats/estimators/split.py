"""An estimator that knows restitution, drop height and inertia (after section 4.D).

As in the energy absorption estimators the part loses energy, and its reachable set falls apart
split by split. How a split is decided is not the ratio of two solid angles here: each component
has a weight, the area of {r < E} and the solid angle of the faces that hold what lands on them,
each times the exponential of a small function of its features (`kernels.split_features`), of the
body and of the scene. Their coefficients were fitted to drop simulations of many kinds of bodies
(`fitted_weights`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..kernels.features.component_features import DEPTH, LEVEL, LOG_AREA, LOG_HELD, LOWEST
from ..kernels.levels.splits import descend_splits
from ..records import DropScene
from ..resting.poses import RestingPoses
from .fitted_inputs import corner_inputs, scene_inputs
from .fitted_weights import SPLIT_FITS, SplitFit
from .solid_angles import Array, normalized

HOLDING = 1e-3
"""Depth over level at which a component's faces hold half of what they hold at most."""

LEAST_DEPTH = 1e-14
"""Depth over level that logarithms start from."""

FORGOTTEN = 30.0
"""Growth over the depth of a split at which a component keeps half of its parts' weights."""

SHALLOWEST = 1e-14
"""Depth, in radii, that growth is measured by at least."""


def split(resting: RestingPoses, scene: DropScene) -> Array:
    """Probabilities (P,) from fitted weights of the components at each split.

    Exact where symmetry decides, and continuous in the shape where the modified energy
    absorption estimator is. Beyond the restitution and the drop heights that it was fitted to
    (see `fitted_weights`) it answers for the nearest one.
    """
    rows = split_inputs(resting, scene)
    tree, wanted = resting.equilibria.arrays.tree, resting.clusters.split
    weight = np.zeros((tree.level.shape[0], 3))
    weight[wanted] = component_weights(rows).reshape(-1, 3)
    probability = descend_splits(weight, kept_shares(resting), tree, wanted)
    return normalized(probability[resting.clusters.node])


def split_inputs(resting: RestingPoses, scene: DropScene) -> Array:
    """Inputs (3 K, 24) of the weights: features, body, scene and corners, for the K splits.

    Both children of a split and the whole follow each other.
    """
    wanted = resting.clusters.split
    features = resting.split_features[wanted]
    rows = features.reshape(-1, features.shape[2])
    about = np.concatenate((resting.shape_features, scene_inputs(resting, scene),
                            corner_inputs(resting)))
    inputs = np.empty((rows.shape[0], rows.shape[1] + about.shape[0]))
    inputs[:, :rows.shape[1]], inputs[:, rows.shape[1]:] = rows, about
    return inputs


def kept_shares(resting: RestingPoses) -> Array:
    """How much of its parts' weights a child of each join (S - 1, 2) keeps, 0 to 1.

    All, where its own split lies at the same level. A ridge that is shallow against what the
    component has grown since is forgotten: a face that breaks in two changes nothing at first.
    """
    tree, features = resting.equilibria.arrays.tree, resting.split_features
    leaves = resting.equilibria.order.shape[0]
    below = tree.child - leaves
    joined = resting.clusters.split[:, None] & (below >= 0)
    joined[joined] = resting.clusters.split[below[joined]]
    at, rows = below[joined], np.nonzero(joined)[0]
    level = features[:, 0, LEVEL]
    depth = level[at] - features[at, :2, LOWEST].max(axis=1)
    grown = (level[rows] - level[at]) / np.maximum(FORGOTTEN * depth, SHALLOWEST)
    kept = np.zeros(tree.child.shape)
    kept[joined] = 1.0 / (1.0 + grown * grown)
    return kept


def component_weights(rows: NDArray[np.floating],
                      fits: Sequence[SplitFit] = SPLIT_FITS) -> Array:
    """Logarithm (n,) of the weights of components from their inputs (n, 24).

    A part comes to rest in a component because the last of its energy leaves it there, or
    because it lands on a face that holds it: each has a weight of its own, and they add.
    """
    left, held = component_bases(rows)
    told = [np.logaddexp(left + fit.left(rows), held + fit.held(rows)) for fit in fits]
    return np.asarray(sum(told) / len(fits))


def component_bases(rows: NDArray[np.floating]) -> tuple[Array, Array]:
    """Logarithms (n,) of what the fitted factors multiply: the area, and the angle that holds.

    The angle counts less where the level is hardly above the lowest face: it vanishes with the
    depth.
    """
    depth = np.maximum(rows[:, DEPTH], LEAST_DEPTH)
    holding = rows[:, LOG_HELD] + np.log(depth / (depth + HOLDING))
    return np.asarray(rows[:, LOG_AREA]), np.asarray(holding)
