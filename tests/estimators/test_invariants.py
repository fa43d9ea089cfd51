"""What no change of units, frame, triangulation or order may alter, on random polyhedra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_pose_stats import estimate, estimate_all, part_from_mesh, resting_poses
from ros_pose_stats.resting.equilibria import equilibria
from ros_pose_stats.tolerances import SAME_HEIGHT
from tests.bodies import (
    METHODS,
    moved,
    random_polyhedron,
    rotation,
    shuffled,
    size,
    starred,
    subdivided,
)
from tests.matching import matched, values

seeds = st.integers(0, 10_000)
polyhedra = st.builds(random_polyhedron, st.integers(4, 25), seeds)
tolerances = st.sampled_from([0.0, 0.005])


def untied(statistics):
    """No two heights are a tie, which `down` would break: the numbering cannot change."""
    return np.diff(np.sort(values(statistics.poses, "height"))).min(
        initial=np.inf) > 2.0 * SAME_HEIGHT * statistics.radius


def assert_same_answers(one, other, turn=None, scale=1.0, tolerance=0.0, within=1e-9):
    """All methods and the geometry of the poses agree, part by part.

    Lengths are compared relative to the radius. A split into two components of 1e-9 sr
    each, which one random body in some ten thousand has, would need a wider tolerance: their
    areas are differences of larger ones, good to 1e-16 sr.
    """
    for here, there in zip(estimate_all(one, cluster_tolerance=tolerance),
                           estimate_all(other, cluster_tolerance=tolerance), strict=True):
        assert here.method == there.method
        assert there.radius == pytest.approx(here.radius * scale, rel=within)
        partners = matched(here.poses, there.poses, turn)
        for name in ("probability", "margin", "spread"):
            assert values(partners, name) == pytest.approx(values(here.poses, name), abs=within)
        for name in ("height", "top", "barrier"):
            assert values(partners, name) == pytest.approx(
                values(here.poses, name) * scale, rel=within, abs=within * there.radius)
        if untied(here):
            assert values(partners, "index").tolist() == values(here.poses, "index").tolist()
        assert values(partners, "group").tolist() == values(here.poses, "group").tolist()


class TestTheSameBody:
    @pytest.mark.long
    @given(polyhedra, st.floats(-9.0, 9.0), tolerances)
    def test_in_other_units(self, surface, exponent, tolerance):
        scale = 10.0**exponent
        assert_same_answers(part_from_mesh(*surface), part_from_mesh(*moved(surface, scale=scale)),
                            scale=scale, tolerance=tolerance)

    @given(polyhedra, seeds, tolerances)
    def test_turned(self, surface, seed, tolerance):
        turn = rotation(seed)
        assert_same_answers(part_from_mesh(*surface), part_from_mesh(*moved(surface, turn)),
                            turn, tolerance=tolerance)

    @pytest.mark.long
    @given(polyhedra, seeds, st.floats(0.0, 3.0))
    def test_far_from_its_origin(self, surface, seed, exponent):
        # Coordinates up to 1000 sizes off are rounded to 1e-13 of the size before anything is
        # computed, and a sliver of a face turns by that over its width.
        way = rotation(seed)[0] * 10.0**exponent * size(surface)
        assert_same_answers(part_from_mesh(*surface), part_from_mesh(*moved(surface, offset=way)))

    @given(polyhedra, seeds)
    def test_with_points_in_other_orders(self, surface, seed):
        one, other = part_from_mesh(*surface), part_from_mesh(*shuffled(surface, seed))
        assert_same_answers(one, other, within=1e-10)

    @given(polyhedra, seeds)
    def test_wound_inward(self, surface, seed):
        vertices, triangles = surface
        assert_same_answers(part_from_mesh(*surface),
                            part_from_mesh(vertices, triangles[:, ::-1]), within=1e-10)

    @pytest.mark.long
    @given(polyhedra, seeds)
    def test_with_finer_triangles(self, surface, seed):
        part = part_from_mesh(*surface)
        for fine in (subdivided(surface), starred(surface, seed),
                     subdivided(starred(surface, seed))):
            assert_same_answers(part, part_from_mesh(*fine))

    @pytest.mark.long
    @given(polyhedra, seeds)
    def test_with_a_pocket_inside(self, surface, seed):
        # Points inside the hull change the mass properties only, and those are given here.
        part = part_from_mesh(*surface)
        vertices, triangles = surface
        inner = 0.3 * (vertices - part.center_of_mass) + part.center_of_mass
        hollow = part_from_mesh(np.vstack((vertices, inner)),
                                np.vstack((triangles, triangles[:, ::-1] + len(vertices))),
                                part.center_of_mass, part.mass, part.inertia)
        assert_same_answers(part, hollow)

    @pytest.mark.long
    @given(polyhedra, st.floats(-6.0, 6.0))
    def test_of_another_density(self, surface, exponent):
        assert_same_answers(part_from_mesh(*surface),
                            part_from_mesh(*surface, mass=10.0**exponent), within=1e-13)

    @given(polyhedra, seeds)
    def test_after_everything_at_once(self, surface, seed):
        turn = rotation(seed)
        changed = moved(subdivided(surface), turn, (30.0, -20.0, 5.0), 25.4)
        assert_same_answers(part_from_mesh(*surface),
                            part_from_mesh(*shuffled(changed, seed)), turn, 25.4)


@given(polyhedra, seeds)
def test_rounding_of_vertices_hardly_moves_the_energy_estimates(surface, seed):
    noise = np.random.default_rng(seed).uniform(-1e-12, 1e-12, surface[0].shape) * size(surface)
    parts = [part_from_mesh(vertices, surface[1]) for vertices in (surface[0], surface[0] + noise)]
    for method in ("meae", "eae"):
        here, there = (estimate(part, method, cluster_tolerance=0.0) for part in parts)
        partners = matched(here.poses, there.poses)
        assert np.abs(values(partners, "probability")
                      - values(here.poses, "probability")).max() < 1e-9


class TestEveryAnswer:
    @given(polyhedra, tolerances)
    def test_is_a_distribution(self, surface, tolerance):
        for found in estimate_all(part_from_mesh(*surface), cluster_tolerance=tolerance):
            probability = values(found.poses, "probability")
            assert probability.min() >= 0.0
            assert probability.sum() == pytest.approx(1.0, abs=1e-12)
            assert np.all(np.diff(probability) <= 1e-12)

    @given(polyhedra, tolerances)
    def test_lists_the_same_poses_for_every_method(self, surface, tolerance):
        first, *others = estimate_all(part_from_mesh(*surface), cluster_tolerance=tolerance)
        known = {pose.index: pose for pose in first.poses}
        assert sorted(known) == list(range(len(known)))
        for found in others:
            assert sorted(pose.index for pose in found.poses) == sorted(known)
            for pose in found.poses:
                assert pose.down is known[pose.index].down
                assert pose.members == known[pose.index].members

    @given(polyhedra, tolerances)
    def test_has_sound_geometry(self, surface, tolerance):
        found = estimate(part_from_mesh(*surface), "meae", cluster_tolerance=tolerance)
        heights = [pose.height for pose in sorted(found.poses, key=lambda pose: pose.index)]
        assert np.diff(heights).min(initial=0.0) > -1e-6 * found.radius
        for pose in found.poses:
            assert np.linalg.norm(pose.down) == pytest.approx(1.0, abs=1e-14)
            assert 0.0 < pose.height < found.radius
            assert pose.height < pose.top <= pose.height + found.radius * (1.0 + 1e-12)
            assert 0.0 < pose.margin <= np.pi / 2.0
            assert pose.barrier > 0.0
            assert pose.barrier < found.radius or len(found.poses) == 1


class TestEquilibria:
    @given(polyhedra)
    def test_poincare_hopf(self, surface):
        assert equilibria(part_from_mesh(*surface), 0).poincare_hopf == 2

    @given(polyhedra, seeds)
    def test_poincare_hopf_with_the_centre_of_mass_elsewhere(self, surface, seed):
        weights = np.random.default_rng(seed).dirichlet(np.ones(len(surface[0])))
        part = part_from_mesh(*surface, center_of_mass=weights @ surface[0])
        assert equilibria(part, 0).poincare_hopf == 2

    @given(polyhedra)
    def test_without_clusters_every_stable_face_is_a_pose(self, surface):
        part = part_from_mesh(*surface)
        found = equilibria(part, 0)
        poses = resting_poses(part, 0.0).poses
        assert [pose.members for pose in poses] == [(i,) for i in range(len(found.faces))]
        assert values(poses, "height") == pytest.approx(
            found.heights * found.body.radius, rel=1e-15)
        for pose, face in zip(poses, found.faces, strict=True):
            assert np.array_equal(pose.down, found.body.arrays.normal[face])

    @given(polyhedra)
    def test_stable_is_where_the_foot_is_inside(self, surface):
        # By section 2.B: r at the face's normal is the distance of its plane.
        part = part_from_mesh(*surface)
        found = equilibria(part, 0)
        arrays = found.body.arrays
        inside = found.body.r(arrays.normal) > arrays.distance * (1.0 - 1e-12)
        assert sorted(found.faces) == np.flatnonzero(inside).tolist()


@settings(max_examples=20)
@given(polyhedra, seeds)
def test_where_the_part_lies_in_its_frame_does_not_change_the_digest_of_an_equal_part(
        surface, seed):
    # The digest is of what was received, nothing else.
    one, other = part_from_mesh(*surface), part_from_mesh(*surface)
    assert one.digest == other.digest
    assert part_from_mesh(*moved(surface, rotation(seed))).digest != one.digest


def test_all_were_compared():
    part = part_from_mesh(*random_polyhedron(8, 1))
    assert [found.method for found in estimate_all(part)] == list(METHODS)
