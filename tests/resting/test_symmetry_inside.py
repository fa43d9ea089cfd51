"""Symmetry that the hull has and the part has not: pockets and mass properties decide."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold, Mesh64

from ros_pose_stats import part_from_mesh, resting_poses, shapes
from tests.matching import group_sizes as sizes
from tests.matching import groups, values


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
