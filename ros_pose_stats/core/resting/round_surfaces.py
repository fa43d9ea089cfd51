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

"""The round surfaces of a part as runs: circular chains of corners of its hull.

A turned part and a gear have the same runs. They are told apart by what lies under the
edges of a run: the surface of the mesh, or the gap from one tooth to the next. Runs
about one axis belong together, for the facets between them are those of one cylinder,
cone or toothed rim.
"""

import numpy as np

from ..kernels.body.convex_body import BodyArrays
from ..kernels.body.hull import edges_on_surface
from ..kernels.body.runs import (
    AXIS,
    CENTER,
    DEVIATION,
    HALF_SPAN,
    RADIUS,
    Runs,
    circular_runs,
)
from ..mesh import arrays, hull, vectors
from ..mesh.arrays import mask_of
from ..records import Array, Index, Mask, Part
from .rims import (
    ROUND_SHARE,
    Group,
    Rim,
    group_by_axis,
    keep_turned_rims,
    square_distances,
)

SEAM = 2e-4
"""Corners this close to a circle, in radii, are on it where its ends do not quite meet.

A mesh this close under an edge of the hull leaves no gap there.
"""

# An edge that is this much longer than most of its run is a flat, and stays.
LONG_EDGE = 2.2

FINE_ROUNDING = 3e-7
"""Above it, in radii, corners of a fine circle may hide each other and be off its
run."""

FEWEST_DECIMALS = 12
"""Different coordinates that must end at the same digit for it to be the last one
printed."""

# Written out, since computed powers of ten may differ in their last digit.
_POWERS = tuple(float(f"1e{exponent}") for exponent in range(-3, 13))


def find_groups(
    part: Part,
    points: Array,
    arrays: BodyArrays,
    scale: float,
    rounding: float,
    sides: int,
) -> list[Group]:
    """Runs of a part's hull (H, 3), by their axes.

    `rounding`: of the coordinates, in radii.
    """
    runs = circular_runs(points, arrays, rounding)
    if len(runs.closed) == 0:
        return []
    ends = np.stack(
        [arrays.corner[runs.side], arrays.corner[arrays.twin[runs.side]]], axis=1
    )
    chord = vectors.lengths(points[ends[:, 1]] - points[ends[:, 0]])
    on_surface = _on_surface(part, ends, scale * (SEAM + 4.0 * rounding))
    rims = []
    for k in np.flatnonzero(~_crosses_others(ends, runs, len(points))).tolist():
        edges = slice(int(runs.start[k]), int(runs.start[k + 1]))
        corner = ends[edges, 0]
        if not runs.closed[k]:
            corner = np.append(corner, ends[edges, 1][-1])
        rims.append(
            _rim_of(
                runs.circle[k],
                runs.side[edges],
                corner,
                bool(runs.closed[k]),
                chord[edges],
                on_surface[edges],
                sides,
            )
        )
    _absorb(rims, points, arrays, rounding)
    groups = [
        group
        for group in group_by_axis(points, rims, rounding)
        if keep_turned_rims(points, arrays, group)
    ]
    for number, group in enumerate(groups):
        for rim in group.rims:
            rim.group = number
    return groups


def _rim_of(
    circle: Array,
    side: Index,
    corner: Index,
    is_closed: bool,
    chord: Array,
    on_surface: Mask,
    sides: int,
) -> Rim:
    """Rim of a run; `chord`, `on_surface`: of its edges."""
    radius = float(circle[RADIUS])
    # Edges that bridge a gap, or are too long for a facet of their run, stay.
    usual = _median(chord[on_surface]) if on_surface.any() else 0.0
    longest = max(LONG_EDGE * usual, 4.0 * np.pi / sides * radius)
    is_round = chord[on_surface].sum() >= ROUND_SHARE * chord.sum()
    return Rim(
        side,
        corner,
        is_closed,
        circle[CENTER : CENTER + 3],
        circle[AXIS : AXIS + 3],
        radius,
        float(circle[DEVIATION]),
        chord,
        ~on_surface | (chord > longest),
        "round" if is_round else "toothed",
    )


