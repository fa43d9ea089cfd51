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

"""Rims: circular chains of corners of a hull, in groups about one axis.

A rim is found in the hull of the file (`round_surfaces`), and may get other
corners (`reshaping`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ..kernels.body import circles
from ..kernels.body.convex_body import BodyArrays
from ..kernels.principal_axes import principal_axes
from ..mesh.vectors import components_along, cross, length, lengths, scatter
from ..records import Array, Index, Mask

Kind = Literal["round", "toothed"]

ROUND_SHARE = 0.75
"""Share of a run that is surface of the mesh from which on it is round, and not
toothed."""

# A corner this close to an axis, in radii, is the tip of a cone about it
ON_AXIS = 1e-5
# Corners this close to where a common axis puts them have that axis, in radii
COAXIAL = 5e-6


@dataclass(eq=False)
class Rim:
    """A run while it is worked on."""

    side: Index  # (E,); polygon side of the body along each edge
    corner: Index  # points of the body
    is_closed: bool
    center: Array  # (3,)
    axis: Array
    radius: float
    deviation: float  # largest distance of a corner from the circle
    chord: Array  # (E,); lengths of the edges
    # (E,) bool; edges over a gap, or along a flat: nothing is put between their ends
    stays: Mask
    kind: Kind
    # (k,); other corners on the circle: at a seam where it does not quite close, or for
    # rounding
    absorbed: Index = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    group: int = -1


@dataclass(frozen=True, eq=False)
class Group:
    """Rims about one axis, with a frame: the rows of `frame` are x, y and the axis."""

    center: Array
    frame: Array
    rims: list[Rim]

    def angles(self, points: Array) -> Array:
        """Angles (n,) of points about the axis, radians from the x axis on."""
        return circles.angles_about(points, self.center, self.frame[0], self.frame[1])


@dataclass(frozen=True, eq=False)
class Run:
    """A circular chain of edges of a convex hull, in radii about the centre of mass."""

    # (3,); of its circle; the run goes round the unit vector `axis` counter-clockwise
    center: Array
    axis: Array
    radius: float
    kind: Kind  # whether its edges are surface of the part, or mostly bridge gaps
    full: bool  # whether it is once around; else it is an arc
    corners: int  # as the file has them
    sides: int  # sides a turn that it was reshaped to; 0 where it stands as in the file
    group: int  # equal for runs about one axis


@dataclass(eq=False)
class Chain:
    """A rim as it is in the new body: its points about the axis of its group."""

    rim: Rim
    point: Index
    sides: int = 0

    def as_run(self, unit: float) -> Run:
        """What a body tells about it that has this unit of length."""
        rim = self.rim
        return Run(
            rim.center / unit,
            rim.axis,
            rim.radius / unit,
            rim.kind,
            rim.is_closed,
            len(rim.corner),
            self.sides,
            rim.group,
        )


@dataclass(eq=False)
class Outline:
    """Points of a body that is reshaped: those of the file that stay, then new ones."""

    points: Array
    keeps: Mask
    chains: list[Chain] = field(default_factory=list)
    added: list[Array] = field(default_factory=list)
    count: int = 0
    changed: bool = False  # whether some are left out, also where none is added

    @property
    def rounded(self) -> int:
        """Number of runs that have other numbers of corners than in the file."""
        return sum(
            bool(chain.sides) and len(chain.point) != len(chain.rim.corner)
            for chain in self.chains
        )

    def compacted(self) -> tuple[Array, list[Chain]]:
        """Points of the new body, and the chains in their numbering.

        Thinning may leave no corner of a fillet's rim, which then is no chain.
        """
        is_kept = np.append(
            self.keeps, np.ones(self.count - len(self.keeps), dtype=np.bool_)
        )
        number = np.cumsum(is_kept) - 1
        points = np.ascontiguousarray(
            np.concatenate([self.points, *self.added])[is_kept]
        )
        return points, [
            replace(chain, point=number[chain.point[is_kept[chain.point]]])
            for chain in self.chains
            if is_kept[chain.point].any()
        ]

    def add(self, points: Array) -> Index:
        """Take in new points; return their numbers."""
        numbers = np.arange(self.count, self.count + len(points))
        self.added.append(points)
        self.count += len(points)
        return numbers


def loops_of(arrays: BodyArrays, faces: Index) -> tuple[Index, Index]:
    """Corners of faces, one loop after the other, and where each loop begins."""
    first = arrays.face_start[faces]
    size = arrays.face_start[faces + 1] - first
    begin = np.cumsum(size) - size
    return arrays.corner[np.arange(size.sum()) + np.repeat(first - begin, size)], begin


def square_distances(points: Array, circle: Rim | Run) -> Array:
    """Squares (n,) of the distances of points from the circle of a rim or run."""
    offset = points - circle.center
    height = components_along(offset, circle.axis)
    radial_error = lengths(offset - height[:, None] * circle.axis) - circle.radius
    return height * height + radial_error * radial_error


def distance_from_axis(points: Array, group: Group) -> Array:
    """Distance (n,) of points from the axis of a group."""
    offset = points - group.center
    x = components_along(offset, group.frame[0])
    y = components_along(offset, group.frame[1])
    return np.sqrt(x * x + y * y)


def group_by_axis(points: Array, rims: list[Rim], rounding: float) -> list[Group]:
    """Gather rims about one axis, the longest first."""
    if not rims:
        return []
    reach = np.array([rim.radius * len(rim.side) for rim in rims])
    rims = [rims[k] for k in np.argsort(-reach, kind="stable").tolist()]
    axis = np.array([rim.axis for rim in rims])
    center = np.array([rim.center for rim in rims])
    radius = np.array([rim.radius for rim in rims])
    slack = np.array(
        [(4.0 * rounding + rim.deviation) * _looseness(points, rim) for rim in rims]
    )
    is_free = np.ones(len(rims), dtype=np.bool_)
    groups = []
    for k, first in enumerate(rims):
        if not is_free[k]:
            continue
        tilt = lengths(cross(axis, first.axis)) * radius
        center_offset = center - first.center
        offset = lengths(
            center_offset
            - components_along(center_offset, first.axis)[:, None] * first.axis
        )
        is_coaxial = is_free & (np.maximum(tilt, offset) <= COAXIAL + slack + slack[k])
        is_coaxial[k] = True
        is_free &= ~is_coaxial
        coaxial_rims = [rims[j] for j in np.flatnonzero(is_coaxial).tolist()]
        groups.append(_with_frame(points, coaxial_rims))
    return groups


def keep_turned_rims(points: Array, arrays: BodyArrays, group: Group) -> bool:
    """Leave out rims of no surface turned about their axis, in place.

    Tell whether one is left.

    Beside such a rim lie a flat end, or facets to another one or to a tip; else it is
    on a ball.
    """
    on_rims = distance_from_axis(points, group) < ON_AXIS
    for rim in group.rims:
        on_rims[rim.corner] = True
    turned_rims = []
    for rim in group.rims:
        for side in (rim.side, arrays.twin[rim.side]):
            faces = arrays.face[side]
            turned_faces = int(np.bincount(faces).max())
            if turned_faces < ROUND_SHARE * len(faces):
                corner, begin = loops_of(arrays, faces)
                turned_faces = int(
                    np.logical_and.reduceat(on_rims[corner], begin).sum()
                )
            if turned_faces >= ROUND_SHARE * len(faces):
                turned_rims.append(rim)
                break
    group.rims[:] = turned_rims
    return bool(turned_rims)


def _looseness(points: Array, rim: Rim) -> float:
    """How far errors of the corners reach: the radius over the height of the arc."""
    if rim.is_closed or rim.chord.sum() > np.pi * rim.radius:
        return 1.0
    half = 0.5 * length(points[rim.corner[-1]] - points[rim.corner[0]])
    height_squared = max(rim.radius * rim.radius - half * half, 0.0)
    return rim.radius / max(
        rim.radius - float(np.sqrt(height_squared)), 1e-3 * rim.radius
    )


def _with_frame(points: Array, rims: Sequence[Rim]) -> Group:
    """Common axis: least moment of rims along it and their centres across it."""
    first = rims[0]
    axis = first.axis
    center = first.center
    if len(rims) > 1:
        weight = np.array([float(len(rim.corner)) for rim in rims])
        centers = np.array([rim.center for rim in rims])
        center = (weight[:, None] * centers).sum(axis=0) / weight.sum()
        tensor = np.zeros((3, 3))
        for rim, number in zip(rims, weight.tolist(), strict=True):
            center_offset = rim.center - center
            outer = center_offset[:, None] * center_offset
            tensor += number * (scatter(points[rim.corner]) - outer)
            tensor += number * (outer[0, 0] + outer[1, 1] + outer[2, 2]) * np.eye(3)
        axis = principal_axes(tensor)[1][:, 0]
    if axis[int(np.abs(axis).argmax())] < 0.0:
        axis = -axis
    coordinate_axis = np.eye(3)[np.abs(axis).argmin()]
    x_axis = coordinate_axis - (coordinate_axis * axis).sum() * axis
    x_axis = x_axis / length(x_axis)
    return Group(center, np.stack([x_axis, cross(axis, x_axis), axis]), list(rims))
