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
"""Corners this close to a circle, as a fraction of the height of their arc, are a run on it.

At most of its radius. Exports put them there to some 1e-6; an ellipse 1 : 1.002 is off by as much.
"""

ROUNDINGS_OFF_CIRCLE = 4.0
"""They may also be off by this many roundings of the coordinates."""


class Circle(NamedTuple):
    """A circle in space, with the height of the arc that it was laid through."""

    center: Vec3
    axis: Vec3
    radius: float
    height: float


@kernel
def circle_of(points: Array, corner: Index, i: int, j: int) -> Circle:
    """Circle through three of the corners i to j of a chain, far apart."""
    a = point_at(points, corner[i])
    b = point_at(points, corner[j])
    chord = subtract(b, a)
    size = length(chord)
    far = (i + j) // 2
    height = -1.0
    for k in range(i + 1, j):
        away = subtract(point_at(points, corner[k]), a)
        if size > 0.0:
            away = subtract(away, scale(chord, dot(away, chord) / (size * size)))
        if length(away) > height:
            far = k
            height = length(away)
    c = point_at(points, corner[far])
    if 2.0 * size < height:  # nearly or fully once around
        a = point_at(points, corner[i + (j - i) // 3])
        b = point_at(points, corner[i + 2 * (j - i) // 3])
        c = point_at(points, corner[i])
    u = subtract(b, a)
    v = subtract(c, a)
    across = cross(u, v)
    below = dot(across, across)
    if below == 0.0:
        return Circle(a, Vec3(0.0, 0.0, 0.0), 0.0, 0.0)
    toward = cross(subtract(scale(v, dot(u, u)), scale(u, dot(v, v))), across)
    toward = scale(toward, 0.5 / below)
    radius = length(toward)
    return Circle(
        add(a, toward), divide(across, math.sqrt(below)), radius, min(height, radius)
    )


@inlined
def circle_tolerance(circle: Circle, rounding: float) -> float:
    """By how much a corner of a run may be off its circle."""
    return ON_CIRCLE * circle.height + ROUNDINGS_OFF_CIRCLE * rounding


@inlined
def circle_distance(circle: Circle, point: Vec3) -> float:
    """Distance of a point from a circle."""
    away = subtract(point, circle.center)
    above = dot(away, circle.axis)
    beyond = length(subtract(away, scale(circle.axis, above))) - circle.radius
    return math.sqrt(above * above + beyond * beyond)


@kernel
def fit_circle(points: Array, corner: Index, i: int, j: int, rough: Circle) -> Circle:
    """Circle by least squares (Kasa's), its plane by the area that the corners enclose.

    The axis is turned so that the run goes round it counter-clockwise.
    """
    last = j if corner[i] != corner[j] else j - 1
    number = float(last - i + 1)
    middle = Vec3(0.0, 0.0, 0.0)
    for k in range(i, last + 1):
        middle = add(middle, subtract(point_at(points, corner[k]), rough.center))
    middle = add(rough.center, divide(middle, number))
    area = Vec3(0.0, 0.0, 0.0)
    before = subtract(point_at(points, corner[last]), middle)
    for k in range(i, last + 1):
        here = subtract(point_at(points, corner[k]), middle)
        area = add(area, cross(before, here))
        before = here
    axis = divide(area, length(area))
    x_axis = subtract(point_at(points, corner[i]), middle)
    x_axis = subtract(x_axis, scale(axis, dot(x_axis, axis)))
    x_axis = divide(x_axis, length(x_axis))
    y_axis = cross(axis, x_axis)
    xx = xy = yy = xr = yr = rr = 0.0
    for k in range(i, last + 1):
        here = subtract(point_at(points, corner[k]), middle)
        x = dot(here, x_axis)
        y = dot(here, y_axis)
        square = x * x + y * y
        xx = xx + x * x
        xy = xy + x * y
        yy = yy + y * y
        xr = xr + x * square
        yr = yr + y * square
        rr = rr + square
    below = 2.0 * (xx * yy - xy * xy)
    if below <= 0.0:
        return Circle(rough.center, axis, rough.radius, rough.height)
    x = (xr * yy - yr * xy) / below
    y = (yr * xx - xr * xy) / below
    radius = math.sqrt(x * x + y * y + rr / number)
    return Circle(
        add(middle, add(scale(x_axis, x), scale(y_axis, y))),
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
    middle = read_vector(center, 0)
    x = read_vector(x_axis, 0)
    y = read_vector(y_axis, 0)
    for i in range(points.shape[0]):
        away = subtract(point_at(points, i), middle)
        angles[i] = arctangent(dot(away, y), dot(away, x))
    return angles
