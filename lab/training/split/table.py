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

"""Samples as the arrays that a fit runs over."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lab.bodies.families import family_part, family_poses
from ros_pose_stats.core.estimators.split import kept_shares, split_inputs
from ros_pose_stats.core.records import Array, DropScene, Index
from ros_pose_stats.core.resting.poses import RestingPoses

from .samples import Sample

LEAST_DROPS = 50
MOST_UNSETTLED = 0.01
"""Samples with fewer settled drops, or with a larger share that met the step cap, are
left out.
"""


class Table(NamedTuple):
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

    def some(self, chosen: Index) -> Table:
        """Samples by their numbers."""
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
        )


def make_table(samples: Sequence[Sample]) -> Table:
    """Compute the inputs of all samples; a body takes some ten milliseconds."""
    inputs = []
    children = []
    leaf_pose = []
    kept = []
    share = []
    for row, resting, scene in scenes_of(samples):
        inputs.append(split_inputs(resting, scene).astype(np.float32))
        children.append(split_children(resting))
        leaf_pose.append(resting.clusters.node_pose)
        kept.append(kept_shares(resting)[resting.clusters.split])
        share.append(row.count / int(row.count.sum()))
    splits = np.array([len(links) for links in children])
    poses = np.array([shares.size for shares in share])
    return Table(
        np.concatenate(inputs),
        np.concatenate(children),
        np.concatenate(leaf_pose),
        np.concatenate(kept),
        splits,
        poses,
        _starts(splits),
        _starts(poses),
        np.concatenate(share),
    )


def scenes_of(
    samples: Iterable[Sample],
) -> Iterator[tuple[Sample, RestingPoses, DropScene]]:
    """Samples of which enough drops came to rest, each with its poses and its scene;
    those of a body follow each other and have the same poses.
    """
    for key, rows in groupby(samples, lambda row: row[:3]):
        resting = family_poses(key[0], family_part(*key))
        for row in rows:
            settled = int(row.count.sum())
            most_unsettled = MOST_UNSETTLED * (row.unsettled + settled)
            if settled >= LEAST_DROPS and row.unsettled <= most_unsettled:
                height = row.height * resting.body.radius
                yield row, resting, DropScene(row.restitution, height)


def _starts(numbers: Index) -> Index:
    """Where each of some rows of entries begins."""
    return np.concatenate(([0], np.cumsum(numbers)[:-1])).astype(np.int64)


def _rows(first: Index, count: Index) -> Index:
    """Places of all entries of some rows of entries."""
    return np.repeat(first - _starts(count), count) + np.arange(count.sum())


def split_children(resting: RestingPoses) -> Index:
    """Children (K, 2) of the splits, numbered within the part: leaves first, then
    splits.
    """
    tree = resting.equilibria.arrays.tree
    grouped = resting.clusters
    faces = resting.equilibria.order.shape[0]
    number = {node: position for position, node in enumerate(grouped.node.tolist())}
    joins = np.flatnonzero(grouped.split)
    number.update(
        {
            faces + int(join): len(grouped.node) + position
            for position, join in enumerate(joins)
        }
    )
    return np.array(
        [[number[int(child)] for child in tree.child[join]] for join in joins],
        dtype=np.int64,
    ).reshape(-1, 2)
