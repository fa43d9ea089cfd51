# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Poses that a proper rotation of the whole part carries into each other share a
group.
"""

import numpy as np
import pytest
from manifold3d import Manifold
from scipy.spatial.transform import Rotation

from lab.bodies import fine_parts, shapes
from lab.bodies.samples import REGULAR_SOLIDS, oblique_prism, random_polyhedron
from lab.bodies.variants import in_float32, moved, rotation, shuffled, size, subdivided
from ros_pose_stats import estimate, part_from_mesh, resting_poses
from ros_pose_stats.core.shapes import demo_parts
from tests.matching import group_sizes, values

PYRAMID = shapes.hull_mesh(
    np.array([(1, 1, 0), (-1, 1, 0), (-1, -1, 0), (1, -1, 0), (0, 0, 1.5)])
)
SYMMETRIC = {
    "tetrahedron": (REGULAR_SOLIDS["tetrahedron"], [4]),
    "cube": (REGULAR_SOLIDS["cube"], [6]),
    "icosahedron": (REGULAR_SOLIDS["icosahedron"], [20]),
    "box": (shapes.box(1.0, 2.0, 3.0), [2, 2, 2]),
    "box, almost a cube": (shapes.box(1.0, 1.0, 1.001), [2, 4]),
    "hexagonal prism": (shapes.prism(6, 10.0, 24.0), [2, 6]),
    "pyramid": (PYRAMID, [1, 4]),
    # Only the half turn about y is left; the two upright walls are mirror images.
    "leaning prism": (oblique_prism(0.5, 2.0), [1, 1, 2, 2]),
    "cylinder by facets": (shapes.cylinder(24, 1.0, 2.0), [2, 24]),
    "bolt": (demo_parts.hex_bolt(), [1, 1, 6]),
    "clamp": (demo_parts.DEMO_PARTS["clamp"](), [1] * 8),
    "bracket, its own mirror image": (demo_parts.DEMO_PARTS["bracket"](), [1] * 5),
}


@pytest.mark.parametrize(("surface", "expected"), SYMMETRIC.values(), ids=SYMMETRIC)
class TestBodies:
    def test_groups_however_the_mesh_is_given(self, surface, expected):
        assert group_sizes(surface) == expected
        for seed in range(3):
            changed = moved(
                subdivided(surface), rotation(seed), (3.0, -2.0, 1.0), 0.0254
            )
            assert group_sizes(shuffled(changed, seed)) == expected

    def test_in_float32_a_size_off_the_origin(self, surface, expected):
        for seed in range(3):
            shift = rotation(seed + 20)[0] * size(surface)
            assert (
                group_sizes(in_float32(moved(surface, rotation(seed), shift)))
                == expected
            )

    def test_members_of_a_group_have_one_probability_and_one_shape(
        self, surface, expected
    ):
        """Stored coordinates are 6e-8 off; a narrow face makes more of that."""
        part = part_from_mesh(*surface)
        for method in ("area", "csae", "qse", "pqse", "eae", "meae", "combined"):
            poses = estimate(part, method, cluster_tolerance=0.0, round_sides=0).poses
            for group in range(len(expected)):
                alike = [pose for pose in poses if pose.group == group]
                assert {pose.group_size for pose in alike} == {len(alike)}
                assert np.ptp(values(alike, "probability")) < 1e-6
                assert alike[0].group_probability == pytest.approx(
                    values(alike, "probability").sum(), rel=1e-12
                )
                for field in ("height", "top", "margin", "barrier"):
                    assert np.ptp(values(alike, field)) < 1e-5 * size(surface)


def test_groups_are_numbered_by_their_first_pose_and_pair_opposite_faces_of_a_box():
    poses = resting_poses(part_from_mesh(*shapes.box(1.0, 2.0, 3.0)), 0.0).poses
    assert values(poses, "group").tolist() == [0, 0, 1, 1, 2, 2]
    for pose, side in zip(poses[::2], poses[1::2], strict=True):
        assert pose.down == pytest.approx(-side.down, abs=1e-15)


@pytest.mark.parametrize("order", [2, 3, 5])
def test_bodies_with_one_axis_have_exactly_its_turns(order):
    """Random points and their images under an n-fold turn: no other symmetry by
    chance.
    """
    points = np.random.default_rng(order).standard_normal((7, 3))
    turns = Rotation.from_euler("z", 2.0 * np.pi * np.arange(order) / order)
    everywhere = np.concatenate([turn.apply(points) for turn in turns])
    turn = rotation(order)
    poses = resting_poses(
        part_from_mesh(*moved(shapes.hull_mesh(everywhere), turn)), 0.0
    ).poses
    for group in {pose.group for pose in poses}:
        along = np.array(
            [pose.down @ turn[:, 2] for pose in poses if pose.group == group]
        )
        on_axis = np.abs(along[0]) > 1.0 - 1e-9
        assert len(along) == (1 if on_axis else order)
        assert np.ptp(along) < 1e-9


def test_yaw_symmetry_is_the_order_of_the_turns_about_the_vertical():
    def orders(surface):
        return [
            pose.yaw_symmetry for pose in resting_poses(part_from_mesh(*surface)).poses
        ]

    assert orders(shapes.box(1.0, 2.0, 3.0)) == [2] * 6
    assert orders(shapes.box(1.0, 1.0, 1.0)) == [4] * 6
    assert sorted(orders(shapes.prism(6, 1.0, 1.0))) == [2] * 6 + [6] * 2
    for sides in (15, 64, 100, 192):  # whatever the body has, and however it is turned
        for turn in (np.eye(3), rotation(sides)):
            assert sorted(orders(moved(shapes.cylinder(sides, 1.0, 2.0), turn))) == [
                0,
                0,
                2,
            ]
    assert orders(random_polyhedron(20, 1)) == [1] * len(
        orders(random_polyhedron(20, 1))
    )


@pytest.mark.parametrize("holes", [8, 24])
def test_a_wheel_with_holes_is_not_alike_at_any_angle(holes):
    wheel = Manifold.cylinder(0.3, 1.0, 1.0, 96)
    for angle in 2.0 * np.pi * np.arange(holes) / holes:
        hole = Manifold.cylinder(1.0, 0.06, 0.06, 24).rotate(
            (0.0, 0.0, np.degrees(angle))
        )
        wheel -= hole.translate((0.7 * np.cos(angle), 0.7 * np.sin(angle), -0.3))
    poses = resting_poses(part_from_mesh(*fine_parts.surface(wheel))).poses
    assert sorted(pose.yaw_symmetry for pose in poses)[1:] == [holes, holes]


def with_flap(surface):
    """Four triangles without area along an edge, as they are left where edges were
    stitched.
    """
    vertices, triangles = surface
    a, b, _ = triangles[0]
    hinge = vertices[a] + np.array([[0.3], [0.6]]) * (vertices[b] - vertices[a])
    m = len(vertices)
    n = len(vertices) + 1
    return np.vstack((vertices, hinge)), np.vstack(
        (triangles, [(a, b, m), (b, a, n), (a, m, n), (m, b, n)])
    )


@pytest.mark.parametrize(
    "box",
    [with_flap(shapes.box(1.0, 2.0, 3.0)), subdivided(shapes.box(1.0, 0.7, 1e-6))],
    ids=["flap", "thin"],
)
def test_neither_triangles_without_area_nor_thinness_hides_a_symmetry(box):
    assert group_sizes(moved(box, rotation(2))) == [2, 2, 2]


def drilled(edges, holes):
    """A box with blind holes: axis, place, radius, depth, side (-1, 1) and a turn about
    z.
    """
    solid = Manifold.cube(edges, True)
    for axis, middle, radius, depth, side, degrees in holes:
        turn = {"x": (0.0, 90.0, 0.0), "y": (90.0, 0.0, 0.0), "z": (0.0, 0.0, 0.0)}[
            axis
        ]
        k = "xyz".index(axis)
        position = np.insert(np.array(middle), k, 0.5 * side * edges[k])
        hole = Manifold.cylinder(2.0 * depth, radius, radius, 24, True)
        solid -= hole.rotate(turn).translate(position).rotate((0.0, 0.0, degrees))
    return fine_parts.surface(solid)


CUBE = (2.0, 2.0, 2.0)
MIDDLE = (0.0, 0.0)
WIDE = ("z", MIDDLE, 0.4, 1.0, 1, 0)
POCKETS = {
    "a hole in one face leaves turns about it": (CUBE, [WIDE], [1, 1, 4]),
    "a shallow small hole": (CUBE, [("z", MIDDLE, 0.05, 0.02, 1, 0)], [1, 1, 4]),
    "a hole off the middle leaves nothing": (
        CUBE,
        [("z", (0.3, 0.1), 0.2, 1.0, 1, 0)],
        [1] * 6,
    ),
    "holes in opposite faces restore the half turns": (
        (2.0, 2.0, 3.0),
        [("z", MIDDLE, 0.4, 0.8, side, 0) for side in (1, -1)],
        [2, 4],
    ),
    "holes around like blades": (
        CUBE,
        [("x", (0.3, 0.2), 0.15, 0.4, 1, 90.0 * k) for k in range(4)],
        [1, 1, 4],
    ),
    "two holes that a half turn exchanges": (
        (2.0, 3.0, 4.0),
        [("x", (0.5 * side, 0.7), 0.2, 0.4, side, 0) for side in (1, -1)],
        [1, 1, 2, 2],
    ),
    "two holes that a mirror exchanges": (
        (2.0, 3.0, 4.0),
        [("x", (0.5, 0.7), 0.2, 0.4, side, 0) for side in (1, -1)],
        [1] * 6,
    ),
}


@pytest.mark.parametrize(("edges", "holes", "expected"), POCKETS.values(), ids=POCKETS)
def test_pockets_that_the_hull_does_not_show(edges, holes, expected):
    assert group_sizes(drilled(edges, holes)) == expected


def test_the_surface_decides_where_the_given_mass_properties_are_symmetric():
    assert group_sizes(
        drilled(CUBE, [WIDE]),
        center_of_mass=(0.0, 0.0, 0.0),
        mass=1.0,
        inertia=np.eye(3) * 0.6,
    ) == [1, 1, 4]


def test_mirror_images_are_not_turns():
    """A wedge with one mirror plane, whose slanted sides are images of each other."""
    wedge = shapes.hull_mesh(
        np.array(
            [(0, 0, 0), (4, 0, 0), (1, 1.5, 0), (1, -1.5, 0), (1.3, 0, 2)], dtype=float
        )
    )
    heights = values(resting_poses(part_from_mesh(*wedge), 0.0).poses, "height")
    assert np.diff(heights).min() < 1e-12
    assert set(group_sizes(wedge)) == {1}


SKEW = np.diag((1.0, 1.2, 0.9))
TWISTED = np.diag((1.0, 1.2, 0.9))
SKEW[[0, 1], [1, 0]] = TWISTED[[0, 1], [1, 0]] = 0.05
TWISTED[[1, 2], [2, 1]] = 0.03


@pytest.mark.parametrize(
    ("edges", "properties", "expected"),
    [
        ((2, 2, 3), {}, [2, 4]),
        ((2, 2, 3), {"center_of_mass": (0.0, 0.0, 0.1)}, [1, 1, 4]),
        ((2, 2, 3), {"center_of_mass": (0.1, 0.0, 0.0)}, [1, 1, 2, 2]),
        ((2, 2, 3), {"center_of_mass": (0.1, 0.05, 0.02)}, [1] * 6),
        ((2, 2, 3), {"mass": 1.0, "inertia": np.diag((1.0, 1.0, 0.7))}, [2, 4]),
        ((2, 2, 3), {"mass": 1.0, "inertia": np.diag((1.0, 1.2, 0.9))}, [2, 2, 2]),
        (
            (2, 2.5, 3),
            {"mass": 1.0, "inertia": SKEW},
            [1, 1, 2, 2],
        ),  # half a turn about z is left
        ((2, 2.5, 3), {"mass": 1.0, "inertia": TWISTED}, [1] * 6),
    ],
)
def test_mass_properties_decide(edges, properties, expected):
    assert group_sizes(shapes.box(*edges), **properties) == expected
