"""Solid angles below a level of r and of R: limits, monotony, closed forms and the grid."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats.resting.convex_body import convex_body
from ros_pose_stats.resting.equilibria import equilibria
from tests.bodies import convex_parts
from tests.reference.sphere_grid import Shape, areas_below
from tests.volume import few_quick

PARTS = convex_parts()
every_part = pytest.mark.parametrize("part", PARTS.values(), ids=PARTS)


@every_part
class TestAreasBelow:
    def test_from_nothing_to_everything(self, part):
        body = convex_body(part, 0)
        lowest = body.arrays.distance.min()
        for angles in (body.angles_below_r, body.angles_below_R):
            assert np.abs(angles(lowest)).max() == 0.0
            assert angles(1.0).sum() == pytest.approx(4.0 * np.pi, rel=1e-12)
        assert body.angles_below_r(1.0) == pytest.approx(body.arrays.angle, abs=1e-10)

    def test_rising_with_the_level(self, part):
        body = convex_body(part, 0)
        levels = np.linspace(body.arrays.distance.min(), 1.0, 400)
        on_faces = np.array([body.angles_below_r(level) for level in levels])
        assert np.diff(on_faces, axis=0).min() > -1e-12
        total = np.array([body.angles_below_R(level).sum() for level in levels])
        assert np.diff(total).min() > -1e-12
        # r <= R: the set below a level of R lies inside that of r.
        assert np.all(total <= on_faces.sum(axis=1) + 1e-12)

    def test_continuous_in_the_level(self, part):
        # On each face for r; in sum for R, whose shares pass from face to face at once.
        body = convex_body(part, 0)
        arrays = body.arrays
        for mark in np.concatenate((arrays.distance, arrays.reach, arrays.radius)):
            below, above = mark - 1e-11, mark + 1e-11
            step = body.angles_below_r(above) - body.angles_below_r(below)
            flow = body.angles_below_R(above).sum() - body.angles_below_R(below).sum()
            # The steepest slope is that of a cap, 2 pi/d, on as many as twenty faces at once.
            assert np.abs(step).max() < 2e-10 / arrays.distance.min()
            assert abs(flow) < 4e-9 / arrays.distance.min()

    def test_discs_that_fit_into_a_face(self, part):
        body = convex_body(part, 0)
        arrays = body.arrays
        for face in equilibria(part, 0).faces:
            sides = slice(arrays.face_start[face], arrays.face_start[face + 1])
            d, rim = arrays.distance[face], arrays.reach[sides].min()
            for level in np.linspace(d, rim, 5):
                assert body.angles_below_r(level)[face] == pytest.approx(
                    2.0 * np.pi * (level - d) / level, rel=1e-9, abs=1e-14)


# The needle's and the clamp's creases are closer together than the grid's spacing.
@pytest.mark.parametrize("name", few_quick(
    ["box, shifted centre", "leaning prism", "random 6", "cube", "prism", "random 0"], 2))
def test_areas_against_the_grid(name):
    body = convex_body(PARTS[name], 0)
    shape = Shape(body.points, np.zeros(3))
    plane = (shape.normals @ body.arrays.normal.T).argmax(axis=1)
    assert sorted(plane) == list(range(body.faces))
    lowest = body.arrays.distance.min()
    levels = lowest + np.array((0.05, 0.2, 0.4, 0.6, 0.8, 0.95)) * (1.0 - lowest)
    for level, on_planes in zip(levels, areas_below(shape, "r", levels), strict=True):
        assert body.angles_below_r(level)[plane] == pytest.approx(on_planes, abs=1e-3)
    for level, at_vertices in zip(levels, areas_below(shape, "R", levels), strict=True):
        assert body.angles_below_R(level).sum() == pytest.approx(at_vertices.sum(), abs=2e-3)
