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

"""Gradient of the loss of the split estimator over many samples."""

import math
from typing import NamedTuple

import numpy as np

from ros_pose_stats.core.kernels.compilation import kernel
from ros_pose_stats.core.records import Array

from .table import Table

SMALLEST = 1e-300
"""Probability by which is divided, at least."""


class Work(NamedTuple):
    """Arrays for the tree of one sample; its N nodes are leaves, then splits by rising
    level.
    """

    grown: Array  # (N,) logarithm of what both children of a split have together
    passed: Array  # (N, 2) logarithm of what each child of a split has
    reached: Array  # (N,) logarithm of the share of the drops that come to a node
    slope: Array  # (N,) derivative of the loss by that
    pull: Array  # (N,) derivative of the loss by `grown`


@kernel
def loss_gradient(weight: Array, table: Table, square: float) -> Array:
    """Gradient (3 K,) of the mean loss of a sample.

    Parameters
    ----------
    weight : (3 K,) array
        Logarithms for both children and the whole of each split, by which is derived.
    table : Table
    square : float
        Weight of the square error beside the negative log likelihood of a drop.
    """
    gradient = np.zeros(weight.shape[0])
    nodes = 2 * table.splits.max() + 1
    work = Work(
        np.zeros(nodes),
        np.zeros((nodes, 2)),
        np.zeros(nodes),
        np.zeros(nodes),
        np.zeros(nodes),
    )
    for sample in range(table.splits.shape[0]):
        _climb(weight, table, sample, work)
        _descend(table, sample, work)
        _judge(table, sample, square, work)
        _pull_back(table, sample, work, gradient)
    return gradient


@kernel
def _climb(weight: Array, table: Table, sample: int, work: Work) -> None:
    """Weights of all splits of a sample, from the lowest up."""
    grown = work.grown
    passed = work.passed
    begin = table.first_split[sample]
    leaves = table.splits[sample] + 1
    for j in range(leaves - 1):
        for c in range(2):
            node = table.children[begin + j, c]
            passed[j, c] = weight[3 * (begin + j) + c]
            if node >= leaves:
                passed[j, c] += table.kept[begin + j, c] * (
                    grown[node] - weight[3 * (begin + node - leaves) + 2]
                )
        high = max(passed[j, 0], passed[j, 1])
        low = min(passed[j, 0], passed[j, 1])
        grown[leaves + j] = high + math.log1p(math.exp(low - high))


@kernel
def _descend(table: Table, sample: int, work: Work) -> None:
    """Shares of all nodes of a sample, from the whole down."""
    reached = work.reached
    begin = table.first_split[sample]
    leaves = table.splits[sample] + 1
    reached[2 * leaves - 2] = 0.0
    for j in range(leaves - 2, -1, -1):
        node = leaves + j
        for c in range(2):
            reached[table.children[begin + j, c]] = (
                reached[node] + work.passed[j, c] - work.grown[node]
            )


@kernel
def _judge(table: Table, sample: int, square: float, work: Work) -> None:
    """Derivatives by the leaves of a sample: several may be one pose."""
    leaf = table.first_split[sample] + sample
    leaves = table.splits[sample] + 1
    probability = np.zeros(table.poses[sample])
    for i in range(leaves):
        probability[table.leaf_pose[leaf + i]] += math.exp(work.reached[i])
    for i in range(leaves):
        pose = table.leaf_pose[leaf + i]
        p = max(probability[pose], SMALLEST)
        counted = table.share[table.first_pose[sample] + pose]
        work.slope[i] = (
            (2.0 * square * (p - counted) - counted / p)
            * math.exp(work.reached[i])
            / table.splits.shape[0]
        )


@kernel
def _pull_back(table: Table, sample: int, work: Work, gradient: Array) -> None:
    """Derivatives by the weights of a sample, from those by its leaves."""
    slope = work.slope
    pull = work.pull
    begin = table.first_split[sample]
    leaves = table.splits[sample] + 1
    for j in range(leaves - 1):
        first, second = table.children[begin + j]
        slope[leaves + j] = slope[first] + slope[second]
        pull[leaves + j] = 0.0
    for j in range(leaves - 2, -1, -1):
        remainder = pull[leaves + j] - slope[leaves + j]
        for c in range(2):
            node = table.children[begin + j, c]
            share = math.exp(work.passed[j, c] - work.grown[leaves + j])
            change = slope[node] + share * remainder
            gradient[3 * (begin + j) + c] += change
            if node >= leaves:
                pull[node] = change * table.kept[begin + j, c]
                gradient[3 * (begin + node - leaves) + 2] -= pull[node]
