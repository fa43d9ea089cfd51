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

"""The paper's random polyhedra (section 3.A), with the shift of the centre of mass as a
parameter.

This module is imported by itself: unlike other shapes it needs parts and their poses,
since bodies without two stable poses are drawn anew. Random words come straight from
Philox, whose stream numpy keeps; its distributions are not promised to stay, and the C
library's logarithm rounds differently on other processors.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, islice
from typing import Final

import numpy as np

from ros_pose_stats.base.errors import MassPropertiesError, MeshError, RequestError
from ros_pose_stats.core.kernels.elementary import sines_cosines
from ros_pose_stats.core.kernels.principal_axes import principal_axes
from ros_pose_stats.core.mesh.parts import part_from_mesh
from ros_pose_stats.core.mesh.vectors import lengths, turn_vectors
from ros_pose_stats.core.records import Array, Index, Part
from ros_pose_stats.core.resting.poses import resting_poses

from .shapes import hull_mesh

_STREAM: Final = 3
"""Second word of the generator's key; 1 and 2 are the starting directions'."""

_LN2_HIGH = 0.6931471803691238
_LN2_LOW = 1.9082149292705877e-10
"""ln 2 in two parts; the products of the first with binary exponents are exact."""


def uniforms(seed: int, number: int, attempt: int) -> Iterator[float]:
    """Yield numbers of 53 bits in [0, 1), different ones for each seed, number and
    attempt.
    """
    bits = np.random.Philox(
        counter=np.array((0, attempt, number, 0), dtype=np.uint64),
        key=np.array((seed, _STREAM), dtype=np.uint64),
    )
    while True:
        for word in bits.random_raw(64):
            yield (int(word) >> 11) * 2.0**-53


def normals(numbers: Iterator[float], count: int) -> Array:
    """Draw normal numbers (count,) by Box and Muller (1958), one of each pair."""
    pairs = np.array(list(islice(numbers, 2 * count))).reshape(count, 2)
    radius = np.sqrt(-2.0 * logarithms(1.0 - pairs[:, 0]))
    return np.asarray(radius * sines_cosines((2.0 * math.pi) * pairs[:, 1])[1])


def logarithms(values: Array) -> Array:
    """Natural logarithms (n,) of normal numbers (n,) above 0 (DLMF 4.6.4), alike
    everywhere.

    As in `kernels.elementary` there are only additions, multiplications and divisions
    in them.
    """
    m, n = np.frexp(values)
    small = m <= 0.5 * 1.4142135623730951
    m = np.where(small, 2.0 * m, m)
    n = n - small
    s = (m - 1.0) / (m + 1.0)
    q = s * s
    series = q * (1 / 21)
    for odd in range(19, 1, -2):
        series = q * (1 / odd + series)
    return np.asarray(2.0 * (s + s * series) + n * _LN2_LOW + n * _LN2_HIGH)


def failures(numbers: Iterator[float], chance: float) -> int:
    """Draw the number of failures before the first success of this chance
    (geometric).
    """
    chance_left = 1.0 - next(numbers)
    count = 0
    threshold = 1.0 - chance
    while chance_left <= threshold:
        count = count + 1
        threshold = threshold * (1.0 - chance)
    return count


SHIFT_MOMENTS: Final = ("inertia", "second")
"""Moments whose root is the range q_i of the shift; see `random_polyhedron`."""

_FEWEST_POINTS: Final = 4
_LAST_POINT: Final = 0.1
"""Chance, after each of the points from the fourth on, that it is the last one."""

_SEEDS: Final = 2**64


@dataclass(frozen=True, eq=False)
class RandomPolyhedron:
    """A convex body and its centre of mass.

    Attributes
    ----------
    vertices : (V, 3) array
        About the centroid, the farthest at distance 1.
    triangles : (T, 3) array of int
    center_of_mass : (3,) array
        After the shift.
    redraws : int
        Bodies that were drawn and thrown away before this one.
    """

    vertices: Array
    triangles: Index
    center_of_mass: Array
    redraws: int

    def part(self) -> Part:
        """Make a part, a unit being a metre, with the central inertia of the
        homogeneous body.
        """
        return part_from_mesh(
            self.vertices, self.triangles, center_of_mass=self.center_of_mass
        )


def random_polyhedron(
    seed: int, number: int, shift: float = 0.0, shift_moment: str = "inertia"
) -> RandomPolyhedron:
    """One body of an endless series.

    It is the homogeneous, scaled hull of 4 + xi points with normally distributed
    coordinates, xi being geometric with parameter 0.1. Its centre of mass is moved
    along each principal axis by a number drawn from (-shift q_i, shift q_i). If it then
    lies outside the hull, or one face alone is stable, everything is drawn anew, the
    points too.

    Parameters
    ----------
    seed : int
        Of the series, 0 to 2^64 - 1.
    number : int
        Place in the series, from 0; a body depends on these two and the shift alone.
    shift : float
        Scale of the shift, at least 0; 1 as printed in the paper.
    shift_moment : {'inertia', 'second'}
        q_i² is a principal moment of inertia over the mass, as printed, or the
        principal second moment (the integral of x_i² over the mass).

    Raises
    ------
    RequestError
        If a value is out of its range.
    """
    check_shift(shift, shift_moment)
    for name, value in (("seed", seed), ("number", number)):
        if (
            isinstance(value, bool)
            or not isinstance(value, int)
            or not 0 <= value < _SEEDS
        ):
            raise RequestError(
                f"a {name} from 0 to 2^64 - 1", f"{value!r}", "0 is a good start"
            )
    for attempt in count():
        body = _draw_body(uniforms(seed, number, attempt), shift, shift_moment, attempt)
        if body is not None:
            return body
    raise AssertionError


def check_shift(shift: float, shift_moment: str) -> None:
    """Refuse a shift scale or moment that `random_polyhedron` does not take."""
    number = isinstance(shift, (int, float)) and not isinstance(shift, bool)
    if not number or not 0.0 <= shift < math.inf:
        raise RequestError(
            "a shift scale of at least 0",
            f"{shift!r}",
            "1 is the paper's text, 0.25 comes near its figures",
        )
    if shift_moment not in SHIFT_MOMENTS:
        raise RequestError(
            f"a shift moment out of {', '.join(SHIFT_MOMENTS)}",
            f"{shift_moment!r}",
            "inertia is the paper's text",
        )


def _draw_body(
    numbers: Iterator[float], shift: float, shift_moment: str, attempt: int
) -> RandomPolyhedron | None:
    """Draw a body from uniform numbers in [0, 1); None where it is to be drawn anew."""
    count_of_points = _FEWEST_POINTS + failures(numbers, _LAST_POINT)
    points = normals(numbers, 3 * count_of_points).reshape(count_of_points, 3)
    moves = np.array([2.0 * next(numbers) - 1.0 for _ in range(3)])
    try:
        vertices, triangles = hull_mesh(points)
        plain = part_from_mesh(vertices, triangles)
        vertices = vertices - plain.center_of_mass
        scale = float(lengths(vertices).max())
        moved = _shift_center(
            plain.inertia / (plain.mass * scale * scale), moves, shift, shift_moment
        )
        body = RandomPolyhedron(vertices / scale, triangles, moved, attempt)
        poses = resting_poses(body.part(), 0.0, 0).poses
    except (MeshError, MassPropertiesError):  # too flat, or the centre outside the hull
        return None
    return body if len(poses) > 1 else None


def _shift_center(
    inertia: Array, moves: Array, shift: float, shift_moment: str
) -> Array:
    """The moved centre of mass (3,) from the inertia over the mass and moves in (-1,
    1).
    """
    moments, axes = principal_axes(inertia)
    if shift_moment == "second":
        moments = 0.5 * moments.sum() - moments
    # Each axis points to the side of its largest component.
    axes = axes * np.where(axes[np.abs(axes).argmax(axis=0), range(3)] < 0.0, -1.0, 1.0)
    steps = shift * moves * np.sqrt(np.maximum(moments, 0.0))
    return np.asarray(turn_vectors(steps[None], axes.T)[0])
