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

"""Fitted weights: small neural networks, and the files that hold those of the package.

`python -m lab.training.split fit --write` stores the weights of `split`, and
`python -m lab.training.expected_errors --write` those of expected errors.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..records import Array, DropScene
from ..records.scene import DEFAULT_DROP_RADII
from ..resting.poses import RestingPoses
from .published import (
    eae,
    group_sums,
    meae,
    nonlinear,
    normalize,
    qse,
    share_in_groups,
)

SPLIT_FILE = Path(__file__).parent / "weights" / "split.npz"
ERROR_FILE = SPLIT_FILE.with_name("expected_errors.npz")
SMALLEST_RANGE = 0.1  # of an input of expected errors that hardly varies in the fit


class TanhNetwork(NamedTuple):
    """bias + skip x + output_weights tanh(hidden_weights x + hidden_bias), K inputs."""

    bias: float
    skip: Array  # (K,); weights of the inputs themselves, which skip the hidden layer
    hidden_weights: Array  # (K, n); for n hidden units
    hidden_bias: Array  # (n,)
    output_weights: Array

    def __call__(self, inputs: Array) -> Array:
        """Values (...) for inputs (..., K)."""
        hidden = np.tanh(inputs @ self.hidden_weights + self.hidden_bias)
        return np.asarray(
            self.bias + inputs @ self.skip + hidden @ self.output_weights, dtype=float
        )


def _networks(stored: Mapping[str, Array], prefix: str) -> list[TanhNetwork]:
    """Read networks of one size, which are stored field by field."""
    columns = [stored[prefix + name] for name in TanhNetwork._fields]
    return [
        TanhNetwork(float(bias), *(np.array(row) for row in rows))
        for bias, *rows in zip(*columns, strict=True)
    ]


class SplitFit(NamedTuple):
    """Networks for the logarithms of two factors, of `split.split_inputs`."""

    # factor of the area of {r < E}: parts that lose the last of their energy in a
    # component
    area_network: TanhNetwork
    # factor of the solid angle of the faces that hold: parts that stay where they land
    holding_network: TanhNetwork


class ErrorFit(NamedTuple):
    """Square error of one method as a function of part, estimate and scene."""

    # (K,); bounds of the inputs in the fit; beyond them the value is that of the
    # nearest inputs
    lowest: Array
    highest: Array
    network: TanhNetwork
    # standard deviation, over parts of which the same is expected, of the logarithm of
    # the square error
    scatter: float


class StackedFits(NamedTuple):
    """`ErrorFit` of M methods, with a row for each."""

    lowest: Array  # (M, K)
    highest: Array
    scatter: Array  # (M,)
    bias: Array  # of the networks, as the others
    skip: Array
    hidden_weights: Array
    hidden_bias: Array
    output_weights: Array

    def __call__(self, inputs: Array) -> tuple[Array, Array]:
        """Logarithms (M,) of the square errors over the means of `error_scale`.

        How far the inputs (M, K) lie beyond those of the fits, too, in ranges of the
        input, summed. Each method is computed as by itself, to the last bit.
        """
        nearest = np.minimum(np.maximum(inputs, self.lowest), self.highest)
        width = np.maximum(self.highest - self.lowest, SMALLEST_RANGE)
        excess = np.abs(inputs - nearest) / width
        rows = nearest[:, None, :]
        hidden = np.tanh(rows @ self.hidden_weights + self.hidden_bias[:, None, :])
        skipped = (rows @ self.skip[:, :, None])[:, 0, 0]
        output = (hidden @ self.output_weights[:, :, None])[:, 0, 0]
        return self.bias + skipped + output, excess.sum(axis=1)


def stack_fits(fits: Sequence[ErrorFit]) -> StackedFits:
    """Fits of several methods, one below the other."""
    columns = zip(*(fit.network for fit in fits), strict=True)
    return StackedFits(
        np.array([fit.lowest for fit in fits]),
        np.array([fit.highest for fit in fits]),
        np.array([fit.scatter for fit in fits]),
        *map(np.array, columns),
    )


with np.load(SPLIT_FILE) as _stored:
    SPLIT_FITS = tuple(
        map(SplitFit, _networks(_stored, "left_"), _networks(_stored, "held_"))
    )
    """Fits from several random starts, whose logarithms are averaged."""

    HIGHEST_RESTITUTION, LOWEST_DROP, HIGHEST_DROP = _stored["scenes"].tolist()
    """Highest restitution, and drop heights in radii, of the samples of the fit."""

with np.load(ERROR_FILE) as _stored:
    _methods: list[str] = _stored["method"].tolist()

    ERROR_FITS = dict(
        zip(
            _methods,
            map(
                ErrorFit,
                _stored["lowest"],
                _stored["highest"],
                _networks(_stored, ""),
                _stored["scatter"].tolist(),
            ),
            strict=True,
        )
    )
    """By method; their inputs are `error_inputs`."""

    USUAL_AT: tuple[float, ...] = tuple(_stored["usual_at"].tolist())
    """Restitutions of the tuples below."""

    USUAL_ERRORS: dict[str, tuple[float, ...]] = {
        name: tuple(row)
        for name, row in zip(_methods, _stored["usual"].tolist(), strict=True)
    }
    """Root mean square error over the parts of the reference datasets, as a
    fraction."""


SMALLEST_CROWDING = 1e-4
"""Added to the crowding of corners before its logarithm is taken."""

SMALLEST_DISTANCE = 1e-3
"""Added to square distances of two methods, over the `error_scale`, before the
logarithm."""

SMALLEST_ANGLE = 1e-12  # solid angle by which shares of a component are taken, at least
SHALLOWEST = 1e-3
"""Added to the barrier of a pose, in radii, before its logarithm is taken."""


def scene_inputs(resting: RestingPoses, scene: DropScene) -> Array:
    """Restitution as -log(1 - r), and log of the drop height in radii (2,).

    Both are cut to the range of the fit.
    """
    return np.array(
        [
            -math.log1p(-min(scene.restitution, HIGHEST_RESTITUTION)),
            math.log(min(max(drop_radii(resting, scene), LOWEST_DROP), HIGHEST_DROP)),
        ]
    )


def drop_radii(resting: RestingPoses, scene: DropScene) -> float:
    """Drop height in radii of the part."""
    if scene.drop_height is None:
        return DEFAULT_DROP_RADII
    return scene.drop_height / resting.body.radius


def corner_inputs(resting: RestingPoses) -> Array:
    """Logarithms of how far the body turns in few corners, at two reaches (2,)."""
    return np.log(resting.corner_crowding + SMALLEST_CROWDING)


def rolling_inputs(resting: RestingPoses) -> Array:
    """How far the components of K splits are facets that the body rolls on (3 K, 2).

    The share of the facets of runs in the solid angle of a component's faces, and the
    mean over that angle of the log of how many facets their run has, 0 off all runs.
    """
    body = resting.body
    tree = resting.equilibria.arrays.tree
    joins = np.flatnonzero(resting.clusters.split)
    nodes = np.column_stack(
        (tree.child[joins], tree.level.shape[0] + 1 + joins)
    ).ravel()
    rolls = body.run_of_face >= 0
    if not rolls.any():
        return np.zeros((nodes.shape[0], 2))
    run = body.run_of_face[rolls]
    measures = np.zeros((rolls.shape[0], 3))
    measures[:, 0] = 1.0
    measures[rolls, 1] = 1.0
    measures[rolls, 2] = np.log(np.bincount(run)[run])
    measures *= body.arrays.angle[:, None]
    sums = np.concatenate((np.zeros((1, 3)), measures[tree.face_order].cumsum(axis=0)))
    begin, end = tree.face_range[tree.leaf_range[nodes]].T
    component_sums = sums[end] - sums[begin]
    return np.asarray(
        component_sums[:, 1:] / np.maximum(component_sums[:, :1], SMALLEST_ANGLE)
    )


def error_inputs(
    resting: RestingPoses,
    probability: Array,
    scene: DropScene,
    answers: Array,
    scale: Array,
) -> Array:
    """Inputs (M, 17) of `ErrorFit` for estimates (M, P) with their scales (M, P).

    The scale of an error must be above 0 for some pose of each. Scene; how far the
    methods are apart over the mean scale; the poses, their scales and barriers; then
    body and corners as `split` has them.
    """
    energy, modified, quasi_static = answers
    total = scale.sum(axis=1)
    # Of the estimate from MEAE, and of MEAE from NQSE, EAE and QSE.
    distance_squares = np.empty((len(total), 4))
    distance_squares[:, 0] = np.square(probability - modified).sum(axis=1)
    references = np.array((normalize(nonlinear(quasi_static)), energy, quasi_static))
    distance_squares[:, 1:] = np.square(modified - references).sum(axis=1)
    depth = np.log(np.minimum(resting.clusters.barrier, 1.0) + SHALLOWEST)
    inputs = np.empty((len(total), 17))
    inputs[:, 0] = -math.log1p(-scene.restitution)
    inputs[:, 1] = math.log(max(drop_radii(resting, scene), LOWEST_DROP))
    inputs[:, 2:6] = np.log(distance_squares / total[:, None] + SMALLEST_DISTANCE)
    inputs[:, 6] = math.log(scale.shape[1])
    inputs[:, 7] = [math.log(row_total) for row_total in total.tolist()]
    inputs[:, 8] = scalar_products(scale, depth) / total
    inputs[:, 9] = scalar_products(probability, depth)
    inputs[:, 10:15] = resting.shape_features
    inputs[:, 15:17] = corner_inputs(resting)
    return inputs


def scalar_products(rows: Array, vector: Array) -> Array:
    """Products (M,) of rows (M, P) with a vector (P,), each summed as by itself.

    A product of matrix and vector may round otherwise for other rows beside it.
    """
    return np.asarray((rows[:, None, :] @ vector[:, None])[:, 0, 0])


def error_scale(resting: RestingPoses, probability: Array, answers: Array) -> Array:
    """Scale of the square error (..., P): p (1 - p) plus the square distance from MEAE.

    The first is the square error of a single drop, the second is for an estimate that
    is certain and wrong. Poses that symmetry makes equal count as one in p (1 - p).
    """
    return np.asarray(
        single_drop_variance(resting, probability) + np.square(probability - answers[1])
    )


def reference_answers(resting: RestingPoses) -> Array:
    """Answers (3, P) of EAE, MEAE and QSE."""
    answers = np.array((eae(resting), meae(resting), qse(resting)))
    return share_in_groups(answers, resting.group)


def single_drop_variance(resting: RestingPoses, probability: Array) -> Array:
    """The product p (1 - p) of each pose (..., P).

    Poses that symmetry makes equal count as one, and share it evenly.
    """
    group = resting.group
    group_share = group_sums(probability, group).take(group, axis=-1)
    size = np.bincount(group)[group]
    return np.asarray(group_share * np.maximum(1.0 - group_share, 0.0) / (size * size))
