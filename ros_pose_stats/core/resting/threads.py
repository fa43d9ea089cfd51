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

"""Threads: surfaces that wind about an axis, and count as what they wind on.

However a file cuts a thread into triangles, edges lead along its helices: their ends
are equally far from the axis, and they rise by one lead a radian. Normals of facets
tell it worse, for they lean by how the strips between two helices are cut.
"""

from typing import NamedTuple

import numpy as np

from ..kernels.features.surface_features import AREA, NORMAL, Surface
from ..mesh.vectors import components_along, cross, lengths
from ..records import Array, Mask

FEWEST_TURNS = 2.0
FEWEST_FACETS = 64
"""Of a thread."""

SAME_RADIUS = 1e-3
"""Share of its radius by which the ends of an edge along a helix may differ in it."""

FLATTEST_LEAD = 0.004
STEEPEST_LEAD = 0.3
"""Tangents of the angles at which threads wind: 0.02 of an M30 with a fine pitch, and
0.2 of a lead screw; fine divisions tell smaller ones from none."""

NEAR_LEAD = 0.2
"""How far the rise of an edge along a helix may be off, as its share."""

SMALLEST = 1e-9  # distance from the axis that is none, in radii

SECTORS = 12
COVERED = 0.75
"""Sectors of each turn of a thread, and the share of them that its flanks are in."""

TURNED = 0.06
"""Sine of the angle of a facet to circles about the axis, beside what its curve leans,
up to which it is as of a turned part: that at which threads wind."""

END_AREA = 0.5
"""Area of surfaces at a thread's ends that are neither, in pitches times its depth;
more is a flat or a keyway through it."""

BEYOND = 1.5
"""How far it runs out beyond the centres of its flanks, in pitches."""

MARGIN = 0.1
"""How far a thread reaches beyond the corners of its flanks, in depths."""


class Thread(NamedTuple):
    """A thread of a surface."""

    on_thread: Mask  # (M,) samples of the surface that belong to it
    # Most that it adds to the first moment of the solid across its axis: one turn of
    # its ridge on one side
    moment: float


def find_thread(surface: Surface, axis: Array, center: Array) -> Thread | None:
    """Thread about an axis through a point, all of it in radii, if there is one."""
    regions = surface.regions
    if len(regions) < FEWEST_FACETS:
        return None
    offset = regions[:, :3] - center
    height = components_along(offset, axis)
    radius = lengths(offset - height[:, None] * axis)
    point = surface.points - center
    point_height = components_along(point, axis)
    point_radius = lengths(point - point_height[:, None] * axis)
    is_flank, mean = _flanks(surface, axis, point, point_height, point_radius)
    if np.count_nonzero(is_flank) < FEWEST_FACETS:
        return None
    pitch = 2.0 * np.pi * abs(mean)
    low, high = np.quantile(height[is_flank], (0.005, 0.995)).tolist()
    turns = (high - low) / pitch
    if turns < FEWEST_TURNS or not _covers_turns(
        offset[is_flank], axis, (height[is_flank] - low) / pitch, int(turns)
    ):
        return None

    of_flank = surface.triangles[is_flank[surface.facet]]
    inner, outer = np.quantile(point_radius[of_flank], (0.005, 0.995)).tolist()
    depth = outer - inner
    # Facets of a coarse thread lie inside of their corners.
    inner = min(inner, float(np.quantile(radius[is_flank], 0.005))) - MARGIN * depth
    outer += MARGIN * depth
    in_zone = (radius > inner) & (radius < outer)
    in_zone &= (height > low - BEYOND * pitch) & (height < high + BEYOND * pitch)
    if _cut_area(surface, axis, center, in_zone, is_flank) > END_AREA * pitch * depth:
        return None
    vertex_in_zone = (point_radius > inner) & (point_radius < outer)
    vertex_in_zone &= (point_height > low - BEYOND * pitch) & (
        point_height < high + BEYOND * pitch
    )
    is_vertex = surface.sample < 0
    on_thread = np.where(
        is_vertex,
        vertex_in_zone[np.where(is_vertex, -1 - surface.sample, 0)],
        in_zone[surface.facet[np.where(is_vertex, 0, surface.sample)]],
    )
    return Thread(on_thread, pitch * depth * outer * outer)