def rounding_of(part: Part, corners: Array) -> float:
    """How far coordinates may be off, metres: as stored, or printed with few digits."""
    values = np.unique(np.abs(corners))
    largest = float(values[-1])
    # With a fixed number of digits the numbers of the highest decade have the fewest
    # decimals.
    decade = max(
        (power for power in _POWERS if 1.0 <= largest * power < 10.0), default=1.0
    )
    highest = values[values * decade >= 1.0]
    if len(highest) < FEWEST_DECIMALS:
        highest = values[values > 0.1 * largest]
    if len(highest) < FEWEST_DECIMALS:
        return part.rounding
    for power in _POWERS:
        # Four digits are a designer's, not a printer's; with nine nothing is lost.
        if not 1e4 <= largest * power <= 1e8:
            continue
        ticks = highest * power
        slack = max(1e-5, 2.0 * part.rounding * power)
        if slack < 0.05 and np.abs(ticks - np.rint(ticks)).max() <= slack:
            return max(part.rounding, 0.5 / power)
    return part.rounding


def _on_surface(part: Part, ends: Index, tolerance: float) -> Mask:
    """Whether edges of the hull (E, 2) lie on the surface of the mesh."""
    triangles = part.surface_triangles
    if part.is_open:
        # The hull stands in for the surface there, and it has no gaps.
        triangles = arrays.weld(part.vertices, part.triangles.astype(np.int64))[1]
    vertex = hull.hull_of_part(part).qhull.vertices[ends]
    edge_vertices = vertex.ravel()
    first = np.append(
        0, np.cumsum(np.bincount(edge_vertices, minlength=len(part.surface_vertices)))
    )
    touches = edges_on_surface(
        part.surface_vertices,
        triangles,
        vertex,
        first,
        np.argsort(edge_vertices, kind="stable"),
        tolerance,
    )
    return np.asarray(touches == 2)


def _median(values: Array) -> float:
    """Quicker than NumPy's for a few values."""
    sorted_values = np.sort(values)
    return (
        float(
            sorted_values[(len(sorted_values) - 1) // 2]
            + sorted_values[len(sorted_values) // 2]
        )
        / 2.0
    )


def _close_seam(rim: Rim, points: Array) -> bool:
    """Close a run that ends beside its beginning, in place; tell whether it was one."""
    if rim.is_closed or rim.kind == "toothed":
        return False
    step = vectors.length(points[rim.corner[-1]] - points[rim.corner[0]])
    seam = 10.0 * SEAM * rim.radius
    if rim.chord.sum() + step < 0.98 * 2.0 * np.pi * rim.radius or step > min(
        max(LONG_EDGE * _median(rim.chord), seam), 2.0 * HALF_SPAN * rim.radius
    ):
        return False
    if step <= seam:
        rim.corner = rim.corner[:-1]
    else:
        rim.chord = np.append(rim.chord, step)
        rim.stays = np.append(rim.stays, False)
    rim.is_closed = True
    return True


def _absorb(
    rims: list[Rim], points: Array, arrays: BodyArrays, rounding: float
) -> None:
    """Close runs over seams, and take in other corners that lie on their circles."""
    has_seam = [_close_seam(rim, points) for rim in rims]
    if rounding <= FINE_ROUNDING and not any(has_seam):
        return
    is_free = mask_of(arrays.corner, len(points))
    for rim in rims:
        is_free[rim.corner] = False
    numbers = np.flatnonzero(is_free)
    for rim, is_over_seam in zip(rims, has_seam, strict=True):
        distance = np.sqrt(square_distances(points[numbers], rim))
        slack = 4.0 * rounding + (SEAM * rim.radius if is_over_seam else rim.deviation)
        rim.absorbed = numbers[distance <= slack]


def _crosses_others(ends: Index, runs: Runs, count: int) -> Mask:
    """Arcs (Q,) that cross other runs at most corners, as meridians of a dome.

    A ball or the corner of a filleted box is divided both ways, and rolls along
    neither.
    """
    uses = np.bincount(ends[:, 0], minlength=count)
    end_corner = ends[runs.start[1:] - 1, 1]
    uses += np.bincount(end_corner[runs.closed == 0], minlength=count)
    crossings = np.add.reduceat(
        (uses[ends[:, 0]] > 1).astype(np.int64), runs.start[:-1]
    )
    crossings += uses[end_corner] > 1
    return np.asarray(
        (runs.closed == 0) & (crossings >= ROUND_SHARE * (np.diff(runs.start) + 1))
    )
