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
from .thinning import Whole, plan_sides

SAME_ANGLE = 0.1  # angles this close, in sides, are one in the list of a group


def reshape(
    points: Array, arrays: convex_body.BodyArrays, groups: Sequence[Group], sides: int
) -> Outline:
    """Refine or thin the round runs of a body; its points keep their numbers, new ones follow."""
    keeps = np.zeros(len(points), dtype=np.bool_)
    keeps[arrays.corner] = True
    outline = Outline(points, keeps, count=len(points))
    uses = np.zeros(len(points), dtype=np.int64)
    for group in groups:
        for rim in group.rims:
            uses[rim.corner] += 1
    step = 2.0 * np.pi / sides
    wholes: list[Whole] = []
    parts: list[tuple[Group, list[tuple[Rim, bool]]]] = []
    for group in groups:
        mine: list[tuple[Rim, bool]] = []
        axis = group.frame[2]
        away = group.center - (group.center * axis).sum() * axis
        for rim in group.rims:
            # The part may roll on a rim whose axis passes the centre of mass within its radius, so
            # that it has to be as fine as all others; else it is a fillet.
            refine = bool(
                rim.kind == "round" and (away * away).sum() < rim.radius * rim.radius
            )
            whole = rim.closed and not rim.stays.any() and uses[rim.corner].max() == 1
            finer = (
                len(rim.corner) > sides
                if whole
                else bool(rim.chord.min() < step * rim.radius)
            )
            if rim.kind == "toothed" or not (refine or finer):
                outline.chains.append(Chain(rim, rim.corner, rim.closed))
            elif whole:
                wholes.append(Whole(rim, group, _height(points, group, rim)))
            else:
                mine.append((rim, refine))
        parts.append((group, mine))
    plan_sides(wholes, int(keeps.sum()), sides)
    for group, mine in parts:
        _redraw(
            outline,
            group,
            [one for one in wholes if one.group is group],
            mine,
            uses,
            sides,
        )
    return outline


def _height(points: Array, group: Group, rim: Rim) -> float:
    """Mean of a rim's corners along the axis of its group."""
    along = ((points[rim.corner] - group.center) * group.frame[2]).sum(axis=1)
    return float(along.sum()) / len(along)


