"""Poses that a proper rotation of the whole part carries into each other share a group."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ros_pose_stats import estimate, part_from_mesh, resting_poses, shapes
from ros_pose_stats.resting import symmetry
from ros_pose_stats.shapes import demo_parts
from tests.bodies import (
    REGULAR_SOLIDS,
    in_float32,
    moved,
    oblique_prism,
    random_polyhedron,
    rotation,
    shuffled,
    size,
    subdivided,
)
from tests.matching import downs, groups, values
from tests.matching import group_sizes as sizes

SYMMETRIC = {
    "tetrahedron": (REGULAR_SOLIDS["tetrahedron"], [4]),
    "cube": (REGULAR_SOLIDS["cube"], [6]),
    "icosahedron": (REGULAR_SOLIDS["icosahedron"], [20]),
    "box": (shapes.box(1.0, 2.0, 3.0), [2, 2, 2]),
    "box, almost a cube": (shapes.box(1.0, 1.0, 1.001), [2, 4]),
    "hexagonal prism": (shapes.prism(6, 10.0, 24.0), [2, 6]),
    "pyramid": (shapes.hull_mesh(np.array(((1.0, 1.0, 0.0), (-1.0, 1.0, 0.0), (-1.0, -1.0, 0.0),
                                           (1.0, -1.0, 0.0), (0.0, 0.0, 1.5)))), [1, 4]),
    # Only the half turn about y is left; the two upright walls are mirror images.
    "leaning prism": (oblique_prism(0.5, 2.0), [1, 1, 2, 2]),
    "cylinder by facets": (shapes.cylinder(24, 1.0, 2.0), [2, 24]),
}


@pytest.mark.parametrize(("surface", "expected"), SYMMETRIC.values(), ids=SYMMETRIC)
class TestConvexBodies:
    def test_groups(self, surface, expected):
        assert sizes(surface) == expected

    def test_in_any_frame_unit_and_triangulation(self, surface, expected):
        for seed in range(3):
            changed = moved(subdivided(surface), rotation(seed), (3.0, -2.0, 1.0), 0.0254)
            assert sizes(shuffled(changed, seed)) == expected

    def test_in_float32_two_sizes_off_the_origin(self, surface, expected):
        for seed in range(3):
            way = rotation(seed + 20)[0] * 2.0 * size(surface)
            assert sizes(in_float32(moved(surface, rotation(seed), way))) == expected

    def test_equal_groups_have_equal_probabilities(self, surface, expected):
        part = part_from_mesh(*surface)
        for method in ("area", "csae", "qse", "pqse", "eae", "meae", "combined"):
            poses = estimate(part, method, cluster_tolerance=0.0, round_sides=0).poses
            for group in range(len(expected)):
                own = [pose.probability for pose in poses if pose.group == group]
                assert np.ptp(own) < 1e-12


def test_the_pairs_of_a_box_are_opposite_faces():
    for (first, second) in groups(part_from_mesh(*shapes.box(1.0, 2.0, 3.0))):
        assert np.array(first) == pytest.approx(-np.array(second))


def test_groups_are_numbered_by_their_first_pose():
    poses = resting_poses(part_from_mesh(*shapes.box(1.0, 2.0, 3.0)), 0.0).poses
    assert values(poses, "group").tolist() == [0, 0, 1, 1, 2, 2]


def test_facets_of_a_cylinder_are_one_pose_and_its_ends_one_group():
    assert sizes(shapes.cylinder(64, 9.0, 22.0), 0.005) == [1, 2]


class TestDemoParts:
    @staticmethod
    def groups(name, tolerance=0.0):
        return groups(part_from_mesh(*demo_parts.DEMO_PARTS[name](), unit="mm"), tolerance)

    def test_bolt_has_six_equal_sides(self):
        found = self.groups("hex_bolt", 0.005)
        assert max(map(len, found)) == 6
        assert sum(map(len, found)) - 6 == len(found) - 1

    def test_clamp_has_no_symmetry(self):
        assert all(len(group) == 1 for group in self.groups("clamp"))

    def test_bracket_is_only_its_mirror_image(self):
        assert all(len(group) == 1 for group in self.groups("bracket"))

    @pytest.mark.parametrize("name", demo_parts.DEMO_PARTS)
    def test_turned_and_a_size_off_the_origin_in_float32(self, name):
        surface = demo_parts.DEMO_PARTS[name]()
        expected = sizes(surface, 0.005, unit="mm")
        for seed in range(3):
            way = rotation(seed + 9)[0] * size(surface)
            rough = in_float32(moved(surface, rotation(seed), way))
            assert sizes(rough, 0.005, unit="mm") == expected


def test_random_bodies_have_no_symmetry():
    for seed in range(10):
        part = part_from_mesh(*random_polyhedron(6 + 2 * seed, seed))
        assert all(len(group) == 1 for group in groups(part))


@pytest.mark.parametrize("order", [2, 3, 5])
def test_bodies_with_one_axis_have_exactly_its_turns(order):
    # Random points and their images under an n-fold turn: no other symmetry by chance.
    points = np.random.default_rng(order).standard_normal((7, 3))
    turns = Rotation.from_euler("z", 2.0 * np.pi * np.arange(order) / order)
    everywhere = np.concatenate([turn.apply(points) for turn in turns])
    part = part_from_mesh(*moved(shapes.hull_mesh(everywhere), rotation(order)))
    axis = rotation(order)[:, 2]
    for group in groups(part):
        along = np.array(group) @ axis
        if np.abs(along[0]) > 1.0 - 1e-4:
            assert len(group) == 1
        else:
            assert len(group) == order
            assert np.ptp(along) < 1e-4


def test_poses_of_a_group_are_carried_into_each_other():
    sides = 5
    part = part_from_mesh(*moved(shapes.prism(sides, 1.0, 1.7), rotation(4)))
    for group in groups(part):
        inner = np.array(group) @ np.array(group).T
        assert np.sort(inner, axis=1) == pytest.approx(np.sort(inner[:1]).repeat(len(group), 0),
                                                       abs=1e-4)
    assert len(downs(resting_poses(part, 0.0, round_sides=0).poses)) == sides + 2


@pytest.mark.parametrize("few_pairs", [0, 1, 10**6])
def test_how_many_pairs_are_looked_through_first_changes_nothing(few_pairs, monkeypatch):
    loaded = (0.02, 0.01, 0.0)
    before = [sizes(surface) for surface, _ in SYMMETRIC.values()]
    uneven = sizes(REGULAR_SOLIDS["dodecahedron"], center_of_mass=loaded)
    monkeypatch.setattr(symmetry, "FEW_PAIRS", few_pairs)
    assert [sizes(surface) for surface, _ in SYMMETRIC.values()] == before
    assert sizes(REGULAR_SOLIDS["dodecahedron"], center_of_mass=loaded) == uneven