def _flanks(
    surface: Surface, axis: Array, point: Array, height: Array, radius: Array
) -> tuple[Mask, float]:
    """Regions (R,) with edges along helices of one lead, and that lead a radian."""
    is_flank = np.zeros(len(surface.regions), dtype=np.bool_)
    begin = surface.triangles
    end = np.roll(begin, -1, axis=1)
    triangle, corner = np.nonzero(
        np.abs(radius[end] - radius[begin]) < SAME_RADIUS * radius[begin]
    )
    begin = begin[triangle, corner]
    end = end[triangle, corner]
    angle = np.arctan2(
        components_along(cross(point[begin], point[end]), axis),
        (point[begin] * point[end]).sum(axis=1) - height[begin] * height[end],
    )
    rise = height[end] - height[begin]
    tangent = np.abs(rise) / np.maximum(np.abs(angle) * radius[begin], SMALLEST)
    is_helical = (tangent > FLATTEST_LEAD) & (tangent < STEEPEST_LEAD)
    if not is_helical.any():
        return is_flank, 0.0
    angle = angle[is_helical]
    lead = rise[is_helical] / angle
    # Half of the way along all helices tells the lead of most.
    order = np.argsort(lead, kind="stable")
    way = np.cumsum(np.abs(angle[order]))
    mean = float(lead[order[np.searchsorted(way, 0.5 * way[-1])]])
    is_near = np.abs(lead - mean) < NEAR_LEAD * abs(mean)
    is_flank[surface.facet[triangle[is_helical][is_near]]] = True
    return is_flank, mean


def _cut_area(
    surface: Surface, axis: Array, center: Array, in_zone: Mask, is_flank: Mask
) -> float:
    """Area of regions in a zone that lean to circles about an axis, unlike its flanks.

    Coarse ones of these lean by how they are cut.
    """
    triangles = np.flatnonzero((in_zone | is_flank)[surface.facet])
    facet = surface.facet[triangles]
    corners = surface.points[surface.triangles[triangles]] - center
    radius = lengths(
        (corners - (corners @ axis)[:, :, None] * axis).reshape(-1, 3)
    ).reshape(-1, 3)
    normal = surface.regions[facet, NORMAL : NORMAL + 3]
    across = np.abs((corners * cross(normal, axis)[:, None, :]).sum(axis=2))
    lean = (across / np.maximum(radius, SMALLEST)).max(axis=1)
    of_flank = is_flank[facet]
    as_flanks = float(np.quantile(lean[of_flank], 0.995))
    allowed = np.maximum(TURNED + surface.lean[facet], as_flanks)
    leans = np.zeros(len(in_zone), dtype=np.bool_)
    leans[facet[~of_flank & (lean > allowed)]] = True
    return float(surface.regions[leans, AREA].sum())


def _covers_turns(offset: Array, axis: Array, turn: Array, turns: int) -> bool:
    """Whether flanks are all around in each of so many turns."""
    first = cross(axis[None], np.eye(3)[np.abs(axis).argmin()][None])[0]
    second = cross(axis[None], first[None])[0]
    angle = np.arctan2(
        components_along(offset, second), components_along(offset, first)
    )
    sector = np.floor(angle / (2.0 * np.pi) * SECTORS).astype(np.int64) % SECTORS
    is_whole = (turn >= 0.0) & (turn < turns)
    cell = sector[is_whole] * turns + np.floor(turn[is_whole]).astype(np.int64)
    covered = len(np.unique(cell))
    return covered >= COVERED * SECTORS * turns
