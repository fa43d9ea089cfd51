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

"""A frame that a convex body carries with it, however it is turned, scaled or mirrored.

Principal axes will not do: where two moments nearly tie, rounding turns them. All three
steps here choose among directions that belong to the body the one of greatest
`_prominence`, a function on the sphere that has the symmetries of the body and, but by
accident, no others. So two choices that tie are carried into each other by a symmetry
of the body, and it does not matter which of them rounding picks; where symmetry is
broken the function tells them apart by as much as it is broken.
"""

import numpy as np

from ..array_types import Array, Fixed1, Fixed2, FixedIndex1
from ..compilation import entry_kernel, kernel
from ..vectors import (
    Vec3,
    add,
    cross,
    divide,
    dot,
    length,
    point_at,
    scale,
    subtract,
    transform,
    write_row,
)

_POLE = 1.1
"""How far out the poles of the prominence are.

Nearer to 1 it tells finer patterns apart: a pattern that repeats m times a turn has
some .64 ** m of what the whole body has.
"""

_OFFSET = 0.3
"""Added to the distance of a face, in radii, so that its area counts by itself too."""

_WIDE_ENOUGH = 0.118
"""Share of the largest face across the first axis from which on a face may set the
second one; slivers have poor normals.

No ratio of round numbers is likely to be this one.
"""


@entry_kernel
def own_frame(
    normal: Fixed2,
    distance: Fixed1,
    area: Fixed1,
    stable: FixedIndex1,
    inertia: Fixed2,
) -> Array:
    """Axes (3, 3) of a body as columns; left-handed for one of two mirror images.

    Its faces by normal, distance and area, those that are stable, and its inertia, in
    radii and of unit mass.
    """
    weight = area * (distance + _OFFSET)
    first = point_at(normal, stable[0])
    greatest = -np.inf
    for k in range(stable.shape[0]):
        direction = point_at(normal, stable[k])
        prominence = _prominence(normal, weight, inertia, direction)
        if prominence > greatest:
            greatest = prominence
            first = direction
    second = _second_axis(normal, area, weight, inertia, first)
    third = cross(first, second)
    near = add(scale(first, 0.48), scale(second, 0.6))
    ahead = _prominence(normal, weight, inertia, add(near, scale(third, 0.64)))
    behind = _prominence(normal, weight, inertia, subtract(near, scale(third, 0.64)))
    if behind > ahead:
        third = scale(third, -1.0)
    axes = np.empty((3, 3))
    write_row(axes, 0, 0, Vec3(first.x, second.x, third.x))
    write_row(axes, 1, 0, Vec3(first.y, second.y, third.y))
    write_row(axes, 2, 0, Vec3(first.z, second.z, third.z))
    return axes


@kernel
def _second_axis(
    normal: Array, area: Array, weight: Array, inertia: Array, first: Vec3
) -> Vec3:
    """Direction across the first axis that a large face of the body points in."""
    across = np.empty_like(area)
    for f in range(area.shape[0]):
        sine = length(cross(first, point_at(normal, f)))
        across[f] = area[f] * sine * sine
    least = _WIDE_ENOUGH * across.max()
    greatest = -np.inf
    second = first
    for f in range(area.shape[0]):
        if across[f] < least:
            continue
        outward = point_at(normal, f)
        direction = subtract(outward, scale(first, dot(first, outward)))
        direction = divide(direction, length(direction))
        oblique = add(scale(first, 0.6), scale(direction, 0.8))
        prominence = _prominence(normal, weight, inertia, oblique)
        if prominence > greatest:
            greatest = prominence
            second = direction
    return second


@kernel
def _prominence(normal: Array, weight: Array, inertia: Array, direction: Vec3) -> float:
    """How much of a body faces a direction, and its inertia about that."""
    total = dot(direction, transform(inertia, direction))
    for f in range(weight.shape[0]):
        total += weight[f] / (_POLE - dot(point_at(normal, f), direction))
    return total
