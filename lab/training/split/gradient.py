"""Loss of the split estimator over many samples, and its gradient, in one pass."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.kernels.compilation import kernel

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SMALLEST = 1e-300


@kernel
def tree_loss(
    weight: Array,
    first_split: Index,
    splits: Index,
    first_pose: Index,
    poses: Index,
    children: Index,
    leaf_pose: Index,
    kept: Array,
    share: Array,
    square: float,
    gradient: bool,
) -> tuple[float, Array, Array]:
    """Mean loss of a sample, its gradient by the weights, and the probabilities.

    Parameters
    ----------
    weight : (3 K,) array
        Logarithms for both children and the whole of each split.
    first_split, splits, first_pose, poses, children, leaf_pose, kept, share
        As in `Table`.
    square : float
        Weight of the square error beside the negative log likelihood of a drop.
    gradient : bool
        Whether to compute the gradient; else it is 0.

    Returns
    -------
    loss : float
    slopes : (3 K,) array
    probability : (P,) array
    """
    samples = splits.shape[0]
    slopes = np.zeros(weight.shape[0])
    probability = np.zeros(share.shape[0])
    longest = 2 * splits.max() + 1
    grown = np.zeros(longest)
    log = np.zeros(longest)
    adjoint = np.zeros(longest)
    pull = np.zeros(longest)
    passed = np.zeros((longest, 2))
    loss = 0.0
    for u in range(samples):
        count = splits[u]
        begin = first_split[u]
        pose = first_pose[u]
        leaves = count + 1
        leaf = first_split[u] + u
        for j in range(count):
            for c in range(2):
                node = children[begin + j, c]
                passed[j, c] = weight[3 * (begin + j) + c]
                if node >= leaves:
                    passed[j, c] += kept[begin + j, c] * (
                        grown[node] - weight[3 * (begin + node - leaves) + 2]
                    )
            high = max(passed[j, 0], passed[j, 1])
            low = min(passed[j, 0], passed[j, 1])
            grown[leaves + j] = high + math.log1p(math.exp(low - high))
        log[leaves + count - 1] = 0.0
        for j in range(count - 1, -1, -1):
            for c in range(2):
                log[children[begin + j, c]] = (
                    log[leaves + j] + passed[j, c] - grown[leaves + j]
                )
        for i in range(leaves):
            probability[pose + leaf_pose[leaf + i]] += math.exp(log[i])
        for i in range(pose, pose + poses[u]):
            p = max(probability[i], SMALLEST)
            counted = share[i]
            loss += (square * (p - counted) ** 2 - counted * math.log(p)) / samples
        for i in range(leaves):
            leaf_index = pose + leaf_pose[leaf + i]
            p = max(probability[leaf_index], SMALLEST)
            counted = share[leaf_index]
            adjoint[i] = (
                (2.0 * square * (p - counted) - counted / p)
                * math.exp(log[i])
                / samples
            )
        if not gradient:
            continue
        for j in range(count):
            adjoint[leaves + j] = (
                adjoint[children[begin + j, 0]] + adjoint[children[begin + j, 1]]
            )
            pull[leaves + j] = 0.0
        for j in range(count - 1, -1, -1):
            remainder = pull[leaves + j] - adjoint[leaves + j]
            for c in range(2):
                node = children[begin + j, c]
                change = (
                    adjoint[node]
                    + math.exp(passed[j, c] - grown[leaves + j]) * remainder
                )
                slopes[3 * (begin + j) + c] += change
                if node >= leaves:
                    pull[node] = change * kept[begin + j, c]
                    slopes[3 * (begin + node - leaves) + 2] -= pull[node]
    return loss, slopes, probability
