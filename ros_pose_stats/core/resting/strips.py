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

"""Strips: the facets of a hull between two rims about one axis, or a rim and a tip.

They are those of one cylinder, cone or toothed surface.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..kernels.body.convex_body import BodyArrays
from ..mesh.arrays import mask_of
from ..mesh.vectors import components_along
from ..records import Array, Index, Mask
from .rims import ON_AXIS, Chain, Group, distance_from_axis, loops_of
from .teeth import join_toothed_facets

# A corner this close to the cone between two rims, in radii, is on it
ON_LATERAL = 1e-4


def number_strips(
    points: Array, arrays: BodyArrays, groups: Sequence[Group], chains: Sequence[Chain]
) -> Index:
    """Strip (F,) of each face between two runs about one axis, or a run and a tip.

    -1 for none.
    """
    strip_of_face = np.full(len(arrays.area), -1, dtype=np.int64)
    count = 0
    for number, group in enumerate(groups):
        group_chains = [chain for chain in chains if chain.rim.group == number]
        positions = _rim_positions(points, arrays, group, group_chains)
        count = _number_facets(
            arrays, positions, len(group_chains), strip_of_face, count
        )
        is_divided = strip_of_face < 0
        is_divided &= np.logical_or.reduceat(
            (positions.rim < 0)[arrays.corner], arrays.face_start[:-1]
        )
        if is_divided.any():
            count = _number_divided_facets(
                points, arrays, group, group_chains, is_divided, strip_of_face, count
            )
        count = join_toothed_facets(
            points, arrays, group, group_chains, strip_of_face, count
        )
    return strip_of_face


class _RimPositions(NamedTuple):
    """Where each point (N,) is on the rims about one axis."""

    rim: Index  # number of its chain; of a tip that of chains; -1 off all of them
    position: Index  # in its chain; -1 for none
    size: Index  # of its chain where that is closed, else -1


def _rim_positions(
    points: Array, arrays: BodyArrays, group: Group, chains: Sequence[Chain]
) -> _RimPositions:
    positions = _RimPositions(*np.full((3, len(points)), -1, dtype=np.int64))
    positions.rim[distance_from_axis(points, group) < ON_AXIS] = len(chains)
    is_corner = mask_of(arrays.corner, len(points))
    for k, chain in enumerate(chains):
        corners = chain.point[is_corner[chain.point]]
        positions.rim[corners] = k
        positions.position[corners] = np.arange(len(corners))
        positions.size[corners] = len(corners) if chain.rim.is_closed else -1
    return positions


def _number_facets(
    arrays: BodyArrays,
    positions: _RimPositions,
    chains: int,
    strip_of_face: Index,
    count: int,
) -> int:
    """Number strips of facets from rim to rim from `count` on, in place.

    Return the next number.
    """
    faces = np.flatnonzero(np.bincount(arrays.face[positions.rim[arrays.corner] >= 0]))
    corner, begin = loops_of(arrays, faces)
    sizes = np.diff(begin, append=len(corner))
    next_corner = np.append(corner[1:], corner[:1])
    next_corner[begin + sizes - 1] = corner[begin]
    rim = positions.rim[corner]
    low = np.minimum.reduceat(rim, begin)
    high = np.maximum.reduceat(rim, begin)
    # Corners are on two rims, and sides along a rim are sides of its polygon.
    fits = (rim == np.repeat(low, sizes)) | (rim == np.repeat(high, sizes))
    step = np.abs(positions.position[corner] - positions.position[next_corner])
    fits &= (
        (rim != positions.rim[next_corner])
        | (step == 1)
        | (step == positions.size[corner] - 1)
    )
    is_strip = np.logical_and.reduceat(fits, begin) & (low >= 0) & (low < high)
    if not is_strip.any():
        return count
    pair = low[is_strip] * (chains + 1) + high[is_strip]
    numbers = np.unique(pair, return_inverse=True)[1]
    strip_of_face[faces[is_strip]] = count + numbers
    return count + int(numbers.max()) + 1


def _number_divided_facets(
    points: Array,
    arrays: BodyArrays,
    group: Group,
    chains: Sequence[Chain],
    is_divided: Mask,
    strip_of_face: Index,
    count: int,
) -> int:
    """The same of facets with corners between their rims, as teeth that wind have."""
    radius = distance_from_axis(points, group)
    height = components_along(points - group.center, group.frame[2])
    rim_heights = [height[chain.point].mean() for chain in chains]
    for k, j in pairwise(np.argsort(rim_heights, kind="stable").tolist()):
        rise = rim_heights[j] - rim_heights[k]
        if rise < ON_LATERAL:
            continue
        share = (height - rim_heights[k]) / rise
        cone_radius = chains[k].rim.radius + share * (
            chains[j].rim.radius - chains[k].rim.radius
        )
        on_cone = (np.abs(radius - cone_radius) < ON_LATERAL) & (
            np.abs(share - 0.5) < 0.5 + ON_LATERAL
        )
        between_rims = np.logical_and.reduceat(
            on_cone[arrays.corner], arrays.face_start[:-1]
        )
        if not (between_rims & is_divided).any():
            continue
        strip = int(strip_of_face[between_rims].max())
        if strip < 0:
            strip = count
            count += 1
        strip_of_face[between_rims & is_divided] = strip
    return count
