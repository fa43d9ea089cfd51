"""Poses that a proper rotation of the whole part carries into each other share a group."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold, Mesh64
from scipy.spatial.transform import Rotation

from ros_pose_stats import estimate, part_from_mesh, resting_poses
from ros_pose_stats.geometry import shapes
from ros_pose_stats.geometry.shapes import registry
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
from tests.matching import downs, values


def groups(part, tolerance=0.0):
    """Poses by group, as sorted lists of rounded directions."""
    found = {}
    for pose in resting_poses(part, tolerance).poses:
        found.setdefault(pose.group, []).append(tuple(np.round(pose.down, 5) + 0.0))
    return sorted(sorted(directions) for directions in found.values())


def sizes(surface, tolerance=0.0, **properties):
    """Numbers of poses in each group."""
    return sorted(map(len, groups(part_from_mesh(*surface, **properties), tolerance)))


def cut(surface, *tools):
    """A surface with pockets."""
    vertices, triangles = surface
    solid = Manifold(Mesh64(np.ascontiguousarray(vertices),
                            np.ascontiguousarray(triangles.astype(np.uint64))))
    for tool in tools:
        solid -= tool
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties)[:, :3], np.array(mesh.tri_verts).astype(np.int64)


def drill(axis, place, radius, depth, half_size, sides=24):
    """A blind hole from the face at +half_size along an axis."""
    tool = Manifold.cylinder(2.0 * depth, radius, radius, sides, True)
    turn = {"x": (0.0, 90.0, 0.0), "y": (90.0, 0.0, 0.0), "z": (0.0, 0.0, 0.0)}[axis]
    position = np.zeros(3)
    others = [k for k in range(3) if k != "xyz".index(axis)]
    position[others] = place
    position["xyz".index(axis)] = half_size
    return tool.rotate(turn).translate(position)


SYMMETRIC = {
    "tetrahedron": (REGULAR_SOLIDS["tetrahedron"], [4]),
    "cube": (REGULAR_SOLIDS["cube"], [6]),
    "octahedron": (REGULAR_SOLIDS["octahedron"], [8]),
    "dodecahedron": (REGULAR_SOLIDS["dodecahedron"], [12]),
    "icosahedron": (REGULAR_SOLIDS["icosahedron"], [20]),
    "box": (shapes.box(1.0, 2.0, 3.0), [2, 2, 2]),
    "box, almost a cube": (shapes.box(1.0, 1.0, 1.001), [2, 4]),
    "square prism": (shapes.box(1.0, 1.0, 1.4), [2, 4]),
    "triangular prism": (shapes.prism(3, 1.0, 1.5), [2, 3]),
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

    @pytest.mark.parametrize("seed", range(4))
    def test_in_any_frame_unit_and_triangulation(self, surface, expected, seed):
        changed = moved(subdivided(surface), rotation(seed), (3.0, -2.0, 1.0), 0.0254)
        assert sizes(shuffled(changed, seed)) == expected

    @pytest.mark.parametrize("seed", range(4))
    def test_in_float32_two_sizes_off_the_origin(self, surface, expected, seed):
        way = rotation(seed + 20)[0] * 2.0 * size(surface)
        assert sizes(in_float32(moved(surface, rotation(seed), way))) == expected

    def test_equal_groups_have_equal_probabilities(self, surface, expected):
        part = part_from_mesh(*surface)
        for method in ("area", "csae", "qse", "pqse", "eae", "meae", "combined"):
            poses = estimate(part, method, cluster_tolerance=0.0).poses
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
        return groups(part_from_mesh(*registry.DEMO_PARTS[name](), unit="mm"), tolerance)

    def test_bolt_has_six_equal_sides(self):
        found = self.groups("hex_bolt", 0.005)
        assert max(map(len, found)) == 6
        assert sum(map(len, found)) - 6 == len(found) - 1

    def test_clamp_has_no_symmetry(self):
        assert all(len(group) == 1 for group in self.groups("clamp"))

    def test_bracket_is_only_its_mirror_image(self):
        assert all(len(group) == 1 for group in self.groups("bracket"))


    @pytest.mark.parametrize("name", registry.DEMO_PARTS)
    def test_turned_and_a_size_off_the_origin_in_float32(self, name):
        surface = registry.DEMO_PARTS[name]()
        expected = sizes(surface, 0.005, unit="mm")
        for seed in range(3):
            way = rotation(seed + 9)[0] * size(surface)
            rough = in_float32(moved(surface, rotation(seed), way))
            assert sizes(rough, 0.005, unit="mm") == expected


class TestPockets:
    """The hull is a box or a cube; the pocket decides."""

    def test_a_hole_in_one_face_of_a_cube_leaves_turns_about_it(self):
        # The hull's six faces, but the part turns into itself only about the hole: four walls
        # around, the face with the hole and the one opposite.
        part = cut(shapes.box(2.0, 2.0, 2.0), drill("z", (0.0, 0.0), 0.4, 1.0, 1.0))
        assert sizes(part) == [1, 1, 4]

    def test_a_shallow_small_hole_is_seen(self):
        part = cut(shapes.box(2.0, 2.0, 2.0), drill("z", (0.0, 0.0), 0.05, 0.02, 1.0))
        assert sizes(part) == [1, 1, 4]

    def test_a_hole_off_the_middle_leaves_nothing(self):
        part = cut(shapes.box(2.0, 2.0, 2.0), drill("z", (0.3, 0.1), 0.2, 1.0, 1.0))
        assert sizes(part) == [1] * 6

    def test_a_pocket_that_leaves_the_mass_properties_symmetric(self):
        # The centre of mass is given back to the middle and the inertia made round: only the
        # surface itself shows the hole.
        part = cut(shapes.box(2.0, 2.0, 2.0), drill("z", (0.0, 0.0), 0.4, 1.0, 1.0))
        found = sizes(part, center_of_mass=(0.0, 0.0, 0.0), mass=1.0, inertia=np.eye(3) * 0.6)
        assert found == [1, 1, 4]

    def test_holes_in_opposite_faces_restore_the_half_turns(self):
        part = cut(shapes.box(2.0, 2.0, 3.0),
                   drill("z", (0.0, 0.0), 0.4, 0.8, 1.5),
                   drill("z", (0.0, 0.0), 0.4, 0.8, -1.5))
        assert sizes(part) == [2, 4]

    def test_a_screw_pattern_of_holes_keeps_its_turns_but_no_reflection(self):
        # Four holes, each off the middle of its side in the same sense around z.
        tools = [drill("x", (0.3, 0.2), 0.15, 0.4, 1.0).rotate((0.0, 0.0, 90.0 * k))
                 for k in range(4)]
        assert sizes(cut(shapes.box(2.0, 2.0, 2.0), *tools)) == [1, 1, 4]

    def test_mirror_images_are_not_turns(self):
        # A wedge-like part with one mirror plane: the two slanted sides are images.
        points = np.array(((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (1.0, 1.5, 0.0), (1.0, -1.5, 0.0),
                           (1.3, 0.0, 2.0)))
        part = part_from_mesh(*shapes.hull_mesh(points))
        found = resting_poses(part, 0.0).poses
        heights = np.round(values(found, "height"), 9)
        assert len(set(heights)) < len(heights)
        assert all(len(group) == 1 for group in groups(part))

    def test_a_chiral_pair_of_holes(self):
        # Two holes that a half turn about z exchanges, and two that only a mirror would.
        half_turn = cut(shapes.box(2.0, 3.0, 4.0),
                        drill("x", (0.5, 0.7), 0.2, 0.4, 1.0),
                        drill("x", (-0.5, 0.7), 0.2, 0.4, -1.0))
        mirror = cut(shapes.box(2.0, 3.0, 4.0),
                     drill("x", (0.5, 0.7), 0.2, 0.4, 1.0),
                     drill("x", (0.5, 0.7), 0.2, 0.4, -1.0))
        assert sizes(half_turn) == [1, 1, 2, 2]
        assert sizes(mirror) == [1] * 6


class TestMassProperties:
    box = shapes.box(2.0, 2.0, 3.0)

    def test_uniform(self):
        assert sizes(self.box) == [2, 4]

    def test_a_shifted_centre_of_mass_separates(self):
        assert sizes(self.box, center_of_mass=(0.0, 0.0, 0.1)) == [1, 1, 4]
        assert sizes(self.box, center_of_mass=(0.1, 0.0, 0.0)) == [1, 1, 2, 2]
        assert sizes(self.box, center_of_mass=(0.1, 0.05, 0.02)) == [1] * 6

    def test_an_inertia_of_another_symmetry_separates(self):
        assert sizes(self.box, mass=1.0, inertia=np.diag((1.0, 1.0, 0.7))) == [2, 4]
        assert sizes(self.box, mass=1.0, inertia=np.diag((1.0, 1.2, 0.9))) == [2, 2, 2]

    def test_products_of_inertia_leave_one_half_turn(self):
        tensor = np.diag((1.0, 1.2, 0.9))
        tensor[0, 1] = tensor[1, 0] = 0.05
        found = sizes(shapes.box(2.0, 2.5, 3.0), mass=1.0, inertia=tensor)
        # About z, x goes to -x and y to -y: those pairs are kept.
        assert found == [1, 1, 2, 2]

    def test_skew_products_leave_nothing(self):
        tensor = np.diag((1.0, 1.2, 0.9))
        tensor[0, 1] = tensor[1, 0] = 0.05
        tensor[1, 2] = tensor[2, 1] = 0.03
        assert sizes(shapes.box(2.0, 2.5, 3.0), mass=1.0, inertia=tensor) == [1] * 6


@pytest.mark.parametrize("seed", range(10))
def test_random_bodies_have_no_symmetry(seed):
    part = part_from_mesh(*random_polyhedron(6 + 2 * seed, seed))
    assert all(len(group) == 1 for group in groups(part))


@pytest.mark.parametrize("order", [2, 3, 5])
@pytest.mark.parametrize("seed", range(4))
def test_bodies_with_one_axis_have_exactly_its_turns(order, seed):
    # Random points and their images under an n-fold turn: no other symmetry by chance.
    points = np.random.default_rng(seed).standard_normal((7, 3))
    turns = Rotation.from_euler("z", 2.0 * np.pi * np.arange(order) / order)
    everywhere = np.concatenate([turn.apply(points) for turn in turns])
    part = part_from_mesh(*moved(shapes.hull_mesh(everywhere), rotation(seed)))
    axis = rotation(seed)[:, 2]
    for group in groups(part):
        along = np.array(group) @ axis
        if np.abs(along[0]) > 1.0 - 1e-4:
            assert len(group) == 1
        else:
            assert len(group) == order
            assert np.ptp(along) < 1e-4


@pytest.mark.parametrize("sides", [5, 8])
def test_poses_of_a_group_are_carried_into_each_other(sides):
    part = part_from_mesh(*moved(shapes.prism(sides, 1.0, 1.7), rotation(4)))
    for group in groups(part):
        inner = np.array(group) @ np.array(group).T
        assert np.sort(inner, axis=1) == pytest.approx(np.sort(inner[:1]).repeat(len(group), 0),
                                                       abs=1e-4)
    assert len(downs(resting_poses(part, 0.0).poses)) == sides + 2
