"""The convex body: its faces, their solid angles, and the functions r and R."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.resting.convex_body import convex_body
from ros_pose_stats.resting.equilibria import equilibria
from tests.bodies import REGULAR_SOLIDS, convex_parts, fanned, moved, rotation, starred, subdivided

PARTS = convex_parts()
every_part = pytest.mark.parametrize("part", PARTS.values(), ids=PARTS)


def directions(count, seed=0):
    return shapes.sphere_points(count, seed)


@every_part
class TestFaces:
    def test_euler(self, part):
        body = convex_body(part, 0)
        corners = len(np.unique(body.arrays.corner))
        assert corners - len(body.edges[0]) + body.faces == 2

    def test_angles_cover_the_sphere(self, part):
        assert convex_body(part, 0).arrays.angle.sum() == pytest.approx(4.0 * np.pi, rel=1e-11)

    def test_areas_add_up_to_the_hulls(self, part):
        body = convex_body(part, 0)
        assert body.arrays.area.sum() == pytest.approx(ConvexHull(body.points).area, rel=1e-9)

    def test_corners_lie_on_their_planes_and_all_others_below(self, part):
        body = convex_body(part, 0)
        height = body.arrays.normal @ body.points.T - body.arrays.distance[:, None]
        assert height.max() < 2.0 * body.tolerance + 1e-12
        for face in range(body.faces):
            corners = body.polygon(face)
            off = corners @ body.arrays.normal[face] - body.arrays.distance[face]
            assert np.abs(off).max() < 2.0 * body.tolerance + 1e-12

    def test_corners_run_counter_clockwise(self, part):
        body = convex_body(part, 0)
        for face in range(body.faces):
            corners = body.polygon(face)
            along = np.roll(corners, -1, axis=0) - corners
            turn = np.cross(along, np.roll(along, -1, axis=0)) @ body.arrays.normal[face]
            assert turn.min() > 0.0

    def test_twins(self, part):
        body = convex_body(part, 0)
        arrays = body.arrays
        side = np.arange(len(arrays.twin))
        assert np.array_equal(arrays.twin[arrays.twin], side)
        assert np.all(arrays.face[arrays.twin] != arrays.face)

    def test_radius_is_the_farthest_vertex(self, part):
        body = convex_body(part, 0)
        offset = part.surface_vertices - part.center_of_mass
        assert body.radius == pytest.approx(np.linalg.norm(offset, axis=1).max(), rel=1e-14)
        assert np.linalg.norm(body.points, axis=1).max() == pytest.approx(1.0, rel=1e-14)

    def test_side_lengths(self, part):
        body = convex_body(part, 0)
        arrays = body.arrays
        for k in range(len(arrays.twin)):
            v, w = body.points[arrays.corner[k]], body.points[arrays.corner[arrays.twin[k]]]
            normal = arrays.normal[arrays.face[k]]
            along = (w - v) / np.linalg.norm(w - v)
            foot = v - (v @ along) * along
            below = arrays.distance[arrays.face[k]] * normal
            assert arrays.reach[k] == pytest.approx(np.linalg.norm(foot), abs=1e-12)
            assert arrays.start[k] == pytest.approx((foot - v) @ along, abs=1e-12)
            assert arrays.stop[k] == pytest.approx((w - foot) @ along, abs=1e-12)
            assert arrays.inset[k] == pytest.approx(
                (below - foot) @ np.cross(normal, along), abs=1e-6)


@every_part
class TestFunctions:
    def test_r_is_on_the_surface(self, part):
        body = convex_body(part, 0)
        u = directions(500)
        height = (body.r(u)[:, None] * u) @ body.arrays.normal.T - body.arrays.distance
        assert np.abs(height.max(axis=1)).max() < 1e-12

    def test_R_touches_from_outside(self, part):
        body = convex_body(part, 0)
        u = directions(500)
        gap = body.R(u)[:, None] - u @ body.points.T
        assert np.abs(gap.min(axis=1)).max() == 0.0

    def test_r_is_never_above_R(self, part):
        body = convex_body(part, 0)
        u = directions(5000)
        assert np.all(body.r(u) <= body.R(u) * (1.0 + 1e-12))

    def test_both_agree_at_equilibria_and_differ_elsewhere(self, part):
        body, found = convex_body(part, 0), equilibria(part, 0)
        arrays = body.arrays
        v = body.points[arrays.corner[found.saddles]]
        w = body.points[arrays.corner[arrays.twin[found.saddles]]]
        along = (w - v) / np.linalg.norm(w - v, axis=1)[:, None]
        feet = v - (v * along).sum(axis=1)[:, None] * along
        for points in (found.heights[:, None] * found.downs, feet, body.points[found.unstable]):
            level = np.linalg.norm(points, axis=1)
            u = points / level[:, None]
            assert body.r(u) == pytest.approx(level, rel=1e-9)
            assert body.R(u) == pytest.approx(level, rel=1e-9)
        u = directions(500)
        assert np.all(body.R(u) - body.r(u) > 0.0)

    def test_shapes_of_arguments(self, part):
        body = convex_body(part, 0)
        u = directions(6)
        for function in (body.r, body.R):
            assert function(u[0]).shape == ()
            assert function(u.reshape(2, 3, 3)).shape == (2, 3)
            assert np.array_equal(function(u.reshape(2, 3, 3)).ravel(), function(u))


def test_solid_angles_of_a_needle_keep_their_digits():
    for width in (0.1, 1e-3, 1e-5):
        body = convex_body(part_from_mesh(*shapes.box(1.0, width, 2.0 * width)), 0)
        a, b, d = 0.5, width, width / 2.0  # half sizes and distance of the widest face
        expected = 4.0 * np.arctan(a * b / (d * np.sqrt(a * a + b * b + d * d)))
        assert body.arrays.angle.max() == pytest.approx(expected, rel=1e-11)
        assert body.arrays.angle.sum() == pytest.approx(4.0 * np.pi, rel=1e-11)


class TestCoplanarTriangles:
    @pytest.mark.parametrize("change", [
        lambda s: subdivided(subdivided(s)), lambda s: starred(s, 3), lambda s: fanned(s, 1),
        lambda s: starred(fanned(s, 2), 4)])
    def test_any_triangulation_gives_the_same_faces(self, change):
        for name in ("tetrahedron", "cube", "dodecahedron"):
            surface = moved(REGULAR_SOLIDS[name], rotation(5), (2.0, 1.0, -3.0))
            plain, fine = (convex_body(part_from_mesh(*s), 0) for s in (surface, change(surface)))
            assert fine.faces == plain.faces
            assert len(fine.edges[0]) == len(plain.edges[0])
            assert np.sort(fine.arrays.angle) == pytest.approx(
                np.sort(plain.arrays.angle), rel=1e-12)

    def test_thin_plates_keep_two_sides(self):
        for thickness in (1e-2, 1e-4, 1e-5, 1e-6):
            body = convex_body(part_from_mesh(*shapes.box(1.0, 0.7, thickness)), 0)
            assert body.faces == 6

    def test_a_bulge_of_a_thousandth_is_no_plane(self):
        vertices, _ = shapes.box(1.0, 1.0, 1.0)
        raised = np.vstack((vertices, (0.0, 0.0, 0.501)))
        assert convex_body(part_from_mesh(*shapes.hull_mesh(raised)), 0).faces == 9


def test_the_body_is_built_once_and_cannot_be_written_to():
    part = part_from_mesh(*shapes.box(1.0, 1.0, 1.0))
    body = convex_body(part, 0)
    assert convex_body(part, 0) is body
    with pytest.raises(ValueError, match="read-only"):
        body.points[0, 0] = 1.0
