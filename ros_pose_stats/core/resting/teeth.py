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

"""Toothed surfaces whose corners are not in one chain of edges.

Where the tips of teeth are rounded, several corners lie side by side on each, and the
way that goes straightest on from one leads along the tooth: the runs of such a gear end
after some teeth, or there are none. About an axis that other runs tell, its corners
still lie on circles, and the facets between two of these are one strip.
"""

from collections.abc import Sequence

import numpy as np

from ..kernels.body.circles import ON_CIRCLE
from ..kernels.body.convex_body import BodyArrays
from ..kernels.body.runs import FEWEST, HALF_SPAN
from ..kernels.sorting import number_ties
from ..mesh.arrays import mask_of
from ..mesh.vectors import components_along, cross, length
from ..records import Array, Index, Mask
from .rims import Chain, Group, distance_from_axis

TURN = 2.0 * np.pi
HALF_TOOTH = np.arcsin(HALF_SPAN)  # half of the angle that an edge of a run may span
LEAST_ARC = np.radians(90.0)
"""Angle over which teeth follow each other on a circle."""


def join_toothed_facets(
    points: Array,
    arrays: BodyArrays,
    group: Group,
    chains: Sequence[Chain],
    strip_of_face: Index,
    count: int,
) -> int:
    """Number the facets between circles of teeth from `count` on, in place.

    Strips that have some of such facets, of runs that end between the teeth, are theirs
    altogether. Return the next number.
    """
    round_points = [chain.point for chain in chains if chain.rim.kind == "round"]
    circle = _circles(points, arrays, group, round_points)
    if circle.max() < len(round_points):
        return count
    corner_circle = circle[arrays.corner]
    begin = arrays.face_start[:-1]
    low = np.minimum.reduceat(corner_circle, begin)
    high = np.maximum.reduceat(corner_circle, begin)
    is_between = (low >= 0) & (low < high) & (high >= len(round_points))
    sides = np.flatnonzero(is_between[arrays.face])
    side_face = arrays.face[sides]
    is_off = corner_circle[sides] != low[side_face]
    is_off &= corner_circle[sides] != high[side_face]
    is_off |= _turns_off(points[arrays.corner[sides]], arrays.normal[side_face], group)
    is_between[side_face[is_off]] = False
    faces = np.flatnonzero(is_between)
    pairs = low[faces] * len(points) + high[faces]
    for pair in np.unique(pairs).tolist():
        pair_faces = faces[pairs == pair]
        partial_strips = np.unique(strip_of_face[pair_faces])
        partial_strips = partial_strips[partial_strips >= 0]
        strip_of_face[np.isin(strip_of_face, partial_strips)] = count
        strip_of_face[pair_faces] = count
        count += 1
    return count


def _circles(
    points: Array, arrays: BodyArrays, group: Group, round_points: Sequence[Index]
) -> Index:
    """Circle (N,) about the axis that each corner is on, -1 for none.

    Those of round rims come first.
    """
    circle = np.full(len(points), -1, dtype=np.int64)
    is_free = mask_of(arrays.corner, len(points))
    for rim, rim_points in enumerate(round_points):
        circle[rim_points] = rim
        is_free[rim_points] = False
    corners = np.flatnonzero(is_free)
    reach = max(rim.radius for rim in group.rims)
    offset = length(cross(group.center, group.frame[2]))
    if len(corners) <= FEWEST or offset > reach:
        return circle
    radius = distance_from_axis(points[corners], group)
    height = components_along(points[corners] - group.center, group.frame[2])
    slack = ON_CIRCLE * float(radius.max())
    # From the outermost on, for teeth are rounded inwards.
    outermost = np.argsort(-radius, kind="stable")
    none_before = np.zeros(len(corners), dtype=np.int64)
    ring = number_ties(-radius, slack, none_before, outermost)[0]
    order = np.lexsort((height, ring))
    is_next = (np.diff(ring[order]) > 0) | (np.diff(height[order]) > slack)
    level = np.empty(len(corners), dtype=np.int64)
    level[order] = np.append(0, np.cumsum(is_next))
    toothed_arc = _toothed_arcs(group.angles(points[corners]), level)
    is_toothed = toothed_arc >= LEAST_ARC
    number = np.where(is_toothed, len(round_points) + np.cumsum(is_toothed) - 1, -1)
    circle[corners] = number[level]
    return circle


def _toothed_arcs(angle: Array, level: Index) -> Array:
    """Longest way round (L,) on each level with neighbours as near as teeth are."""
    twice = np.concatenate((angle, angle + TURN))  # a way may lead over the seam
    level_twice = np.concatenate((level, level))
    order = np.lexsort((twice, level_twice))
    step = np.diff(twice[order])
    is_far = (np.diff(level_twice[order]) > 0) | (step > 2.0 * HALF_TOOTH)
    way = np.cumsum(is_far)
    arcs = np.bincount(way[~is_far], step[~is_far], int(way.max()) + 1)
    longest_arc = np.zeros(int(level.max()) + 1)
    np.maximum.at(longest_arc, level_twice[order][1:], arcs[way])
    return longest_arc


def _turns_off(corners: Array, normals: Array, group: Group) -> Mask:
    """Which corners (k, 3) are farther round than half of a run's edge from normals."""
    angle = group.angles(corners) - group.angles(normals + group.center)
    turn = np.abs(angle - TURN * np.rint(angle / TURN))
    return np.asarray(turn > HALF_TOOTH)
