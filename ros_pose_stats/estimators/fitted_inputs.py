"""Inputs of the fitted networks, those of `split` and those of expected errors."""

from __future__ import annotations

import math

import numpy as np

from ..records import DropScene
from ..records.scene import DEFAULT_DROP_RADII
from ..resting.poses import RestingPoses
from .energy_absorption import eae, meae
from .fitted_weights import HIGHEST_DROP, HIGHEST_RESTITUTION, LOWEST_DROP
from .quasi_static import nonlinear, qse
from .solid_angles import Array, normalized

LEAST_CROWDING = 1e-4
"""Added to the crowding of corners before its logarithm is taken."""

LEAST_APART = 1e-3
"""Added to square distances of two methods, over the `error_scale`, before the logarithm."""

LEAST_ANGLE = 1e-12
"""Solid angle by which shares of a component are taken, at least."""

SHALLOWEST = 1e-3
"""Added to the barrier of a pose, in radii, before its logarithm is taken."""


def scene_inputs(resting: RestingPoses, scene: DropScene) -> Array:
    """Of restitution -log(1 - restitution), and log of the drop height in radii (2,).

    Both are cut to the range of the fit.
    """
    return np.array([-math.log1p(-min(scene.restitution, HIGHEST_RESTITUTION)),
                     math.log(min(max(drop_radii(resting, scene), LOWEST_DROP), HIGHEST_DROP))])


def drop_radii(resting: RestingPoses, scene: DropScene) -> float:
    """Drop height in radii of the part."""
    if scene.drop_height is None:
        return DEFAULT_DROP_RADII
    return scene.drop_height / resting.body.radius


def corner_inputs(resting: RestingPoses) -> Array:
    """Logarithms of how far the body turns in few corners, at two reaches (2,)."""
    return np.asarray(np.log(resting.corner_crowding + LEAST_CROWDING))


def rolling_inputs(resting: RestingPoses) -> Array:
    """How far the components of the K splits are facets that the body rolls on, (3 K, 2).

    The share of the facets of round and toothed runs in the solid angle of a component's faces,
    and the mean over that angle of the log of how many facets their run has, 0 off all runs. The
    rows of a split are its two children and the whole.
    """
    body, tree = resting.body, resting.equilibria.arrays.tree
    joins = np.flatnonzero(resting.clusters.split)
    nodes = np.column_stack((tree.child[joins], tree.level.shape[0] + 1 + joins)).ravel()
    rolls = body.run_of_face >= 0
    if not rolls.any():
        return np.zeros((nodes.shape[0], 2))
    run = body.run_of_face[rolls]
    measures = np.zeros((rolls.shape[0], 3))
    measures[:, 0], measures[rolls, 1] = 1.0, 1.0
    measures[rolls, 2] = np.log(np.bincount(run)[run])
    measures *= body.arrays.angle[:, None]
    sums = np.concatenate((np.zeros((1, 3)), measures[tree.face_order].cumsum(axis=0)))
    begin, end = tree.face_range[tree.leaf_range[nodes]].T
    found = sums[end] - sums[begin]
    return np.asarray(found[:, 1:] / np.maximum(found[:, :1], LEAST_ANGLE))


def error_inputs(resting: RestingPoses, probability: Array, scene: DropScene,
                 known: Array, scale: Array) -> Array:
    """Inputs (17,) of `ErrorFit`; the scale of an error must be above 0 for some pose.

    -log(1 - restitution) and log of the drop height in radii, from touching on; logs of the mean
    square distance of the estimate from MEAE, and of MEAE from NQSE, EAE and QSE, over the mean
    scale; logs of the number of poses and of the sum of the scales; means of the logs of the
    poses' barriers in radii, weighed by the scales and by p; then body and corners as `split` has
    them.

    `probability` (P,): the estimate; `known` (3, P): from `known_answers`; `scale` (P,): from
    `error_scale`.
    """
    energy, around, toppled = known
    total = float(scale.sum())
    apart = np.array([probability - around, around - normalized(nonlinear(toppled)),
                      around - energy, around - toppled])
    far = np.log((apart * apart).sum(axis=1) / total + LEAST_APART)
    depth = np.log(np.minimum(resting.clusters.barrier, 1.0) + SHALLOWEST)
    poses = (math.log(scale.size), math.log(total), scale @ depth / total, probability @ depth)
    height = math.log(max(drop_radii(resting, scene), LOWEST_DROP))
    return np.concatenate(((-math.log1p(-scene.restitution), height), far, poses,
                           resting.shape_features, corner_inputs(resting)))


def error_scale(resting: RestingPoses, probability: Array, known: Array) -> Array:
    """Scale of the square error of each pose (P,): p (1 - p) plus the square distance from MEAE.

    The first is the square error of a single drop, the second is for an estimate that is
    certain and wrong. Poses that symmetry makes equal count as one in p (1 - p), shared evenly,
    since symmetry makes no errors. The parameters are those of `error_inputs`.
    """
    return np.asarray(single_drop(resting, probability) + np.square(probability - known[1]))


def known_answers(resting: RestingPoses) -> Array:
    """Answers (3, P) of EAE, MEAE and QSE."""
    return np.array([eae(resting), meae(resting), qse(resting)])


def single_drop(resting: RestingPoses, probability: Array) -> Array:
    """The product p (1 - p) of each pose; equal ones by symmetry count as one, shared evenly."""
    group = resting.group
    together = np.bincount(group, probability)[group]
    size = np.bincount(group)[group]
    return np.asarray(together * np.maximum(1.0 - together, 0.0) / (size * size))
