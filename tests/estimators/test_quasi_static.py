"""Toppling decided by hand, against an independent toppling, and the rules of PQSE and NQSE."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, resting_poses, shapes
from ros_pose_stats.estimators.quasi_static import (
    nonlinear,
    nqse,
    perturbed_quasi_static,
    pqse,
    qse,
)
from tests.bodies import REGULAR_SOLIDS, clamp_hull, oblique_prism, random_polyhedron
from tests.matching import downs, values
from tests.reference.toppling import Polyhedron, solid_angle


def poses_by_down(part, method):
    found = estimate(part, method, cluster_tolerance=0.0)
    return {tuple(np.round(pose.down, 9) + 0.0): pose.probability for pose in found.poses}


def unit(*vector):
    return tuple(np.round(np.array(vector) / np.linalg.norm(vector), 9) + 0.0)


def fraction(*corners):
    """Solid angle of a fan of corners over the whole sphere."""
    first, *rest = (np.array(corner, dtype=float) for corner in corners)
    return float(sum(solid_angle(first, rest[i], rest[i + 1])
                     for i in range(len(rest) - 1)) / (4.0 * np.pi))


def test_a_leaning_prism_topples_from_its_ends_onto_the_sides_that_overhang():
    # The centre of mass is above x = 1.5, beyond the base's edge at x = 1; by symmetry the
    # other end topples the other way.
    shift, length = 3.0, 4.0
    center = np.array((shift / 2.0, 0.0, length / 2.0))
    base = np.array(((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0),
                     (-1.0, 1.0, 0.0))) - center
    top = base + np.array((shift, 0.0, length))
    end = fraction(*base)
    leaning = fraction(base[1], base[2], top[2], top[1])
    upright = fraction(base[0], base[1], top[1], top[0])
    found = poses_by_down(part_from_mesh(*oblique_prism(shift, length)), "qse")
    assert found == {
        unit(length, 0.0, -shift): pytest.approx(leaning + end, rel=1e-12),
        unit(-length, 0.0, shift): pytest.approx(leaning + end, rel=1e-12),
        unit(0.0, 1.0, 0.0): pytest.approx(upright, rel=1e-12),
        unit(0.0, -1.0, 0.0): pytest.approx(upright, rel=1e-12),
    }
    assert end > 0.01


class TestTetrahedron:
    """(0,0,0), (1,0,0), (0,1,0), (2,2,1): the apex overhangs the base's edge x + y = 1."""

    corners = np.array(((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (2.0, 2.0, 1.0)))

    def test_uniform_density(self):
        # Centroid (3/4, 3/4, 1/4): the foot on z = 0 has x + y = 3/2 and falls onto the face
        # x + y - 3 z = 1; the feet on the other three have positive barycentric coordinates,
        # (0.41, 0.41, 0.18) and twice (0.6, 0.05, 0.35).
        o, a, b, c = self.corners - self.corners.mean(axis=0)
        found = poses_by_down(part_from_mesh(*shapes.hull_mesh(self.corners)), "qse")
        assert found == {
            unit(1.0, 1.0, -3.0): pytest.approx(fraction(a, b, c) + fraction(o, a, b), rel=1e-12),
            unit(0.0, -1.0, 2.0): pytest.approx(fraction(o, a, c), rel=1e-12),
            unit(-1.0, 0.0, 2.0): pytest.approx(fraction(o, b, c), rel=1e-12),
        }

    def test_centre_of_mass_over_the_base(self):
        # Foot (0.4, 0.4, 0) has x + y < 1: now the base is stable, and the foot on
        # x + y - 3 z = 1 is at z = -0.04, beyond the edge that both share. On y = 2 z it is
        # (0.4, 0.36, 0.18), with the coordinates (0.78, 0.04, 0.18): stable.
        center = np.array((0.4, 0.4, 0.1))
        o, a, b, c = self.corners - center
        part = part_from_mesh(*shapes.hull_mesh(self.corners), center_of_mass=center)
        assert poses_by_down(part, "qse") == {
            unit(0.0, 0.0, -1.0): pytest.approx(fraction(o, a, b) + fraction(a, b, c), rel=1e-12),
            unit(0.0, -1.0, 2.0): pytest.approx(fraction(o, a, c), rel=1e-12),
            unit(-1.0, 0.0, 2.0): pytest.approx(fraction(o, b, c), rel=1e-12),
        }


def test_a_pyramid_that_would_topple_over_a_corner_shares_between_both_sides():
    # Square base, the apex beyond a corner on the diagonal: the foot leaves the base through
    # that corner exactly, and both faces there take half by symmetry.
    corners = np.array(((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0),
                        (4.5, 4.5, 5.0)))
    center = np.array((1.5, 1.5, 1.75))
    part = part_from_mesh(*shapes.hull_mesh(corners), center_of_mass=center)
    p = corners - center
    base = fraction(p[0], p[1], p[2], p[3])
    found = poses_by_down(part, "qse")
    overhanging = unit(5.0, 0.0, -3.5)
    assert unit(0.0, 0.0, -1.0) not in found
    assert found[overhanging] == pytest.approx(
        found[unit(0.0, 5.0, -3.5)], rel=1e-12)
    assert found[overhanging] == pytest.approx(fraction(p[1], p[2], p[4]) + base / 2.0, rel=1e-12)


RANDOM = {f"seed {seed}": (random_polyhedron(5 + seed % 25, 100 + seed), seed % 3)
          for seed in range(0, 40, 5)}


@pytest.mark.parametrize(("surface", "shifted"), RANDOM.values(), ids=RANDOM)
def test_against_an_independent_toppling(surface, shifted):
    center = None
    if shifted:
        weights = np.random.default_rng(len(surface[0])).dirichlet(np.ones(len(surface[0])))
        center = weights @ surface[0]
    part = part_from_mesh(*surface, center_of_mass=center)
    reference = Polyhedron(surface[0], part.center_of_mass)
    stable = [face for face in range(len(reference.corners)) if reference.topples_to(face) == face]
    found = estimate(part, "qse", cluster_tolerance=0.0)
    match = (downs(found.poses) @ reference.normals[stable].T).argmax(axis=1)
    assert sorted(match) == list(range(len(stable)))
    assert values(found.poses, "probability") == pytest.approx(
        reference.quasi_static()[stable][match], abs=1e-11)
    for method, weight in (
        ("area", [reference.area_vector(face)[0] for face in stable]),
        ("csae", [reference.angle(face) for face in stable]),
        ("adre", [reference.angle(face) / reference.distance(face) for face in stable]),
    ):
        other = {pose.index: pose.probability
                 for pose in estimate(part, method, cluster_tolerance=0.0).poses}
        assert [other[pose.index] for pose in found.poses] == pytest.approx(
            np.array(weight)[match] / sum(weight), abs=1e-11)


PARTS = {
    "cube": part_from_mesh(*REGULAR_SOLIDS["cube"]),
    "leaning prism": part_from_mesh(*oblique_prism(3.0, 4.0)),
    "clamp hull": part_from_mesh(*clamp_hull(), unit="mm"),
    "random": part_from_mesh(*random_polyhedron(14, 8)),
}


@pytest.mark.parametrize("part", PARTS.values(), ids=PARTS)
class TestPerturbed:
    def test_no_share_is_the_quasi_static_estimate(self, part):
        # But for the order in which the solid angles of all faces are summed.
        resting = resting_poses(part, 0.0)
        assert perturbed_quasi_static(resting, 0.0) == pytest.approx(qse(resting), abs=2e-16)

    def test_a_distribution_for_every_share(self, part):
        for share in (0.01, 0.1, 1.0, 30.0):
            probability = perturbed_quasi_static(resting_poses(part, 0.0), share)
            assert probability.min() >= 0.0
            assert probability.sum() == pytest.approx(1.0, abs=1e-12)

    def test_small_shares_are_linear(self, part):
        resting = resting_poses(part, 0.0)
        change = [perturbed_quasi_static(resting, share) - qse(resting) for share in (1e-6, 2e-6)]
        assert change[1] == pytest.approx(2.0 * change[0], abs=1e-12)


def box_pairs(sides):
    """Faces of a box by their normals' axes: area, share of all directions, arcs of the sides."""
    areas, starts = [], []
    for axis in range(3):
        a, b = (sides[other] / 2.0 for other in range(3) if other != axis)
        d = sides[axis] / 2.0
        areas.append(4.0 * a * b)
        starts.append(math.atan(a * b / (d * math.hypot(a, b, d))) / math.pi)
    arc = {axis: 2.0 * math.atan(sides[axis] / math.hypot(
        *(sides[other] for other in range(3) if other != axis))) for axis in range(3)}
    return areas, starts, arc


def test_perturbed_box_in_closed_form():
    """Each face exchanges with the four around it: 0.4 of the arc over 4 pi, by area."""
    sides = (1.0, 1.1, 1.2)
    areas, starts, arc = box_pairs(sides)
    mean = sum(areas) / 3.0
    expected = {}
    for axis in range(3):
        gain = sum(2.0 * 0.4 * arc[3 - axis - other] / (4.0 * math.pi)
                   * (areas[axis] - areas[other]) / mean for other in range(3) if other != axis)
        expected[axis] = starts[axis] + gain
    resting = resting_poses(part_from_mesh(*shapes.box(*sides)), 0.0)
    for pose, probability in zip(resting.poses, pqse(resting), strict=True):
        assert probability == pytest.approx(expected[int(np.abs(pose.down).argmax())], rel=1e-12)


def test_perturbed_gives_no_more_than_a_face_has():
    """The end of a bar would give more than it has: its neighbours get all of it."""
    resting = resting_poses(part_from_mesh(*shapes.box(1.0, 1.0, 4.0)), 0.0)
    for pose, probability in zip(resting.poses, pqse(resting), strict=True):
        assert probability == pytest.approx(0.25 * (abs(pose.down[2]) < 0.5), abs=1e-15)


@pytest.mark.parametrize("height", [0.2, 0.45, 2.0])
def test_perturbed_takes_the_facets_of_one_pose_as_one_surface(height):
    """A cylinder: the strip along each rim is 0.4 times the difference of base and side wide.

    The two bases and the side are three surfaces, however many facets the side has.
    """
    found = {}
    for sides in (64, 256):
        part = part_from_mesh(*shapes.cylinder(sides, 0.5, height))
        resting = resting_poses(part, round_sides=0)
        (bases,) = {sum(share for pose, share in zip(resting.poses, pqse(resting), strict=True)
                        if abs(pose.down[2]) > 0.5)}
        found[sides] = bases
    base, side = math.pi / 4.0, math.pi * height
    rim = 2.0 * math.pi * 0.5 / math.hypot(0.5, height / 2.0)
    start = 1.0 - height / 2.0 / math.hypot(0.5, height / 2.0)
    gain = 2.0 * 0.4 * rim / (4.0 * math.pi) * (base - side) / ((2.0 * base + side) / 3.0)
    assert found[256] == pytest.approx(min(max(start + gain, 0.0), 1.0), abs=2e-3)
    assert found[64] == pytest.approx(found[256], abs=0.005)


def test_nonlinear_is_eq_6_as_published():
    share = np.linspace(0.0, 1.0, 11)
    expected = [x + x * (1 - x) * (-0.874 + 8.03 * x - 16.3 * x * x + 7.70 * x**3) for x in share]
    assert nonlinear(share) == pytest.approx(expected, rel=1e-14)
    assert nonlinear(np.array([0.0, 1.0])).tolist() == [0.0, 1.0]


def test_nqse_is_never_negative_and_sums_to_one():
    for part in PARTS.values():
        probability = nqse(resting_poses(part, 0.0))
        assert probability.min() >= 0.0
        assert probability.sum() == pytest.approx(1.0, abs=1e-12)
