"""Round runs of a hull as polygons of one number of sides a turn, whatever the file's own.

All rims about an axis take their corners from one list of angles, so that the facets between two
of them stay flat. Where corners must stay (at a notch, at the flat of a shaft), the angles between
two such are divided evenly.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..kernels.body import circles, convex_body
from ..kernels.elementary import sines_cosines
from ..records import Array, Index
from .rims import Chain, Group, Outline, Rim
from .thinning import FullRim, plan_sides

SAME_ANGLE = 0.1  # angles this close, in sides, are one in the list of a group


def reshape(
    points: Array, arrays: convex_body.BodyArrays, groups: Sequence[Group], sides: int
) -> Outline:
    """Refine or thin the round runs of a body; its points keep their numbers, new ones follow."""
    is_kept = np.zeros(len(points), dtype=np.bool_)
    is_kept[arrays.corner] = True
    outline = Outline(points, is_kept, count=len(points))
    uses = np.zeros(len(points), dtype=np.int64)
    for group in groups:
        for rim in group.rims:
            uses[rim.corner] += 1
    step = 2.0 * np.pi / sides
    wholes: list[FullRim] = []
    parts: list[tuple[Group, list[tuple[Rim, bool]]]] = []
    for group in groups:
        group_parts: list[tuple[Rim, bool]] = []
        axis = group.frame[2]
        axis_offset = group.center - (group.center * axis).sum() * axis
        for rim in group.rims:
            # The part may roll on a rim whose axis passes the centre of mass within its radius, so
            # that it has to be as fine as all others; else it is a fillet.
            can_roll = bool(
                rim.kind == "round"
                and (axis_offset * axis_offset).sum() < rim.radius * rim.radius
            )
            is_whole = (
                rim.is_closed and not rim.stays.any() and uses[rim.corner].max() == 1
            )
            is_finer = (
                len(rim.corner) > sides
                if is_whole
                else bool(rim.chord.min() < step * rim.radius)
            )
            if rim.kind == "toothed" or not (can_roll or is_finer):
                outline.chains.append(Chain(rim, rim.corner, rim.is_closed))
            elif is_whole:
                wholes.append(FullRim(rim, group, _mean_height(points, group, rim)))
            else:
                group_parts.append((rim, can_roll))
        parts.append((group, group_parts))
    plan_sides(wholes, int(is_kept.sum()), sides)
    for group, group_parts in parts:
        _redraw(
            outline,
            group,
            [whole for whole in wholes if whole.group is group],
            group_parts,
            uses,
            sides,
        )
    return outline


def _mean_height(points: Array, group: Group, rim: Rim) -> float:
    """Mean of a rim's corners along the axis of its group."""
    heights = ((points[rim.corner] - group.center) * group.frame[2]).sum(axis=1)
    return float(heights.sum()) / len(heights)


