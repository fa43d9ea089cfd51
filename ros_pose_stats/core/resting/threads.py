"""Threads: surfaces that wind about an axis, and count as what they wind on.

A screw motion about an axis keeps a helical surface: at a place x with the normal n,
n (axis × x) + c n axis = 0, with c the rise over the turn. So each facet of a flank
tells c, too much or too little by which corner of its strip it lies at, and their mean
is near. Facets that are cut against the winding tell it too badly at coarse divisions;
such a thread is then no surface of revolution, and poses stay separate.
"""

from typing import NamedTuple

import numpy as np

from ..kernels.features.surface_features import AREA, NORMAL, Surface
from ..mesh.vectors import components_along, cross, lengths
from ..records import Array, Mask

FEWEST_TURNS = 2.0
FEWEST_FACETS = 64
"""Of a thread."""

FLANK = 0.3
"""Cosine of the angle of a flank to the axis: steeper than any."""

FLATTEST_LEAD = 0.004
STEEPEST_LEAD = 0.3
"""Tangents of the angles at which threads wind: 0.02 of an M30 with a fine pitch, and
0.2 of a lead screw; fine divisions tell smaller ones from none."""

NEAR_LEAD = 0.8
"""How far the rise that one facet tells may be off, as its share."""

SMALLEST = 1e-9  # distance from the axis that is none, in radii

SECTORS = 12
COVERED = 0.75
"""Sectors of each turn of a thread, and the share of them that its flanks are in."""

TURNED = 0.06
"""Sine of the angle of a facet to circles about the axis, beside what its curve leans,
up to which it is as of a turned part: that at which threads wind."""

END_AREA = 2.0
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
    normal = regions[:, NORMAL : NORMAL + 3]
    area = regions[:, AREA]
    offset = regions[:, :3] - center
    height = components_along(offset, axis)
    radius = lengths(offset - height[:, None] * axis)
    rise = components_along(normal, axis)
    across = components_along(cross(offset, normal), axis)
    lead = np.divide(-across, rise, out=np.zeros(len(rise)), where=np.abs(rise) > FLANK)
    tangent = np.abs(lead) / np.maximum(radius, SMALLEST)
    is_flank = (tangent > FLATTEST_LEAD) & (tangent < STEEPEST_LEAD)
    if np.count_nonzero(is_flank) < FEWEST_FACETS:
        return None
    mean = float(np.median(lead[is_flank]))
    for _ in range(3):
        is_flank &= np.abs(lead - mean) < NEAR_LEAD * abs(mean)
        if np.count_nonzero(is_flank) < FEWEST_FACETS:
            return None
        mean = float(np.average(lead[is_flank], weights=area[is_flank]))
    pitch = 2.0 * np.pi * abs(mean)
    low, high = np.quantile(height[is_flank], (0.005, 0.995)).tolist()
    turns = (high - low) / pitch
    if turns < FEWEST_TURNS or not _covers_turns(
        offset[is_flank], axis, (height[is_flank] - low) / pitch, int(turns)
    ):
        return None

    point = surface.points - center
    point_height = components_along(point, axis)
    point_radius = lengths(point - point_height[:, None] * axis)
    of_flank = surface.triangles[is_flank[surface.facet]]
    inner, outer = np.quantile(point_radius[of_flank], (0.005, 0.995)).tolist()
    depth = outer - inner
    inner -= MARGIN * depth
    outer += MARGIN * depth
    in_zone = (radius > inner) & (radius < outer)
    in_zone &= (height > low - BEYOND * pitch) & (height < high + BEYOND * pitch)
    if _cut_area(surface, axis, center, in_zone & ~is_flank) > END_AREA * pitch * depth:
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


def _cut_area(surface: Surface, axis: Array, center: Array, chosen: Mask) -> float:
    """Area of those of the chosen regions that lean to circles about an axis."""
    triangles = np.flatnonzero(chosen[surface.facet])
    facet = surface.facet[triangles]
    corners = surface.points[surface.triangles[triangles]] - center
    radius = lengths(
        (corners - (corners @ axis)[:, :, None] * axis).reshape(-1, 3)
    ).reshape(-1, 3)
    normal = surface.regions[facet, NORMAL : NORMAL + 3]
    across = np.abs((corners * cross(normal, axis)[:, None, :]).sum(axis=2))
    leans = np.zeros(len(chosen), dtype=np.bool_)
    allowed = (TURNED + surface.lean[facet])[:, None] * radius
    leans[facet[(across > allowed).any(axis=1)]] = True
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
