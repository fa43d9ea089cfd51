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

"""Room on a plate for parts that lie anywhere and may block each other."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..records import Array, Index, Mask, Part, StablePose
from ..resting.outlines import area_and_length, outline_at

EDGE_NODES = 6
DIRECTIONS = 96
"""Nodes along half a side of the plate, and directions in which its edge is looked
for."""

GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # turns by it are spread evenly
RASTER_NODES = 97
TURNS = 32
"""Nodes along a side of the raster on which true silhouettes meet, and ways in which
another part lies: enough for the fill of real outlines to a percent or two
(docs/measured/benchmarks.md)."""

MOST_OUTLINED = 16
"""Kinds of picked poses, the likeliest; others are taken for their mean."""


class PlateFill(NamedTuple):
    """Room on a plate for parts that lie in given shares in their poses."""

    # (K, Q); where another part's centre blocks a part in each pose at each node, over
    # the plate
    blocked: Array
    weight: Array  # (Q,); of the nodes, 1 in all

    def free_probability(self, parts: Index) -> Array:
        """Probabilities (N, K) that no other part blocks one, by the parts (N,)."""
        other_parts = parts[:, None, None] - 1.0
        return (1.0 - self.blocked) ** other_parts @ self.weight


def plate_fill(
    outlines: Sequence[Array],
    shares: Array,
    plate: tuple[float, float],
    clearance: float,
    blocking: Array | float = 1.0,
) -> PlateFill:
    """Room on a plate, `plate` metres, over which the parts' centres spread evenly.

    Parts lie anywhere and turned anyhow, each by itself, as in D. Gudmundsson and K.
    Goldberg, "Tuning robotic part feeder parameters to maximize throughput" (ICRA
    1997). `outlines`: convex silhouettes (k, 2) of the poses (K,), metres; `shares`
    (K,): of the parts that lie in each. A part is blocked where another one is nearer
    than the clearance. Over their turns, centres that are too near have the mean area
    A_i + A_j + L_i L_j / 2 pi of outlines of area A and length L, one of them grown by
    the clearance; of that the share `blocking` (K,) is taken as a disc and cut off at
    the edges of the plate.
    """
    area, length = np.array([area_and_length(outline) for outline in outlines]).T
    blocked_area = area + clearance * length + np.pi * clearance * clearance
    mean_width = (length + 2.0 * np.pi * clearance) / (2.0 * np.pi)
    mean_area = blocked_area + shares @ area + mean_width * (shares @ length)
    square_radius = blocking * mean_area / np.pi

    node, weight = np.polynomial.legendre.leggauss(EDGE_NODES)
    sides = ((1.0 + node) * 0.25 * side for side in plate)
    position = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 1, 2)
    angle = (np.arange(DIRECTIONS) + 0.5) * (2.0 * np.pi / DIRECTIONS)
    direction = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    room = np.where(direction > 0.0, np.asarray(plate) - position, position)
    edge_square = (room / np.abs(direction)).min(axis=-1) ** 2
    inside_square = np.minimum(square_radius[:, None, None], edge_square)
    blocked_inside = np.pi * inside_square.mean(axis=-1)
    blocked: Array = np.minimum(1.0, blocked_inside / (plate[0] * plate[1]))
    return PlateFill(
        blocked, np.asarray(0.25 * np.outer(weight, weight).ravel(), np.float64)
    )


def blocking_with_bays(
    part: Part,
    poses: Sequence[StablePose],
    shares: Array,
    picked_poses: Index,
    clearance: float,
) -> Array:
    """Share (K,) of the blocked area that is left with silhouettes as they are.

    Blocked is what convex silhouettes block. Of poses that are not picked it is 1. The
    other part lies in its poses by their shares, and turned evenly; areas are counted
    on a raster, on which both kinds err alike.
    """
    from scipy import ndimage, signal  # slow to load, and only bays need them

    _, first_of_group, group = np.unique(
        [pose.group for pose in poses], return_index=True, return_inverse=True
    )
    share_steps = shares.sum() * (np.arange(TURNS) + 0.5) / TURNS
    other_pose = np.searchsorted(shares.cumsum(), share_steps).clip(max=len(poses) - 1)
    # Of poses that look alike the first stands for all.
    picked_group = first_of_group[group[picked_poses]]
    other_pose = first_of_group[group[other_pose]]
    kinds = sorted(set(picked_group.tolist()), key=lambda index: -shares[index])
    kinds = kinds[:MOST_OUTLINED]
    hulls = {index: [poses[index].outline] for index in {*kinds, *other_pose.tolist()}}
    # What has no width has no outline of its own.
    outlines = {
        index: [ring for polygon in outline_at(part, poses[index]) for ring in polygon]
        or hull
        for index, hull in hulls.items()
    }
    reach = clearance + max(np.hypot(*pose.outline.T).max() for pose in poses)
    # No node lies on the axes, to which parts are symmetric.
    spacing = 2.0 * reach / (RASTER_NODES - 1)
    node = (np.arange(RASTER_NODES) - 0.5 * RASTER_NODES + GOLDEN) * spacing

    def count_blocked(silhouettes: Mapping[int, Sequence[Array]]) -> Array:
        """Nodes (kinds,) at which the centre of a part is too near, in all turns."""
        angles = 2.0 * np.pi * GOLDEN * np.arange(TURNS)
        lying_parts = [
            _cover_raster(silhouettes[index], angle, node)[::-1, ::-1].astype(float)
            for index, angle in zip(other_pose, angles, strict=True)
        ]
        counts = np.zeros(len(kinds))
        for number, index in enumerate(kinds):
            distance = ndimage.distance_transform_edt(
                ~_cover_raster(silhouettes[index], 0.0, node),
                sampling=node[1] - node[0],
            )
            for lying_part in lying_parts:
                overlap = signal.fftconvolve(distance <= clearance, lying_part)
                counts[number] += np.count_nonzero(overlap > 0.5)
        return counts

    share = count_blocked(outlines) / count_blocked(hulls)
    share_of_kind = dict(zip(kinds, share.tolist(), strict=True))
    blocking = np.ones(len(poses))
    blocking[picked_poses] = [
        share_of_kind.get(index, share.mean()) for index in picked_group.tolist()
    ]
    return blocking


def _cover_raster(rings: Sequence[Array], turn: float, node: Array) -> Mask:
    """Nodes (y, x) of a raster that turned rings (k, 2) enclose or come near."""
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    rings = [ring @ rotation for ring in rings]
    begin = np.concatenate(rings)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    row, edge = np.nonzero((begin[:, 1] > node[:, None]) != (end[:, 1] > node[:, None]))
    (x, y), (run, rise) = begin[edge].T, (end - begin)[edge].T
    crossings = np.zeros((node.size, node.size + 1), dtype=np.int64)
    np.add.at(
        crossings, (row, np.searchsorted(node, x + (node[row] - y) * run / rise)), 1
    )
    is_covered = crossings.cumsum(axis=1)[:, :-1] % 2 == 1
    # What is thinner than the raster is not lost.
    edges = begin + np.linspace(0.0, 1.0, 2 * RASTER_NODES)[:, None, None] * (
        end - begin
    )
    x, y = np.rint((edges - node[0]) / (node[1] - node[0])).astype(int).reshape(-1, 2).T
    is_covered[y, x] = True
    return np.asarray(is_covered)