def _redraw(
    outline: Outline,
    group: Group,
    wholes: list[Whole],
    parts: list[tuple[Rim, bool]],
    uses: Index,
    sides: int,
) -> None:
    """Put the rims of one axis on its angles."""
    pieces = [_pieces(outline.points, group, rim, uses) for rim, _ in parts]
    turn = 2.0 * np.pi
    step = 2.0 * np.pi / sides
    ends = [
        angle
        for (_, refine), one in zip(parts, pieces, strict=True)
        for piece in one
        if _is_redrawn(piece, refine, step)
        for angle in (piece[1][0], piece[1][-1])
    ]
    grid = _grid(ends, step) if ends else _regular(outline.points, group, wholes, sides)
    for one in wholes:
        outline.keeps[one.rim.corner] = outline.keeps[one.rim.absorbed] = False
        if one.sides == 0:
            continue
        angles = grid if ends else grid[:: sides // one.sides]
        numbers = outline.add(_on_circle(group, one.height, one.rim.radius, angles))
        outline.chains.append(
            Chain(one.rim, numbers, True, sides if ends else one.sides)
        )
    for (rim, refine), mine in zip(parts, pieces, strict=True):
        height = _height(outline.points, group, rim)
        changed = False
        sequence: list[Index] = []
        for corner, angle in mine:
            between = corner[1:-1]
            if _is_redrawn((corner, angle), refine, step):
                low = angle[0] + SAME_ANGLE * step
                high = angle[-1] - SAME_ANGLE * step
                new = np.sort(grid + turn * np.ceil((low - grid) / turn), kind="stable")
                new = new[new < high]
                if refine or len(new) < len(between):
                    outline.keeps[between] = False
                    outline.keeps[
                        _within(outline.points, group, rim.absorbed, angle)
                    ] = False
                    between = outline.add(_on_circle(group, height, rim.radius, new))
                    changed = True
            sequence += [corner[:1], between]
        if not rim.closed:
            sequence.append(mine[-1][0][-1:])
        outline.chains.append(
            Chain(rim, np.concatenate(sequence), rim.closed, sides if changed else 0)
        )


def _within(points: Array, group: Group, numbers: Index, angle: Array) -> Index:
    """Those of some points that lie between the ends of a stretch."""
    there = (
        circles.angles_about(
            points[numbers], group.center, group.frame[0], group.frame[1]
        )
        - angle[0]
    )
    turn = 2.0 * np.pi
    return np.asarray(
        numbers[there - turn * np.floor(there / turn) < angle[-1] - angle[0]]
    )


def _is_redrawn(piece: tuple[Index, Array], refine: bool, step: float) -> bool:
    """Whether the corners of a stretch may have to change."""
    corner, angle = piece
    return bool(len(corner) > 2 or (refine and angle[-1] - angle[0] > 1.5 * step))


def _pieces(
    points: Array, group: Group, rim: Rim, uses: Index
) -> list[tuple[Index, Array]]:
    """Stretches of a rim between corners that stay: their corners and rising angles.

    An edge that stays is a stretch of its own with a single corner and no end.
    """
    corner = rim.corner
    stays = rim.stays
    if (rim.axis * group.frame[2]).sum() < 0.0:
        stays = stays[::-1]
        corner = np.append(corner[:1], corner[:0:-1]) if rim.closed else corner[::-1]
    fixed = uses[corner] > 1
    if rim.closed:
        fixed |= stays | np.roll(stays, 1)
        begin = int(fixed.argmax())
        corner = np.roll(corner, -begin)
        stays = np.roll(stays, -begin)
        fixed = np.roll(fixed, -begin)
        corner = np.append(corner, corner[0])
        fixed = np.append(fixed, True)
    else:
        fixed[:-1] |= stays
        fixed[1:] |= stays
        fixed[0] = fixed[-1] = True
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
        for low, high in pairwise(np.flatnonzero(fixed).tolist())
    ]


def _grid(ends: Sequence[float], step: float) -> Array:
    """Angles of a group: those of corners that stay, and what divides the rest evenly."""
    turn = 2.0 * np.pi
    breaks = np.sort(
        np.array(ends) - turn * np.floor(np.array(ends) / turn), kind="stable"
    )
    breaks = breaks[np.append(True, np.diff(breaks) > SAME_ANGLE * step)]
    if len(breaks) > 1 and breaks[0] + turn - breaks[-1] <= SAME_ANGLE * step:
        breaks = breaks[:-1]
    found = []
    for low, high in zip(
        breaks.tolist(), [*breaks[1:].tolist(), breaks[0] + turn], strict=True
    ):
        parts = max(1, int(np.ceil((high - low) / step - SAME_ANGLE)))
        found.append(low + (high - low) / parts * np.arange(parts))
    return np.concatenate(found)


def _regular(points: Array, group: Group, wholes: Sequence[Whole], sides: int) -> Array:
    """Evenly spaced angles through a corner of the file.

    Of all corners that the largest rim has, the one that leaves the smallest remainder: so the
    order of the mesh does not matter, and where the count divides all corners stay corners.
    """
    step = 2.0 * np.pi / sides
    if not wholes:
        return np.asarray(step * np.arange(sides), dtype=np.float64)
    widest = max(wholes, key=lambda one: one.rim.radius)
    angle = circles.angles_about(
        points[widest.rim.corner], group.center, group.frame[0], group.frame[1]
    )
    rest = angle - step * np.floor(angle / step)
    return np.asarray(float(rest.min()) + step * np.arange(sides), dtype=np.float64)


def _on_circle(group: Group, height: float, radius: float, angles: Array) -> Array:
    sine, cosine = sines_cosines(np.ascontiguousarray(angles))
    x_axis, y_axis, axis = group.frame
    return np.asarray(
        group.center
        + height * axis
        + radius * (cosine[:, None] * x_axis + sine[:, None] * y_axis)
    )
