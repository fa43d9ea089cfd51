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

"""Round runs of a hull as polygons of one number of sides, whatever the file's.

All rims about an axis take their corners from one list of angles, so that the facets
between two of them stay flat. Where corners must stay (at a notch, at the flat of a
shaft), the angles between two such are divided evenly.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..kernels.body import convex_body
from ..kernels.elementary import sines_cosines
from ..mesh.arrays import mask_of
from ..records import Array, Index
from .rims import ON_AXIS, Chain, Group, Outline, Rim, distance_from_axis
from .thinning import FullRim, plan_sides

TURN = 2.0 * np.pi
SAME_ANGLE = 0.1  # angles this close, in sides, are one in the list of a group
ABOUT = 1.0 + 1e-5
"""Squared radii up to which an axis passes the centre of mass within a rim: the ends of
a slot as long between them as they are wide lie just there, and must be taken alike."""


class Stretch(NamedTuple):
    """Part of a rim between corners that stay."""

    corner: Index  # (k,)
    angle: Array  # (k,); rising


class DividedRim(NamedTuple):
    """A rim with corners that stay."""

    rim: Rim
    can_roll: bool  # whether the part may roll on it
    stretches: list[Stretch]


def reshape(
    points: Array, arrays: convex_body.BodyArrays, groups: Sequence[Group], sides: int
) -> Outline:
    """Refine or thin the round runs of a body.

    Its points keep their numbers, new ones follow.
    """
    is_kept = mask_of(arrays.corner, len(points))
    outline = Outline(points, is_kept, count=len(points))
    uses = np.zeros(len(points), dtype=np.int64)
    for group in groups:
        for rim in group.rims:
            uses[rim.corner] += 1
    full_rims: list[FullRim] = []
    divided_rims: list[list[DividedRim]] = []
    for group in groups:
        divided_rims.append([])
        axis = group.frame[2]
        offset = group.center - (group.center * axis).sum() * axis
        for rim in group.rims:
            # The part may roll on a rim whose axis passes the centre of mass within its
            # radius, so that it has to be as fine as all others; else it is a fillet.
            can_roll = bool(
                rim.kind == "round"
                and (offset * offset).sum() < ABOUT * rim.radius * rim.radius
            )
            is_full = (
                rim.is_closed and not rim.stays.any() and uses[rim.corner].max() == 1
            )
            is_finer = (
                len(rim.corner) > sides
                if is_full
                else bool(rim.chord.min() < TURN / sides * rim.radius)
            )
            if rim.kind == "toothed" or not (can_roll or is_finer):
                outline.chains.append(Chain(rim, rim.corner))
            elif is_full:
                full_rims.append(FullRim(rim, group, _mean_height(points, group, rim)))
            else:
                stretches = _split_rim(points, group, rim, uses)
                divided_rims[-1].append(DividedRim(rim, can_roll, stretches))
    plan_sides(full_rims, int(is_kept.sum()), sides)
    for group, group_rims in zip(groups, divided_rims, strict=True):
        group_full_rims = [rim for rim in full_rims if rim.group is group]
        _redraw(outline, group, group_full_rims, group_rims, sides)
    return outline


def _mean_height(points: Array, group: Group, rim: Rim) -> float:
    """Mean of a rim's corners along the axis of its group."""
    heights = ((points[rim.corner] - group.center) * group.frame[2]).sum(axis=1)
    return float(heights.sum()) / len(heights)


