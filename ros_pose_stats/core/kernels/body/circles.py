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

"""Circles through corners of a chain of edges."""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import Array, Fixed1, Fixed2, Index
from ..compilation import entry_kernel, inlined, kernel
from ..elementary import arctangent
from ..vectors import (
    Vec3,
    add,
    cross,
    divide,
    dot,
    length,
    point_at,
    read_vector,
    scale,
    subtract,
)

ON_CIRCLE = 1e-3
"""Corners this close to a circle, in heights of their arc, are a run on it.

At most of its radius. Exports put them there to some 1e-6; an ellipse 1 : 1.002 is off
by as much.
"""

ROUNDINGS_OFF_CIRCLE = 4.0
"""They may also be off by this many roundings of the coordinates."""


class Chain(NamedTuple):
    """Edges of a hull, each of which goes on where the previous one ends."""

    points: Array  # (H, 3) hull points
    corner: Index  # hull point where each edge begins, then where the last one ends
    side: Index  # polygon side of each edge
    rounding: float  # of the coordinates


class Circle(NamedTuple):
    """A circle in space, with the height of the arc that it was laid through."""

    center: Vec3
    axis: Vec3
    radius: float
    height: float


@kernel
def circle_of(chain: Chain, i: int, j: int) -> Circle:
    """Circle through three of the corners i to j of a chain, far apart."""
    points = chain.points
    corner = chain.corner
    a = point_at(points, corner[i])
    b = point_at(points, corner[j])
    chord = subtract(b, a)
    size = length(chord)
    farthest = (i + j) // 2
    height = -1.0
    for k in range(i + 1, j):
        offset = subtract(point_at(points, corner[k]), a)
        if size > 0.0:
            offset = subtract(offset, scale(chord, dot(offset, chord) / (size * size)))
        if length(offset) > height:
            farthest = k
            height = length(offset)
    c = point_at(points, corner[farthest])
    if 2.0 * size < height:  # nearly or fully once around
        a = point_at(points, corner[i + (j - i) // 3])
        b = point_at(points, corner[i + 2 * (j - i) // 3])
        c = point_at(points, corner[i])
    u = subtract(b, a)
    v = subtract(c, a)
    normal = cross(u, v)
    normal_square = dot(normal, normal)
    if normal_square == 0.0:
        return Circle(a, Vec3(0.0, 0.0, 0.0), 0.0, 0.0)
    to_center = cross(subtract(scale(v, dot(u, u)), scale(u, dot(v, v))), normal)
    to_center = scale(to_center, 0.5 / normal_square)
    radius = length(to_center)
    return Circle(
        add(a, to_center),
        divide(normal, math.sqrt(normal_square)),
        radius,
        min(height, radius),
    )


@inlined
def circle_tolerance(circle: Circle, rounding: float) -> float:
    """By how much a corner of a run may be off its circle."""
    return ON_CIRCLE * circle.height + ROUNDINGS_OFF_CIRCLE * rounding


@inlined
def circle_distance(circle: Circle, point: Vec3) -> float:
    """Distance of a point from a circle."""
    offset = subtract(point, circle.center)
    height = dot(offset, circle.axis)
    radial = length(subtract(offset, scale(circle.axis, height))) - circle.radius
    return math.sqrt(height * height + radial * radial)


@kernel
def fit_circle(chain: Chain, i: int, j: int, rough: Circle) -> Circle:
    """Circle by least squares (Kasa's), its plane by the area that the corners enclose.

    The axis is turned so that the run goes round it counter-clockwise.
    """
    points = chain.points
    corner = chain.corner
    last = j if corner[i] != corner[j] else j - 1
    count = float(last - i + 1)
    center = Vec3(0.0, 0.0, 0.0)
    for k in range(i, last + 1):
        center = add(center, subtract(point_at(points, corner[k]), rough.center))
    center = add(rough.center, divide(center, count))
    area = Vec3(0.0, 0.0, 0.0)
    previous = subtract(point_at(points, corner[last]), center)
    for k in range(i, last + 1):
        offset = subtract(point_at(points, corner[k]), center)
        area = add(area, cross(previous, offset))
        previous = offset
    axis = divide(area, length(area))
    x_axis = subtract(point_at(points, corner[i]), center)
    x_axis = subtract(x_axis, scale(axis, dot(x_axis, axis)))
    x_axis = divide(x_axis, length(x_axis))
    y_axis = cross(axis, x_axis)
    xx = xy = yy = xr = yr = rr = 0.0
    for k in range(i, last + 1):
        offset = subtract(point_at(points, corner[k]), center)
        x = dot(offset, x_axis)
        y = dot(offset, y_axis)
        square = x * x + y * y
        xx = xx + x * x
        xy = xy + x * y
        yy = yy + y * y
        xr = xr + x * square
        yr = yr + y * square
        rr = rr + square
    determinant = 2.0 * (xx * yy - xy * xy)
    if determinant <= 0.0:
        return Circle(rough.center, axis, rough.radius, rough.height)
    x = (xr * yy - yr * xy) / determinant
    y = (yr * xx - xr * xy) / determinant
    radius = math.sqrt(x * x + y * y + rr / count)
    return Circle(
        add(center, add(scale(x_axis, x), scale(y_axis, y))),
        axis,
        radius,
        rough.height,
    )


@entry_kernel
def angles_about(
    points: Fixed2, center: Fixed1, x_axis: Fixed1, y_axis: Fixed1
) -> Array:
    """Angles (n,) of points (n, 3) about an axis through `center`, from -pi to pi."""
    angles = np.empty(points.shape[0])
    origin = read_vector(center, 0)
    x = read_vector(x_axis, 0)
    y = read_vector(y_axis, 0)
    for i in range(points.shape[0]):
        offset = subtract(point_at(points, i), origin)
        angles[i] = arctangent(dot(offset, y), dot(offset, x))
    return angles
