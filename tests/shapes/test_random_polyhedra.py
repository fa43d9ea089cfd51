"""The paper's random polyhedra against a second reading of the recipe, and against trimesh."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from ros_pose_stats.errors import RequestError
from ros_pose_stats.resting.poses import resting_poses
from ros_pose_stats.shapes.random_polyhedra import failures, normals, random_polyhedron, uniforms

SHIFTS = [(0.0, "inertia"), (1.0, "inertia"), (0.65, "second")]
SAMPLE = 400


def recipe(random, shift, moment):
    """A body by the recipe: vertices, stable faces and the shift's length; None to redraw."""
    points = random.standard_normal((3 + random.geometric(0.1), 3))
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", across, hull.equations[:, :3]) < 0.0
    corners[inward] = corners[inward][:, ::-1]
    volumes = np.linalg.det(corners) / 6.0
    centre = volumes @ corners.sum(axis=1) / 4.0 / volumes.sum()
    corners = corners - centre
    corners /= np.linalg.norm(corners, axis=2).max()
    volumes = np.linalg.det(corners) / 6.0
    sums = corners.sum(axis=1)
    outer = (np.einsum("tki,tkj->tij", corners, corners) + np.einsum("ti,tj->tij", sums, sums))
    second, axes = np.linalg.eigh(np.tensordot(volumes, outer, 1) / 20.0 / volumes.sum())
    square = second if moment == "second" else second.sum() - second
    moved = axes @ (shift * random.uniform(-1.0, 1.0, 3) * np.sqrt(square))
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    heights = np.einsum("ij,ij->i", normals, corners[:, 0] - moved)
    feet = moved + heights[:, None] * normals
    stable = np.all([np.einsum("ij,ij->i", np.cross(
        corners[:, (k + 1) % 3] - corners[:, k], feet - corners[:, k]), normals) > 0.0
        for k in range(3)], axis=0).sum()
    if heights.min() <= 0.0 or stable < 2:
        return None
    return len(hull.vertices), stable, np.linalg.norm(moved)


def same_mean(one, other):
    """Whether two samples' means agree within four standard errors."""
    error = np.sqrt(np.var(one) / len(one) + np.var(other) / len(other))
    return abs(np.mean(one) - np.mean(other)) <= 4.0 * error + 1e-12


@pytest.mark.parametrize(("shift", "moment"), SHIFTS)
class TestTheRecipe:
    @pytest.mark.long
    def test_vertices_stable_faces_shift_and_redraws_are_distributed_alike(self, shift, moment):
        random = np.random.default_rng(20)
        drawn = [recipe(random, shift, moment) for _ in range(3 * SAMPLE)]
        kept = np.array([one for one in drawn if one is not None])
        bodies = [random_polyhedron(11, number, shift, moment) for number in range(SAMPLE)]
        ours = np.array([(len(body.vertices), len(resting_poses(body.part(), 0.0).poses),
                          np.linalg.norm(body.center_of_mass)) for body in bodies])
        for column in range(3):
            assert same_mean(ours[:, column], kept[:, column])
            assert same_mean(ours[:, column] ** 2, kept[:, column] ** 2)
        # One body out of a try or not, in both samples.
        tries = np.concatenate([[0] * body.redraws + [1] for body in bodies])
        assert same_mean(tries, np.array([one is not None for one in drawn], dtype=float))

    def test_a_body_is_convex_of_radius_1_about_its_centroid(self, shift, moment):
        for number in range(30):
            body = random_polyhedron(5, number, shift, moment)
            mesh = trimesh.Trimesh(body.vertices, body.triangles, process=False)
            assert mesh.is_volume
            assert mesh.volume == pytest.approx(ConvexHull(body.vertices).volume)
            assert mesh.center_mass == pytest.approx(np.zeros(3), abs=1e-12)
            assert np.linalg.norm(body.vertices, axis=1).max() == pytest.approx(1.0, rel=1e-14)

    def test_the_inertia_stays_the_central_one(self, shift, moment):
        for number in range(30):
            body = random_polyhedron(5, number, shift, moment)
            part = body.part()
            mesh = trimesh.Trimesh(body.vertices, body.triangles, process=False)
            assert part.inertia / part.mass == pytest.approx(
                mesh.moment_inertia / mesh.volume, rel=1e-9, abs=1e-12)
            assert part.center_of_mass.tolist() == body.center_of_mass.tolist()

    def test_the_shift_keeps_within_its_box_and_reaches_its_sides(self, shift, moment):
        """The box is shift q_i along the principal axes, here as trimesh has them."""
        shares = []
        for number in range(60):
            body = random_polyhedron(6, number, shift, moment)
            mesh = trimesh.Trimesh(body.vertices, body.triangles, process=False)
            moments, axes = np.linalg.eigh(mesh.moment_inertia / mesh.volume)
            square = moments.sum() / 2.0 - moments if moment == "second" else moments
            shares.append(np.abs(body.center_of_mass @ axes) / np.sqrt(square))
        assert np.max(shares) <= shift * (1.0 + 1e-9)
        assert np.max(shares, axis=0) == pytest.approx(np.full(3, shift), rel=0.35)


class TestTheSeries:
    def test_a_body_depends_on_its_place_alone(self):
        whole = [random_polyhedron(3, number, 1.0) for number in range(4)]
        again = random_polyhedron(3, 2, 1.0)
        assert np.array_equal(again.vertices, whole[2].vertices)
        assert np.array_equal(again.center_of_mass, whole[2].center_of_mass)

    def test_places_seeds_and_redraws_are_different_bodies(self):
        first = [random_polyhedron(seed, number).vertices[0].tolist()
                 for seed in (0, 1, 2 ** 64 - 1) for number in (0, 1, 2 ** 32)]
        assert len({tuple(one) for one in first}) == 9
        assert next(uniforms(0, 0, 0)) != next(uniforms(0, 0, 1))

    def test_the_numbers_are_distributed_as_they_should(self):
        numbers = uniforms(1, 2, 3)
        extra = np.array([failures(numbers, 0.1) for _ in range(4000)])
        assert abs(extra.mean() - 9.0) < 4.0 * np.sqrt(90.0 / 4000)
        assert abs((extra == 0).mean() - 0.1) < 4.0 * np.sqrt(0.09 / 4000)
        values = normals(numbers, 4000)
        assert abs(values.mean()) < 4.0 / np.sqrt(4000)
        assert abs(values.var() - 1.0) < 4.0 * np.sqrt(2.0 / 4000)
        assert abs((values ** 4).mean() - 3.0) < 4.0 * np.sqrt(96.0 / 4000)


class TestRefusals:
    @pytest.mark.parametrize("shift", [-0.1, float("nan"), float("inf"), True, "1", None])
    def test_shifts(self, shift):
        with pytest.raises(RequestError, match="shift scale"):
            random_polyhedron(0, 0, shift)

    @pytest.mark.parametrize("value", [-1, 2 ** 64, 1.5, True, None])
    def test_seeds_and_numbers(self, value):
        with pytest.raises(RequestError, match="a seed"):
            random_polyhedron(value, 0)
        with pytest.raises(RequestError, match="a number"):
            random_polyhedron(0, value)

    @given(st.text())
    def test_moments(self, moment):
        if moment not in ("inertia", "second"):
            with pytest.raises(RequestError, match="shift moment"):
                random_polyhedron(0, 0, 1.0, moment)
