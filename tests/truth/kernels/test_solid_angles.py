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

"""Solid angles: of triangles against fifty-digit arithmetic, below a level against a
grid.
"""

from decimal import Decimal, localcontext

import numpy as np
import pytest

from lab.bodies.samples import convex_parts
from lab.bodies.variants import rotation
from ros_pose_stats.core.kernels.vectors import Vec3
from ros_pose_stats.core.resting.convex_body import body_of
from tests.truth.reference.sphere_grid import Shape, areas_below

from . import helpers

PARTS = convex_parts()
every_body = pytest.mark.parametrize(
    "body", [body_of(part, 0) for part in PARTS.values()], ids=PARTS
)


def angles_below(body, level, of_R):
    triangles = helpers.measure_triangles(body.arrays, np.array([level]), of_R)
    faces = np.arange(len(body.arrays.distance))
    return np.array(
        [
            helpers.faces_below(faces, f, f + 1, body.arrays, triangles, level, of_R)
            for f in faces.tolist()
        ]
    )


def below_r(body, level):
    return angles_below(body, level, of_R=False)


def below_R(body, level):
    return angles_below(body, level, of_R=True)


def precise_angle(*corners):
    """Solid angle of a small triangle seen from the origin; corners are exact as given.

    tan(angle/2) by Van Oosterom and Strackee in decimal arithmetic, and the
    arctangent's series, which converges for tangents below 1.
    """

    def dot(p, q):
        return sum((x * y for x, y in zip(p, q, strict=True)), Decimal(0))

    with localcontext() as context:
        context.prec = 50
        a, b, c = ([Decimal(float(x)) for x in corner] for corner in corners)
        la, lb, lc = (dot(p, p).sqrt() for p in (a, b, c))
        triple = (
            a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        tangent = triple / (
            la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
        )
        term = tangent
        total = tangent
        k = 1
        while abs(term) > Decimal("1e-48") * abs(tangent):
            term *= -tangent * tangent
            k += 2
            total += term / k
        return float(2 * total)


def solid_angle(*corners):
    return helpers.solid_angle(*(Vec3(*corner) for corner in corners))


@pytest.mark.parametrize("width", [0.3, 1e-2, 1e-6, 1e-9])
def test_small_triangles_keep_their_digits(width):
    across = np.array(((0.3, -0.2, 0.0), (1.1, 0.1, 0.0), (-0.4, 0.9, 0.0)))
    for seed in range(5):
        corners = (across * width + (0.0, 0.0, 1.0)) @ rotation(seed).T
        # Rounding a corner moves it by 1e-16: the triangle is no better known than
        # that.
        assert solid_angle(*corners) == pytest.approx(
            precise_angle(*corners), rel=2e-15 / width
        )


def test_octants_and_the_sign():
    axes = np.eye(3)
    assert solid_angle(*axes) == pytest.approx(np.pi / 2.0, rel=1e-15)
    assert solid_angle(*axes[[1, 0, 2]]) == pytest.approx(-np.pi / 2.0, rel=1e-15)
    assert solid_angle(*(axes * np.array((5.0, 0.1, 3.0)))) == pytest.approx(
        np.pi / 2, rel=1e-15
    )


def test_more_than_half_of_the_sphere():
    corners = np.array(((1.0, 0.0, 0.1), (-0.5, 0.8, 0.1), (-0.5, -0.8, 0.1)))
    lower = corners * (1.0, 1.0, -1.0)
    big = solid_angle(*corners)
    small = solid_angle(*lower[[0, 2, 1]])
    assert big == pytest.approx(-solid_angle(*corners[[0, 2, 1]]), rel=1e-15)
    assert small == pytest.approx(big, rel=1e-14)
    belt = sum(
        solid_angle(*triangle)
        for i in range(3)
        for triangle in (
            (corners[i], lower[i], lower[(i + 1) % 3]),
            (corners[i], lower[(i + 1) % 3], corners[(i + 1) % 3]),
        )
    )
    assert big + small + belt == pytest.approx(4.0 * np.pi, rel=1e-14)


def test_products_of_vectors_are_numpys():
    a, b = np.random.default_rng(3).standard_normal((2, 3))
    matrix = np.random.default_rng(4).standard_normal((3, 3))
    assert helpers.cross(Vec3(*a), Vec3(*b)) == pytest.approx(np.cross(a, b), rel=1e-14)
    assert helpers.dot(Vec3(*a), Vec3(*b)) == pytest.approx(a @ b, rel=1e-14)
    assert helpers.transform(matrix, Vec3(*a)) == pytest.approx(matrix @ a, rel=1e-14)
    assert helpers.inverse_of(matrix) @ matrix == pytest.approx(np.eye(3), abs=1e-13)
    assert helpers.area_vector(
        Vec3(1.0, 1.0, 5.0), Vec3(3.0, 1.0, 5.0), Vec3(1.0, 4.0, 5.0)
    ) == (0.0, 0.0, 3.0)


@every_body
def test_below_a_level_areas_grow_from_nothing_to_the_sphere(body):
    lowest = body.arrays.distance.min()
    for angles in (below_r, below_R):
        assert np.abs(angles(body, lowest)).max() == 0.0
        assert angles(body, 1.0).sum() == pytest.approx(4.0 * np.pi, rel=1e-12)
    assert below_r(body, 1.0) == pytest.approx(body.arrays.angle, abs=1e-10)
    levels = np.linspace(lowest, 1.0, 200)
    on_faces = np.array([below_r(body, level) for level in levels])
    total = np.array([below_R(body, level).sum() for level in levels])
    assert np.diff(on_faces, axis=0).min() > -1e-12
    assert np.diff(total).min() > -1e-12
    # r <= R: the set below a level of R lies inside that of r.
    assert np.all(total <= on_faces.sum(axis=1) + 1e-12)


@every_body
def test_areas_are_continuous_in_the_level(body):
    """On each face for r; in sum for R, whose shares pass from face to face at once."""
    arrays = body.arrays
    for mark in np.concatenate((arrays.distance, arrays.reach, arrays.radius)):
        below = mark - 1e-11
        above = mark + 1e-11
        step = below_r(body, above) - below_r(body, below)
        flow = below_R(body, above).sum() - below_R(body, below).sum()
        # The steepest slope is that of a cap, 2 pi/d, on as many as twenty faces at
        # once.
        assert np.abs(step).max() < 2e-10 / arrays.distance.min()
        assert abs(flow) < 4e-9 / arrays.distance.min()


def test_the_area_of_a_disc_within_a_face_is_that_of_a_cap():
    body = body_of(PARTS["box, shifted centre"], 0)
    arrays = body.arrays
    for face, d in enumerate(arrays.distance):  # the foot of the centre is within each
        rim = arrays.reach[arrays.face_start[face] : arrays.face_start[face + 1]].min()
        for level in np.linspace(d, rim, 5):
            assert below_r(body, level)[face] == pytest.approx(
                2.0 * np.pi * (level - d) / level, rel=1e-9, abs=1e-14
            )


def test_areas_against_a_grid_on_the_sphere():
    body = body_of(PARTS["leaning prism"], 0)
    shape = Shape(body.points, np.zeros(3))
    plane = (shape.normals @ body.arrays.normal.T).argmax(axis=1)
    lowest = body.arrays.distance.min()
    levels = lowest + np.array((0.05, 0.2, 0.4, 0.6, 0.8, 0.95)) * (1.0 - lowest)
    for level, on_planes in zip(levels, areas_below(shape, "r", levels), strict=True):
        assert below_r(body, level)[plane] == pytest.approx(on_planes, abs=2e-3)
    for level, at_vertices in zip(levels, areas_below(shape, "R", levels), strict=True):
        assert below_R(body, level).sum() == pytest.approx(at_vertices.sum(), abs=4e-3)