def _redraw(
    outline: Outline,
    group: Group,
    wholes: list[FullRim],
    parts: list[tuple[Rim, bool]],
    uses: Index,
    sides: int,
) -> None:
    """Put the rims of one axis on its angles."""
    pieces = [_split_rim(outline.points, group, rim, uses) for rim, _ in parts]
    turn = 2.0 * np.pi
    step = 2.0 * np.pi / sides
    ends = [
        angle
        for (_, can_roll), one in zip(parts, pieces, strict=True)
        for piece in one
        if _may_change(piece, can_roll, step)
        for angle in (piece[1][0], piece[1][-1])
    ]
    grid = (
        _divide_turn(ends, step)
        if ends
        else _regular_angles(outline.points, group, wholes, sides)
    )
    for one in wholes:
        outline.keeps[one.rim.corner] = outline.keeps[one.rim.absorbed] = False
        if one.sides == 0:
            continue
        angles = grid if ends else grid[:: sides // one.sides]
        numbers = outline.add(_on_circle(group, one.height, one.rim.radius, angles))
        outline.chains.append(
            Chain(one.rim, numbers, True, sides if ends else one.sides)
        )
    for (rim, can_roll), stretches in zip(parts, pieces, strict=True):
        height = _mean_height(outline.points, group, rim)
        changed = False
        sequence: list[Index] = []
        for corner, angle in stretches:
            inner_corners = corner[1:-1]
            if _may_change((corner, angle), can_roll, step):
                low = angle[0] + SAME_ANGLE * step
                high = angle[-1] - SAME_ANGLE * step
                new_angles = np.sort(
                    grid + turn * np.ceil((low - grid) / turn), kind="stable"
                )
                new_angles = new_angles[new_angles < high]
                if can_roll or len(new_angles) < len(inner_corners):
                    outline.keeps[inner_corners] = False
                    outline.keeps[
                        _between_ends(outline.points, group, rim.absorbed, angle)
                    ] = False
                    inner_corners = outline.add(
                        _on_circle(group, height, rim.radius, new_angles)
                    )
                    changed = True
            sequence += [corner[:1], inner_corners]
        if not rim.is_closed:
            sequence.append(stretches[-1][0][-1:])
        outline.chains.append(
            Chain(rim, np.concatenate(sequence), rim.is_closed, sides if changed else 0)
        )


def _between_ends(points: Array, group: Group, numbers: Index, angle: Array) -> Index:
    """Those of some points that lie between the ends of a stretch."""
    angles = (
        circles.angles_about(
            points[numbers], group.center, group.frame[0], group.frame[1]
        )
        - angle[0]
    )
    turn = 2.0 * np.pi
    return np.asarray(
        numbers[angles - turn * np.floor(angles / turn) < angle[-1] - angle[0]]
    )


def _may_change(piece: tuple[Index, Array], can_roll: bool, step: float) -> bool:
    """Whether the corners of a stretch may have to change."""
    corner, angle = piece
    return bool(len(corner) > 2 or (can_roll and angle[-1] - angle[0] > 1.5 * step))


def _split_rim(
    points: Array, group: Group, rim: Rim, uses: Index
) -> list[tuple[Index, Array]]:
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
    angle = circles.angles_about(
        points[corner], group.center, group.frame[0], group.frame[1]
    )
    step = np.diff(angle)
    step = step - 2.0 * np.pi * np.rint(step / (2.0 * np.pi))
    angle = np.append(angle[:1], angle[0] + np.cumsum(step))
    # Nothing is put between the ends of an edge that stays; the far one comes with the next.
    return [
        (corner[[low, high]], angle[[low, low]])
        if stays[low]
        else (corner[low : high + 1], angle[low : high + 1])
        for low, high in pairwise(np.flatnonzero(is_fixed).tolist())
    ]


def _divide_turn(ends: Sequence[float], step: float) -> Array:
    """Angles of a group: those of corners that stay, and what divides the rest evenly."""
    turn = 2.0 * np.pi
    breaks = np.sort(
        np.array(ends) - turn * np.floor(np.array(ends) / turn), kind="stable"
    )
    breaks = breaks[np.append(True, np.diff(breaks) > SAME_ANGLE * step)]
    if len(breaks) > 1 and breaks[0] + turn - breaks[-1] <= SAME_ANGLE * step:
        breaks = breaks[:-1]
    angles = []
    for low, high in zip(
        breaks.tolist(), [*breaks[1:].tolist(), breaks[0] + turn], strict=True
    ):
        parts = max(1, int(np.ceil((high - low) / step - SAME_ANGLE)))
        angles.append(low + (high - low) / parts * np.arange(parts))
    return np.concatenate(angles)


def _regular_angles(
    points: Array, group: Group, wholes: Sequence[FullRim], sides: int
) -> Array:
    """Evenly spaced angles through a corner of the file.

    Of all corners that the largest rim has, the one that leaves the smallest remainder: so the
    order of the mesh does not matter, and where the count divides all corners stay corners.
    """
    step = 2.0 * np.pi / sides
    if not wholes:
        return np.asarray(step * np.arange(sides), dtype=np.float64)
    largest_rim = max(wholes, key=lambda whole: whole.rim.radius)
    angle = circles.angles_about(
        points[largest_rim.rim.corner], group.center, group.frame[0], group.frame[1]
    )
    remainder = angle - step * np.floor(angle / step)
    return np.asarray(
        float(remainder.min()) + step * np.arange(sides), dtype=np.float64
    )


def _on_circle(group: Group, height: float, radius: float, angles: Array) -> Array:
    sine, cosine = sines_cosines(np.ascontiguousarray(angles))
    x_axis, y_axis, axis = group.frame
    return np.asarray(
        group.center
        + height * axis
        + radius * (cosine[:, None] * x_axis + sine[:, None] * y_axis)
    )
