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

"""Outlines in the plane: circles, rounded polygons, gears.

An outline is an (N, 2) array of corners, counter-clockwise, not repeated at the end.
"""

from collections.abc import Sequence

import numpy as np

from ..kernels.elementary import sines_cosines
from ..records import Array, Index

Outline = Array  # corners of a closed polygon, (N, 2), counter-clockwise
Surface = tuple[Array, Index]  # vertices (V, 3) and outward triangles (T, 3), closed


def unit_circle(sides: int) -> Outline:
    """Corners (sides, 2) of a regular polygon on the unit circle, from the x axis on.

    Each is found from an angle in the first octant, so that reflections and quarter
    turns of the polygon map its coordinates onto each other bit for bit.
    """
    octant, eighths = np.divmod(8 * np.arange(sides), sides)
    eighths = np.where(octant % 2 == 1, sides - eighths, eighths)
    angle = eighths * (np.pi / 4.0 / sides)
    is_diagonal = eighths == sides
    sine, cosine = sines_cosines(angle)
    larger = np.where(is_diagonal, np.sqrt(0.5), cosine)
    smaller = np.where(is_diagonal, np.sqrt(0.5), sine)
    is_steep = np.isin(octant, (1, 2, 5, 6))
    x = np.where(is_steep, smaller, larger) * np.where(
        np.isin(octant, (2, 3, 4, 5)), -1.0, 1.0
    )
    y = np.where(is_steep, larger, smaller) * np.where(octant >= 4, -1.0, 1.0)
    return np.column_stack((x, y)) + 0.0


def rounded_polygon(
    corners: Sequence[tuple[float, float, float]], steps: int = 6
) -> Outline:
    """Polygon (N, 2) of counter-clockwise corners with tangent arcs of their radii.

    0 is sharp.
    """
    points = np.array([corner[:2] for corner in corners], dtype=np.float64)
    return np.concatenate(
        [
            _fillet(
                points[i - 1],
                points[i],
                points[(i + 1) % len(points)],
                corner[2],
                steps,
            )
            for i, corner in enumerate(corners)
        ]
    )


def _fillet(
    previous_corner: Outline,
    corner: Outline,
    next_corner: Outline,
    radius: float,
    steps: int,
) -> Outline:
    """Arc of `radius` tangent to both sides of a corner, (steps + 1, 2)."""
    if radius == 0.0:
        return corner[None, :]
    incoming = (corner - previous_corner) / np.linalg.norm(corner - previous_corner)
    outgoing = (next_corner - corner) / np.linalg.norm(next_corner - corner)
    turn = np.arctan2(
        incoming[0] * outgoing[1] - incoming[1] * outgoing[0], incoming @ outgoing
    )
    start = corner - incoming * radius * np.tan(abs(turn) / 2.0)
    inward = np.sign(turn) * np.array((-incoming[1], incoming[0]))
    sweep = np.linspace(0.0, abs(turn), steps + 1)[:, None]
    arc: Outline = start + radius * (
        np.sin(sweep) * incoming + (1.0 - np.cos(sweep)) * inward
    )
    return arc


def spur_gear(teeth: int, module: float) -> Outline:
    """Involute spur gear (N, 2), addendum 1 and dedendum 1.25 modules.

    The first tooth points along x; below the base circle flanks run radially to the
    root circle.
    """
    pitch = teeth * module / 2.0
    pressure = np.radians(20.0)
    base = pitch * np.cos(pressure)
    tip = pitch + module
    radii = np.linspace(max(base, pitch - module), tip, 5)
    half_tooth = np.pi / (2.0 * teeth) + np.tan(pressure) - pressure
    roll = np.sqrt(np.maximum((radii / base) ** 2 - 1.0, 0.0))
    # less the involute's polar angle
    half_widths = half_tooth - (roll - np.arctan(roll))
    radii = np.concatenate(((pitch - 1.25 * module,), radii))
    half_widths = np.concatenate((half_widths[:1], half_widths))
    radius = np.concatenate((radii, radii[::-1]))
    angle = np.concatenate((-half_widths, half_widths[::-1]))
    tooth = radius[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    cos, sin = unit_circle(teeth).T
    turns = np.stack(
        (np.stack((cos, sin), axis=-1), np.stack((-sin, cos), axis=-1)), axis=1
    )
    return np.asarray((tooth @ turns).reshape(-1, 2))


def prism(sides: int, radius: float, length: float) -> Surface:
    """Regular prism along z about the origin; the first corner lies on the x axis."""
    base = radius * unit_circle(sides)
    height = np.full((sides, 1), length / 2.0)
    vertices = np.vstack((np.hstack((base, -height)), np.hstack((base, height))))
    begin = np.arange(sides)
    end = np.roll(begin, -1)
    fan = np.column_stack((np.zeros(sides - 2, dtype=np.int64), begin[1:-1], begin[2:]))
    walls = np.vstack(
        (
            np.column_stack((begin, end, end + sides)),
            np.column_stack((begin, end + sides, begin + sides)),
        )
    )
    return vertices, np.vstack((fan[:, ::-1], fan + sides, walls)).astype(np.int64)
