"""Samples as the arrays that a fit runs over."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.estimators.expected import expected_error
from ros_pose_stats.core.estimators.split import kept_shares, split_inputs
from ros_pose_stats.core.records import DropScene
from ros_pose_stats.core.resting.poses import RestingPoses

from ..families import family_options, family_part, family_poses
from .samples import Sample

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LEAST_DROPS = 50
MOST_UNSETTLED = 0.01
"""Samples with fewer settled drops, or with a larger share that met the step cap, are left out."""

REFERENCES = ("combined", "meae")


@dataclass(frozen=True, eq=False)
class Table:
    """Samples as arrays; U samples with P poses and 3 K components in all.

    A pose may be several leaves of the tree, of which there are K + U.
    """

    inputs: NDArray[np.float32]  # (3 K, 26), as from `split_inputs`
    children: (
        Index  # (K, 2), numbered in each sample: leaves, then splits by rising level
    )
    leaf_pose: Index  # (K + U,) pose of each leaf, from 0 in each sample
    kept: Array  # (K, 2), as from `kept_shares`
    splits: Index  # (U,) number of splits of a sample
    poses: Index  # (U,) and of its poses
    first_split: Index  # (U,) where they begin
    first_pose: Index
    share: Array  # (P,) count over settled drops
    across: Array  # (P,) how far curves to rock on lie across the pose
    settled: Array  # (P,) of the sample that a pose belongs to, like what follows
    restitution: Array
    height: Array
    body: Index
    family: NDArray[np.str_]
    expected: Array  # by the shipped weights, a fraction
    reference: dict[str, Array]  # (P,) each; of the paper

    def error(
        self, probability: Array, where: NDArray[np.bool_] | slice = slice(None)
    ) -> float:
        """Root mean square error over the poses in points, the drops' noise taken off."""
        noise = self.share * (1.0 - self.share) / (self.settled - 1.0)
        squares = ((probability - self.share) ** 2 - noise)[where]
        return 100.0 * math.sqrt(max(float(squares.mean()), 0.0))

    def some(self, which: Index | NDArray[np.bool_]) -> Table:
        """Samples by their numbers, or those (U,) that are true."""
        samples = np.arange(self.splits.shape[0])
        chosen = samples[which]
        splits = self.splits[chosen]
        poses = self.poses[chosen]
        split = _rows(self.first_split[chosen], splits)
        pose = _rows(self.first_pose[chosen], poses)
        leaf = _rows(self.first_split[chosen] + chosen, splits + 1)
        return Table(
            self.inputs.reshape(-1, 3, self.inputs.shape[1])[split].reshape(
                -1, self.inputs.shape[1]
            ),
            self.children[split],
            self.leaf_pose[leaf],
            self.kept[split],
            splits,
            poses,
            _starts(splits),
            _starts(poses),
            self.share[pose],
            self.across[pose],
            self.settled[pose],
            self.restitution[pose],
            self.height[pose],
            self.body[pose],
            self.family[pose],
            self.expected[pose],
            {name: one[pose] for name, one in self.reference.items()},
        )


def make_table(samples: Sequence[Sample], compared: bool = True) -> Table:
    """Compute the inputs of all samples; a body takes some ten milliseconds.

    Unless they are to be compared, there are no references, and expected errors are NaN.
    """
    inputs = []
    children = []
    leaf_pose = []
    kept = []
    poses: dict[str, list[Array]] = {
        name: []
        for name in (
            "share",
            "across",
            "settled",
            "restitution",
            "height",
            "body",
            "family",
            "expected",
        )
    }
    reference: dict[str, list[Array]] = {name: [] for name in REFERENCES if compared}
    for body, (key, scenes) in enumerate(groupby(samples, lambda row: row[:3])):
        tolerance, sides = family_options(key[0])
        resting = family_poses(key[0], family_part(*key))
        links = split_children(resting)
        shares = kept_shares(resting)[resting.clusters.split]
        for row in scenes:
            if not usable(row):
                continue
            settled = int(row.count.sum())
            scene = DropScene(
                row.restitution, row.height * resting.body.radius, tolerance, sides
            )
            inputs.append(split_inputs(resting, scene).astype(np.float32))
            children.append(links)
            leaf_pose.append(resting.clusters.node_pose)
            kept.append(shares)
            told = {
                "share": row.count / settled,
                "across": resting.curves[1],
                "settled": settled,
                "body": body,
                "restitution": row.restitution,
                "height": row.height,
                "family": key[0],
                "expected": _expected(resting, scene) if compared else math.nan,
            }
            for name, value in told.items():
                poses[name].append(np.broadcast_to(value, row.count.shape))
            for name, values in reference.items():
                values.append(ESTIMATORS[name].function(resting, scene))
    splits = np.array([len(one) for one in children])
    count = poses["share"]
    each = np.array([one.size for one in count])
    return Table(
        np.concatenate(inputs),
        np.concatenate(children),
        np.concatenate(leaf_pose),
        np.concatenate(kept),
        splits,
        each,
        _starts(splits),
        _starts(each),
        **{name: np.concatenate(values) for name, values in poses.items()},
        reference={name: np.concatenate(values) for name, values in reference.items()},
    )


def _starts(numbers: Index) -> Index:
    """Where each of some rows of entries begins."""
    return np.concatenate(([0], np.cumsum(numbers)[:-1])).astype(np.int64)


def _rows(first: Index, count: Index) -> Index:
    """Places of all entries of some rows of entries."""
    return np.repeat(first - _starts(count), count) + np.arange(count.sum())


def usable(row: Sample) -> bool:
    """Whether enough of a sample's drops came to rest."""
    settled = int(row.count.sum())
    return settled >= LEAST_DROPS and row.unsettled <= MOST_UNSETTLED * (
        row.unsettled + settled
    )


def _expected(resting: RestingPoses, scene: DropScene) -> float:
    told = ESTIMATORS["split"].function(resting, scene)
    return expected_error("split", resting, told, scene).here


def split_children(resting: RestingPoses) -> Index:
    """Children (K, 2) of the splits, numbered within the part: leaves first, then splits."""
    tree = resting.equilibria.arrays.tree
    grouped = resting.clusters
    faces = resting.equilibria.order.shape[0]
    number = {node: place for place, node in enumerate(grouped.node.tolist())}
    joins = np.flatnonzero(grouped.split)
    number.update(
        {
            faces + int(join): len(grouped.node) + place
            for place, join in enumerate(joins)
        }
    )
    return np.array(
        [[number[int(child)] for child in tree.child[join]] for join in joins],
        dtype=np.int64,
    ).reshape(-1, 2)
