"""Solid angles of triangles, down to the smallest, against fifty-digit arithmetic."""

from __future__ import annotations

from decimal import Decimal, getcontext

import numpy as np
import pytest

from ros_pose_stats.kernels import vectors
from ros_pose_stats.kernels.vectors import Vec3, area_vector
from tests.bodies import rotation

getcontext().prec = 50


def precise_angle(*corners):
    """Solid angle of a small triangle seen from the origin; corners are exact as given.

    tan(angle/2) by Van Oosterom and Strackee in decimal arithmetic, and the arctangent's
    series, which converges for tangents below 1.
    """
    a, b, c = ([Decimal(float(x)) for x in corner] for corner in corners)

    def dot(p, q):
        return sum((x * y for x, y in zip(p, q, strict=True)), Decimal(0))

    la, lb, lc = (dot(p, p).sqrt() for p in (a, b, c))
    triple = (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
              + a[2] * (b[0] * c[1] - b[1] * c[0]))
    tangent = triple / (la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    term, total, k = tangent, tangent, 1
    while abs(term) > Decimal("1e-48") * abs(tangent):
        term *= -tangent * tangent
        k += 2
        total += term / k
    return float(2 * total)


def solid_angle(*corners):
    return vectors.solid_angle(*(Vec3(*corner) for corner in corners))


TINY = np.array(((0.3, -0.2, 0.0), (1.1, 0.1, 0.0), (-0.4, 0.9, 0.0)))


@pytest.mark.parametrize("width", [0.3, 1e-2, 1e-4, 1e-6, 1e-9])
def test_small_triangles_keep_their_digits(width):
    for seed in range(5):
        corners = (TINY * width + (0.0, 0.0, 1.0)) @ rotation(seed).T
        # Rounding a corner moves it by 1e-16: the triangle is no better known than that.
        assert solid_angle(*corners) == pytest.approx(precise_angle(*corners), rel=2e-15 / width)


@pytest.mark.parametrize("width", [1e-2, 1e-4, 1e-6])
def test_exact_small_triangles(width):
    # Corners without rounding in their differences: the result is good to the last digits.
    step = 2.0 ** np.floor(np.log2(width))
    corners = np.array(((0.0, 0.0, 1.0), (step, 0.0, 1.0), (0.0, step, 1.0)))
    angle = solid_angle(*corners)
    assert angle == pytest.approx(precise_angle(*corners), rel=1e-15)
    assert angle == pytest.approx(step * step / 2.0, rel=step)


def test_octants_and_the_sign():
    axes = np.eye(3)
    assert solid_angle(*axes) == pytest.approx(np.pi / 2.0, rel=1e-15)
    assert solid_angle(*axes[[1, 0, 2]]) == pytest.approx(-np.pi / 2.0, rel=1e-15)
    assert solid_angle(*(axes * np.array((5.0, 0.1, 3.0)))) == pytest.approx(np.pi / 2, rel=1e-15)


def test_more_than_half_of_the_sphere():
    corners = np.array(((1.0, 0.0, 0.1), (-0.5, 0.8, 0.1), (-0.5, -0.8, 0.1)))
    lower = corners * (1.0, 1.0, -1.0)
    big, small = solid_angle(*corners), solid_angle(*lower[[0, 2, 1]])
    assert big == pytest.approx(-solid_angle(*corners[[0, 2, 1]]), rel=1e-15)
    assert small == pytest.approx(big, rel=1e-14)
    belt = sum(solid_angle(*triangle) for i in range(3) for triangle in (
        (corners[i], lower[i], lower[(i + 1) % 3]),
        (corners[i], lower[(i + 1) % 3], corners[(i + 1) % 3])))
    assert big + small + belt == pytest.approx(4.0 * np.pi, rel=1e-14)


def test_area_vector():
    assert area_vector(Vec3(1.0, 1.0, 5.0), Vec3(3.0, 1.0, 5.0), Vec3(1.0, 4.0, 5.0)) == (
        0.0, 0.0, 3.0)


def test_vectors_are_numpys():
    """Components in the right places, for every helper."""
    a, b = np.random.default_rng(3).standard_normal((2, 3))
    matrix = np.random.default_rng(4).standard_normal((3, 3))
    one, two = Vec3(*a), Vec3(*b)
    expected = {
        "plus": a + b, "minus": a - b, "times": a * b, "over": a / b, "cross": np.cross(a, b),
        "dot": a @ b}
    for name, value in expected.items():
        assert getattr(vectors, name)(one, two) == pytest.approx(value, rel=1e-15, abs=1e-15)
    assert vectors.scaled(one, 2.5) == tuple(2.5 * a)
    assert vectors.divided(one, 2.5) == tuple(a / 2.5)
    assert vectors.dot_from(2.0, one, two) == pytest.approx(2.0 + a @ b, rel=1e-15)
    assert vectors.length(one) == pytest.approx(np.linalg.norm(a), rel=1e-15)
    assert vectors.turned(matrix, one) == pytest.approx(matrix @ a, rel=1e-14)


def test_reading_and_writing():
    values, table = np.arange(6.0), np.arange(12.0).reshape(2, 6)
    assert vectors.read_vector(values, 2) == (2.0, 3.0, 4.0)
    assert vectors.read_row(table, 1, 3) == (9.0, 10.0, 11.0)
    assert vectors.point_at(table, 1) == (6.0, 7.0, 8.0)
    vectors.write_vector(values, 3, Vec3(7.0, 8.0, 9.0))
    vectors.write_row(table, 0, 1, Vec3(7.0, 8.0, 9.0))
    assert values.tolist() == [0.0, 1.0, 2.0, 7.0, 8.0, 9.0]
    assert table[0].tolist() == [0.0, 7.0, 8.0, 9.0, 4.0, 5.0]
