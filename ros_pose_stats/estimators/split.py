"""An estimator that knows restitution, drop height and inertia (after section 4.D).

As in the energy absorption estimators the part loses energy, and its reachable set falls apart
split by split. How a split is decided is not the ratio of two solid angles here: each component
has a weight, the area of {r < E} times the exponential of a small function of its features
(`kernels.split_features`), of the body and of the scene. Its coefficients were fitted to drop
simulations of many kinds of bodies (`split_weights`).
"""

from __future__ import annotations

import math

import numpy as np

from ..geometry.poses import RestingPoses
from ..kernels.split_features import descend_splits
from ..records import DropScene
from ..records.scene import DEFAULT_DROP_RADII
from .estimator import Array, normalized
from .split_weights import BENDS, HIGHEST_DROP, HIGHEST_RESTITUTION, OFFSETS, SLOPE, TURNS

LOWEST_DROP = 1.0

FORGOTTEN = 30.0
"""Growth over the depth of a split at which a component keeps half of its parts' weights."""

SHALLOWEST = 1e-14

LEAST_CROWDING = 1e-4
"""Crowding of corners that logarithms start from."""


def split(resting: RestingPoses, scene: DropScene) -> Array:
    """Probabilities (P,) from fitted weights of the components at each split.

    Exact where symmetry decides, and continuous in the shape where the modified energy
    absorption estimator is. Beyond the restitution and the drop heights that it was fitted to
    (see `split_weights`) it answers for the nearest one.
    """
    rows = split_inputs(resting, scene)
    tree, wanted = resting.equilibria.arrays.tree, resting.clusters.split
    weight = np.zeros((tree.level.shape[0], 3))
    weight[wanted] = component_weights(rows).reshape(-1, 3)
    probability = descend_splits(weight, kept_shares(resting), tree, wanted)
    return normalized(probability[resting.clusters.node])


def split_inputs(resting: RestingPoses, scene: DropScene) -> Array:
    """Inputs (3 K, 19) of the weights: features, body, scene and corners, for the K splits.

    Both children of a split and the whole follow each other.
    """
    wanted = resting.clusters.split
    features = resting.split_features[wanted]
    rows = features.reshape(-1, features.shape[2])
    about = np.concatenate((_body(resting), _scene(resting, scene), _corners(resting)))
    return np.hstack((rows, np.broadcast_to(about, (rows.shape[0], about.shape[0]))))


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
    level = features[:, 0, 4]
    depth = level[at] - features[at, :2, 5].max(axis=1)
    grown = (level[rows] - level[at]) / np.maximum(FORGOTTEN * depth, SHALLOWEST)
    kept = np.zeros(tree.child.shape)
    kept[joined] = 1.0 / (1.0 + grown * grown)
    return kept


def component_weights(rows: Array) -> Array:
    """Logarithm (n,) of the weights of components from their inputs (n, 19)."""
    bent = np.tanh(rows @ TURNS + OFFSETS)
    return np.asarray(rows[:, 0] + rows @ SLOPE + bent @ BENDS)


def _body(resting: RestingPoses) -> Array:
    """Trace of the inertia, its smallest and largest share; highest split, lowest pose."""
    moments = np.linalg.eigvalsh(resting.inertia)
    levels = resting.equilibria.arrays.tree.level[resting.clusters.split]
    return np.array([moments.sum(), moments[0] / moments.sum(), moments[2] / moments.sum(),
                     levels.max(initial=0.0), resting.equilibria.heights.min()])


def _scene(resting: RestingPoses, scene: DropScene) -> Array:
    radii = DEFAULT_DROP_RADII
    if scene.drop_height is not None:
        radii = scene.drop_height / resting.body.radius
    return np.array([min(scene.restitution, HIGHEST_RESTITUTION),
                     math.log(min(max(radii, LOWEST_DROP), HIGHEST_DROP))])


def _corners(resting: RestingPoses) -> Array:
    """Logarithms of how far the body turns in few corners, at two reaches."""
    return np.asarray(np.log(resting.corner_crowding + LEAST_CROWDING))
