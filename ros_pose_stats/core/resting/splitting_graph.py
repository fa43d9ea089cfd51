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

"""The splitting graph of section 4.D: how the reachable set falls apart."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..records import Array, StablePose
from .convex_body import foot_directions
from .poses import RestingPoses

Function = Literal["r", "R"]

SAME_LEVEL = 1e-6
"""Splits closer than this, as a fraction of their level, are one split into several."""


@dataclass(frozen=True, eq=False)
class SplittingNode:
    """A connected component of the reachable set.

    A shelf may part from the others before its pose does: then both parts hold that
    pose.
    """

    poses: tuple[int, ...]  # `index` of the stable poses that it holds
    probability: float  # probability that the part passes through this component
    # critical value at which it falls apart, metres; None for a single pose
    level: float | None = None
    # (3,); direction, in the part frame, of the saddle where it falls apart
    saddle: Array | None = None
    # the two components that it falls into; empty for a single pose
    parts: "tuple[SplittingNode, ...]" = ()
    # their centroid solid angles at that level, steradians (Omega in Eq. 8)
    angles: tuple[float, ...] = ()
    transitions: tuple[float, ...] = ()  # their transition probabilities (Eq. 8)

    def walk(self) -> "Iterator[SplittingNode]":
        """Yield the node and all nodes below it, from the top down."""
        stack = [self]
        while stack:
            node = stack.pop()
            yield node
            stack.extend(reversed(node.parts))

    def __str__(self) -> str:
        lines: list[str] = []
        stack: list[tuple[SplittingNode, int]] = [(self, 0)]
        while stack:
            node, depth = stack.pop()
            names = " ".join(str(i) for i in node.poses)
            text = f"{'  ' * depth}{{{names}}}  p = {node.probability:.4f}"
            if node.level is not None:
                sizes = " : ".join(f"{angle:.4f}" for angle in node.angles)
                text += f"  splits at {node.level * 1e3:.4g} mm, {sizes} sr"
            lines.append(text)
            stack.extend((part, depth + 1) for part in reversed(node.parts))
        return "\n".join(lines)


def splitting_graph(resting: RestingPoses, function: Function = "r") -> SplittingNode:
    """Splitting graph of a part, from the component that holds every pose down.

    Parameters
    ----------
    resting : RestingPoses
    function : {'r', 'R'}
        Whose level sets are measured: R gives the energy absorption estimator, r the
        modified one. The splits and their levels are the same for both.

    Returns
    -------
    SplittingNode
        The root.
    """
    equilibria = resting.equilibria
    clusters = resting.clusters
    tree = equilibria.arrays.tree
    leaves = equilibria.order.shape[0]
    areas, probability = resting.passage_R if function == "R" else resting.passage_r
    nodes: dict[int, SplittingNode] = {
        node: SplittingNode((pose,), float(probability[node]))
        for node, pose in zip(
            clusters.node.tolist(), clusters.node_pose.tolist(), strict=True
        )
    }
    for j in np.flatnonzero(clusters.split).tolist():
        parts = tuple(nodes.pop(int(child)) for child in tree.child[j])
        total = float(areas[j].sum())
        angles = tuple(areas[j].tolist())
        shares = tuple(angle / total if total > 0.0 else 0.5 for angle in angles)
        nodes[leaves + j] = SplittingNode(
            tuple(sorted({*parts[0].poses, *parts[1].poses})),
            float(probability[leaves + j]),
            float(tree.level[j]) * resting.body.radius,
            foot_directions(resting.body, tree.side[j : j + 1])[0],
            parts,
            angles,
            shares,
        )
    (root,) = nodes.values()
    return root


def with_shares(root: SplittingNode, poses: Sequence[StablePose]) -> SplittingNode:
    """The splitting graph with probabilities by any method, such as shares of drops.

    A shelf that parts from its pose before is left out: no drop tells which it went
    through.
    """
    share = {pose.index: pose.probability for pose in poses if pose.probability > 0.0}
    poses_of = {id(root): root.poses}
    nodes = list(root.walk())
    for node in nodes:
        if not node.parts:
            continue
        part_of = {pose: _part_with_pose(node, pose) for pose in poses_of[id(node)]}
        for part in node.parts:
            poses_of[id(part)] = tuple(
                pose for pose, home in part_of.items() if home is part
            )
    rebuilt: dict[int, SplittingNode] = {}
    for node in reversed(nodes):
        names = poses_of[id(node)]
        parts = tuple(
            rebuilt.pop(id(part)) for part in node.parts if id(part) in rebuilt
        )
        if len(parts) == 1:
            rebuilt[id(node)] = parts[0]
        elif names:
            total = sum(share.get(pose, 0.0) for pose in names)
            rebuilt[id(node)] = replace(
                node,
                poses=names,
                probability=total,
                parts=parts,
                transitions=tuple(
                    child.probability / total if total else 0.0 for child in parts
                ),
            )
    return rebuilt[id(root)]


def _part_with_pose(node: SplittingNode, pose: int) -> SplittingNode:
    """The part a pose goes on into: of two with it, the one that is no mere shelf."""
    return max(
        (part for part in node.parts if pose in part.poses),
        key=lambda part: (len(part.poses), part.probability),
    )


def levels_above(root: SplittingNode, pose: int) -> list[tuple[float, tuple[int, ...]]]:
    """Splits from the top down to a pose: levels (metres), and the poses left below.

    Empty where the graph does not have the pose.
    """
    levels: list[tuple[float, tuple[int, ...]]] = []
    node = root
    while node.level is not None and pose in node.poses:
        level = node.level
        node = _part_with_pose(node, pose)
        if levels and levels[-1][0] - level < SAME_LEVEL * level:
            levels[-1] = levels[-1][0], node.poses
        else:
            levels.append((level, node.poses))
    return levels


def poses_within(
    levels: Sequence[tuple[float, tuple[int, ...]]],
    energy: float,
    all_poses: Sequence[int],
) -> tuple[int, ...]:
    """Poses that can still be reached at an energy over weight (metres)."""
    return [tuple(all_poses), *(poses for level, poses in levels if energy < level)][-1]