def _redraw(
    outline: Outline,
    group: Group,
    full_rims: Sequence[FullRim],
    divided_rims: Sequence[DividedRim],
    sides: int,
) -> None:
    """Put the rims of one axis on its angles."""
    step = TURN / sides
    ends = [
        angle
        for divided_rim in divided_rims
        for stretch in divided_rim.stretches
        if _may_change(stretch, divided_rim.can_roll, step)
        for angle in (stretch.angle[0], stretch.angle[-1])
    ]
    grid = (
        _divide_turn(ends, step)
        if ends
        else _regular_angles(outline.points, group, full_rims, sides)
    )
    for full_rim in full_rims:
        rim = full_rim.rim
        outline.keeps[rim.corner] = False
        outline.keeps[rim.absorbed] = False
        if full_rim.sides == 0:
            continue
        rim_sides = sides if ends else full_rim.sides
        angles = grid if ends else grid[:: sides // full_rim.sides]
        numbers = outline.add(_on_circle(group, full_rim.height, rim.radius, angles))
        outline.chains.append(Chain(rim, numbers, rim_sides))
    for divided_rim in divided_rims:
        _redraw_stretches(outline, group, divided_rim, grid, sides)


def _redraw_stretches(
    outline: Outline, group: Group, divided_rim: DividedRim, grid: Array, sides: int
) -> None:
    """Put the corners between those that stay on the angles of a grid."""
    step = TURN / sides
    rim, can_roll, stretches = divided_rim
    height = _mean_height(outline.points, group, rim)
    is_changed = False
    sequence: list[Index] = []
    for stretch in stretches:
        corner, angle = stretch
        inner_corners = corner[1:-1]
        if _may_change(stretch, can_roll, step):
            low = angle[0] + SAME_ANGLE * step
            high = angle[-1] - SAME_ANGLE * step
            angles = np.sort(grid + TURN * np.ceil((low - grid) / TURN), kind="stable")
            angles = angles[angles < high]
            if can_roll or len(angles) < len(inner_corners):
                absorbed = _between_ends(outline.points, group, rim.absorbed, angle)
                outline.keeps[inner_corners] = False
                outline.keeps[absorbed] = False
                circle_points = _on_circle(group, height, rim.radius, angles)
                inner_corners = outline.add(circle_points)
                is_changed = True
        sequence += [corner[:1], inner_corners]
    if not rim.is_closed:
        sequence.append(stretches[-1].corner[-1:])
    points = np.concatenate(sequence)
    outline.chains.append(Chain(rim, points, sides if is_changed else 0))


def _between_ends(points: Array, group: Group, numbers: Index, angle: Array) -> Index:
    """Those of some points that lie between the ends of a stretch."""
    angles = group.angles(points[numbers]) - angle[0]
    return np.asarray(
        numbers[angles - TURN * np.floor(angles / TURN) < angle[-1] - angle[0]]
    )


def _may_change(stretch: Stretch, can_roll: bool, step: float) -> bool:
    """Whether the corners of a stretch may have to change."""
    corner, angle = stretch
    return bool(len(corner) > 2 or (can_roll and angle[-1] - angle[0] > 1.5 * step))


def _split_rim(points: Array, group: Group, rim: Rim, uses: Index) -> list[Stretch]:
    """Stretches of a rim between corners that stay: their corners and rising angles.

    An edge that stays is a stretch of its own with a single corner and no end.
    """
    corner = rim.corner
    stays = rim.stays
    if (rim.axis * group.frame[2]).sum() < 0.0:
        stays = stays[::-1]
        corner = np.append(corner[:1], corner[:0:-1]) if rim.is_closed else corner[::-1]
    is_fixed = uses[corner] > 1
    if rim.is_closed:
        is_fixed |= stays | np.roll(stays, 1)
        begin = int(is_fixed.argmax())
        corner = np.roll(corner, -begin)
        stays = np.roll(stays, -begin)
        is_fixed = np.roll(is_fixed, -begin)
        corner = np.append(corner, corner[0])
        is_fixed = np.append(is_fixed, True)
    else:
        is_fixed[:-1] |= stays
        is_fixed[1:] |= stays
        is_fixed[0] = is_fixed[-1] = True
    angle = group.angles(points[corner])
    step = np.diff(angle)
    step = step - TURN * np.rint(step / TURN)
    angle = np.append(angle[:1], angle[0] + np.cumsum(step))
    # Nothing is put between the ends of an edge that stays; the far one comes with the
    # next.
    return [
        Stretch(corner[[low, high]], angle[[low, low]])
        if stays[low]
        else Stretch(corner[low : high + 1], angle[low : high + 1])
        for low, high in pairwise(np.flatnonzero(is_fixed).tolist())
    ]


def _divide_turn(ends: Sequence[float], step: float) -> Array:
    """Angles of a group: those of corners that stay, the rest evenly between."""
    angles_that_stay = np.array(ends)
    breaks = np.sort(
        angles_that_stay - TURN * np.floor(angles_that_stay / TURN), kind="stable"
    )
    breaks = breaks[np.append(True, np.diff(breaks) > SAME_ANGLE * step)]
    if len(breaks) > 1 and breaks[0] + TURN - breaks[-1] <= SAME_ANGLE * step:
        breaks = breaks[:-1]
    angles = []
    for low, high in zip(
        breaks.tolist(), [*breaks[1:].tolist(), breaks[0] + TURN], strict=True
    ):
        parts = max(1, int(np.ceil((high - low) / step - SAME_ANGLE)))
        angles.append(low + (high - low) / parts * np.arange(parts))
    return np.concatenate(angles)


def _regular_angles(
    points: Array, group: Group, full_rims: Sequence[FullRim], sides: int
) -> Array:
    """Evenly spaced angles through corners of the file.

    They go through the corner of the largest rim that is nearest to the centre of mass,
    whichever way the mesh is turned. Where the count divides, all corners stay corners
    but for the rounding of the file, whose mean is taken.
    """
    step = TURN / sides
    if not full_rims:
        return np.asarray(step * np.arange(sides), dtype=np.float64)
    largest_rim = max(full_rims, key=lambda full_rim: full_rim.rim.radius)
    angle = group.angles(points[largest_rim.rim.corner])
    center_of_mass = np.zeros((1, 3))
    if distance_from_axis(center_of_mass, group) > ON_AXIS:
        turn = angle - group.angles(center_of_mass)
        first = float(angle[np.abs(turn - TURN * np.rint(turn / TURN)).argmin()])
    else:
        first = float((angle - step * np.floor(angle / step)).min())
    deviation = angle - first
    deviation -= step * np.rint(deviation / step)
    rounding = deviation[np.abs(deviation) < SAME_ANGLE * step]
    return np.asarray(
        first + float(rounding.mean()) + step * np.arange(sides), dtype=np.float64
    )


def _on_circle(group: Group, height: float, radius: float, angles: Array) -> Array:
    sine, cosine = sines_cosines(np.ascontiguousarray(angles))
    x_axis, y_axis, axis = group.frame
    return np.asarray(
        group.center
        + height * axis
        + radius * (cosine[:, None] * x_axis + sine[:, None] * y_axis)
    )
