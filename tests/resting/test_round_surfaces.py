"""Runs: which circular chains of corners are found, and which of them are round."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from benchmarks.exports import parts as exports
from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.resting.convex_body import convex_body
from ros_pose_stats.resting.round_surfaces import rounding_of
from tests.bodies import moved, rotation

SIDES = 192


def runs_of(surface, **options):
    return convex_body(part_from_mesh(*surface, **options), SIDES).runs


class TestRound:
    @pytest.mark.parametrize("sides", [15, 16, 24, 64, 513, 2048])
    def test_two_rims_of_a_cylinder(self, sides):
        for run in runs_of(exports.in_float32(exports.cylinder(sides, 0.7, 0.3))):
            assert run.kind == "round" and run.full and run.sides == SIDES
            assert run.corners == sides
            assert abs(run.axis[2]) == pytest.approx(1.0, abs=1e-7)
            assert np.hypot(*run.center[:2]) < 1e-6
            assert run.radius == pytest.approx(0.5 / np.hypot(0.5, 0.35), rel=1e-6)

    def test_coaxial_rims_share_a_group(self):
        runs = runs_of(exports.shaft(32))
        assert len(runs) == 4 and {run.group for run in runs} == {0}

    def test_fourteen_sides_are_a_prism_and_fifteen_are_round(self):
        assert runs_of(exports.cylinder(14, 1.0)) == ()
        assert len(runs_of(exports.cylinder(15, 1.0))) == 2

    def test_arc_of_a_d_shaft_ends_at_its_flat(self):
        for run in runs_of(exports.in_float32(exports.d_shaft(48))):
            assert not run.full and run.corners == 41 and run.sides == SIDES

    def test_however_the_part_is_turned(self):
        surface = exports.ring(40, 0.1)
        for seed in range(3):
            runs = runs_of(moved(surface, rotation(seed), (3.0, -2.0, 1.0)))
            assert [run.corners for run in runs] == [40] * 4
            for run in runs:
                assert abs(run.axis @ rotation(seed)[:, 2]) == pytest.approx(1.0, abs=1e-9)


class TestToothed:
    @pytest.mark.parametrize("teeth", [15, 24, 60, 200])
    @pytest.mark.parametrize("tip", [0.0, 0.3, 0.5])
    def test_gears(self, teeth, tip):
        runs = runs_of(exports.in_float32(exports.gear(teeth, tip)))
        assert [run.kind for run in runs] == ["toothed"] * 2
        assert all(run.full and run.sides == 0 for run in runs)

    def test_chamfered_gear(self):
        runs = runs_of(exports.in_float32(exports.gear(30, 0.5, chamfer=0.03)))
        assert [run.kind for run in runs] == ["toothed"] * 4

    def test_few_pointed_teeth_are_no_circle(self):
        assert runs_of(exports.gear(12, 0.0)) == ()

    def test_open_mesh_of_a_gear(self):
        vertices, triangles = exports.gear(24, 0.5)
        runs = runs_of((vertices, triangles[1:]))
        assert [run.kind for run in runs] == ["toothed"] * 2

    def test_gap_that_the_mesh_divides_is_none(self):
        """Facets divided along the rims are surface as well."""
        vertices, triangles = trimesh.remesh.subdivide(*exports.cylinder(24, 1.0))
        assert [run.kind for run in runs_of((vertices, triangles))] == ["round"] * 2


class TestNone:
    def test_random_polyhedra(self):
        for seed in range(300):
            points = np.random.default_rng(seed).standard_normal((20 + seed, 3))
            part = part_from_mesh(*shapes.hull_mesh(points))
            body = convex_body(part, SIDES)
            assert body.runs == () and body.rounded == 0
            assert body.arrays is convex_body(part, 0).arrays
            assert (body.run_of_face == -1).all()

    def test_random_points_on_a_sphere(self):
        for seed in range(4):
            assert runs_of(shapes.hull_mesh(shapes.sphere_points(3000, seed))) == ()

    @pytest.mark.parametrize("divisions", [2, 3, 4])
    def test_circles_on_a_ball(self, divisions):
        ball = trimesh.creation.icosphere(subdivisions=divisions)
        assert runs_of((ball.vertices, ball.faces)) == ()

    @pytest.mark.parametrize("sides", [24, 64, 512])
    def test_ellipse(self, sides):
        assert runs_of(exports.in_float32(exports.ellipse(sides))) == ()


class TestRounding:
    def test_six_digits(self):
        vertices, triangles = exports.printed(exports.cylinder(64, 1.0, 0.1))
        part = part_from_mesh(vertices, triangles, unit="mm")
        assert rounding_of(part, part.surface_vertices) == pytest.approx(0.5e-9, rel=1e-6)

    @pytest.mark.parametrize("surface", [
        shapes.box(0.3, 0.2, 0.1), exports.cylinder(64, 1.0),
        exports.in_float32(exports.cylinder(64, 1.0))], ids=("box", "float64", "float32"))
    def test_all_digits(self, surface):
        part = part_from_mesh(*surface)
        assert rounding_of(part, part.surface_vertices) == part.rounding
