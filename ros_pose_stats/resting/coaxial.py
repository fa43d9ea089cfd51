"""Rims about one axis: they are found together, and take their corners from one list of angles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from ..kernels.body.convex_body import BodyArrays
from ..kernels.principal_axes import principal_axes
from ..mesh.vectors import lengths, scatter

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]
Kind = Literal["round", "toothed"]

ROUND_SHARE: Final = 0.75
"""Share of a run that is surface of the mesh from which on it is round, and not toothed."""

ON_AXIS: Final = 1e-5
"""A corner this close to an axis, in radii, is the tip of a cone about it."""

COAXIAL: Final = 5e-6
"""Corners this close to where a common axis puts them have that axis, in radii."""


@dataclass(eq=False)
class Rim:
    """A run while it is worked on."""

    side: Index  # (E,); polygon side of the body along each edge
    corner: Index  # points of the body
    closed: bool
    center: Array  # (3,)
    axis: Array
    radius: float  # the latter the largest distance of a corner from the circle
    deviation: float
    chord: Array  # (E,); lengths of the edges
    stays: Flags  # (E,) bool; edges over a gap, or along a flat: nothing is put between their ends
    kind: Kind
    # (k,); other corners on the circle: at a seam where it does not quite close, or for rounding
    absorbed: Index = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    group: int = -1


@dataclass(frozen=True, eq=False)
class Group:
    """Rims about one axis, with a frame: the rows of `frame` are x, y and the axis."""

    center: Array
    frame: Array
    rims: list[Rim]


def loops_of(arrays: BodyArrays, faces: Index) -> tuple[Index, Index]:
    """Corners of faces, one loop after the other, and where each loop begins."""
    first = arrays.face_start[faces]
    size = arrays.face_start[faces + 1] - first
    begin = np.cumsum(size) - size
    return arrays.corner[np.arange(size.sum()) + np.repeat(first - begin, size)], begin


def off_axis(points: Array, group: Group) -> Array:
    """Distance (n,) of points from the axis of a group."""
    away = points - group.center
    x, y = (away * group.frame[0]).sum(axis=1), (away * group.frame[1]).sum(axis=1)
    return np.asarray(np.sqrt(x * x + y * y))


def group_by_axis(points: Array, rims: list[Rim], rounding: float) -> list[Group]:
    """Gather rims about one axis, the longest first."""
    if not rims:
        return []
    reach = np.array([rim.radius * len(rim.side) for rim in rims])
    rims = [rims[k] for k in np.argsort(-reach, kind="stable").tolist()]
    axis, center = np.array([rim.axis for rim in rims]), np.array([rim.center for rim in rims])
    radius = np.array([rim.radius for rim in rims])
    slack = np.array([(4.0 * rounding + rim.deviation) * _looseness(points, rim)
                      for rim in rims])
    waiting = np.ones(len(rims), dtype=np.bool_)
    groups = []
    for k, first in enumerate(rims):
        if not waiting[k]:
            continue
        tilt = lengths(np.cross(axis, first.axis)) * radius
        away = center - first.center
        along = (away * first.axis).sum(axis=1)
        offset = lengths(away - along[:, None] * first.axis)
        mine = waiting & (np.maximum(tilt, offset) <= COAXIAL + slack + slack[k])
        mine[k] = True
        waiting &= ~mine
        chosen = [rims[j] for j in np.flatnonzero(mine).tolist()]
        groups.append(_with_frame(points, chosen))
    return groups


def keep_turned(points: Array, arrays: BodyArrays, group: Group) -> bool:
    """Leave out rims of no surface turned about their axis, in place; tell whether one is left.

    Beside a rim lies a flat end, or facets between it and another rim or the tip of a cone. Else
    it is one of the many circles on a ball.
    """
    on_rims = off_axis(points, group) < ON_AXIS
    for rim in group.rims:
        on_rims[rim.corner] = True
    kept = []
    for rim in group.rims:
        for side in (rim.side, arrays.twin[rim.side]):
            faces = arrays.face[side]
            corner, begin = loops_of(arrays, faces)
            turned = int(np.logical_and.reduceat(on_rims[corner], begin).sum())
            largest = int(np.unique(faces, return_counts=True)[1].max())
            if max(turned, largest) >= ROUND_SHARE * len(faces):
                kept.append(rim)
                break
    group.rims[:] = kept
    return bool(kept)


def _looseness(points: Array, rim: Rim) -> float:
    """How far errors of the corners reach: the radius over the height of the arc."""
    if rim.closed:
        return 1.0
    half = 0.5 * float(lengths(points[rim.corner[-1:]] - points[rim.corner[:1]])[0])
    if rim.chord.sum() > np.pi * rim.radius:
        return 1.0
    inside = max(rim.radius * rim.radius - half * half, 0.0)
    return rim.radius / max(rim.radius - float(np.sqrt(inside)), 1e-3 * rim.radius)


def _with_frame(points: Array, rims: Sequence[Rim]) -> Group:
    """Common axis: least squares of the corners' heights in their rims, and of the centres.

    It is that of the smallest moment of what the rims spread along it and the centres across it.
    """
    first = rims[0]
    axis, center = first.axis, first.center
    if len(rims) > 1:
        weight = np.array([float(len(rim.corner)) for rim in rims])
        centers = np.array([rim.center for rim in rims])
        center = (weight[:, None] * centers).sum(axis=0) / weight.sum()
        tensor = np.zeros((3, 3))
        for rim, number in zip(rims, weight.tolist(), strict=True):
            away = rim.center - center
            outer = away[:, None] * away
            tensor += number * (scatter(points[rim.corner]) - outer)
            tensor += number * (outer[0, 0] + outer[1, 1] + outer[2, 2]) * np.eye(3)
        axis = principal_axes(tensor)[1][:, 0]
    if axis[int(np.abs(axis).argmax())] < 0.0:
        axis = -axis
    across = np.zeros(3)
    across[int(np.abs(axis).argmin())] = 1.0
    x_axis = across - (across * axis).sum() * axis
    x_axis = x_axis / lengths(x_axis[None])[0]
    return Group(center, np.stack([x_axis, np.cross(axis, x_axis), axis]), list(rims))
