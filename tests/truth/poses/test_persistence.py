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

"""A pose is what a nudge leaves: stable faces gathered as the contract has it."""

from collections import Counter
from itertools import product

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import clamp_hull, oblique_prism, random_polyhedron
from lab.bodies.variants import moved, rotation
from ros_pose_stats import estimate, part_from_mesh, resting_poses
from ros_pose_stats.core.shapes import demo_parts
from tests.matching import downs, values
from tests.truth.reference.clustering import persistent_poses, stable_faces

STORED = {"tie": 3e-7, "distinct": 7e-7, "flat": 2e-6}
"""Of bodies whose coordinates are float32: off by 6e-8 of the size, planes by some
3e-7.
"""

BODIES = {
    "random": (random_polyhedron(20, 20), {}),
    "sphere points": (shapes.hull_mesh(shapes.sphere_points(60, 4)), {}),
    "ellipsoid": (
        shapes.hull_mesh(shapes.ellipsoid_points(150, 1, (3.0, 2.0, 1.5))),
        {},
    ),
    "cylinder": (shapes.cylinder(48, 1.0, 0.7), {}),
    "box": (shapes.box(1.0, 2.0, 3.0), {}),
    "icosahedron": (shapes.icosahedron(), {}),
    "clamp hull": (clamp_hull(), STORED),
    "bolt": (demo_parts.DEMO_PARTS["hex_bolt"](), STORED),
}
TOLERANCES = (1e-4, 0.0025, 0.01, 0.1, 0.4)
every_body = pytest.mark.parametrize("name", BODIES)


def poses_of(surface, tolerance=0.0025, **properties):
    return resting_poses(
        part_from_mesh(*surface, **properties), tolerance, round_sides=0
    ).poses


def assert_as_in_the_contract(part, tolerances=TOLERANCES, **rounding):
    """Members and ways out, the latter in radii."""
    single = resting_poses(part, 0.0, round_sides=0).poses
    faces = stable_faces(
        part.surface_vertices, part.center_of_mass, downs(single), **rounding
    )
    radius = single[0].height / faces.heights[0]
    for tolerance in tolerances:
        expected = persistent_poses(faces, tolerance)
        poses = {
            frozenset(pose.members): (pose.height + pose.barrier) / radius
            for pose in resting_poses(part, tolerance, round_sides=0).poses
        }
        assert poses.keys() == expected.keys()
        for members, level in expected.items():
            assert poses[members] == pytest.approx(
                level, rel=rounding.get("flat", 1e-10)
            )


@every_body
@pytest.mark.parametrize("turned", [False, True])
def test_members_and_ways_out(name, turned):
    surface, rounding = BODIES[name]
    for seed in range(4 if turned else 1):
        body = moved(surface, rotation(seed), (0.3, -0.2, 0.1)) if turned else surface
        assert_as_in_the_contract(part_from_mesh(*body), **rounding)


def mirrored_ridge():
    """A square bar whose upper edge is cut by three facets, the middle one lower than
    the others.

    The middle facet is left at 0.0024 of its height, equally far to either side. There
    the facets beside it are left at once, to two poses that a half turn of the bar
    carries into each other.
    """
    right = [(1.252, 8.0), (1.254, 4.0)]
    corners = [
        (radius, sign * angle) for sign in (1.0, -1.0) for radius, angle in right
    ]
    corners += [(np.sqrt(2.0), angle) for angle in (90.0, 180.0, 270.0)]
    radius, angle = np.array(corners).T
    outline = radius[:, None] * np.column_stack(
        (np.sin(np.radians(angle)), np.cos(np.radians(angle)))
    )
    return shapes.hull_mesh(
        np.array([(*p, z) for z, p in product((-2.0, 2.0), outline)])
    )


def test_a_shelf_between_two_equal_ways_out_goes_to_the_smaller_index():
    for seed in range(20):
        part = part_from_mesh(
            *moved(mirrored_ridge(), rotation(seed)), center_of_mass=(0.0, 0.0, 0.0)
        )
        assert_as_in_the_contract(part, (0.0025,))


def test_bars_with_mirror_planes_and_turns():
    """Facets near to a circle, in one of six symmetries, at tolerances where many are
    shelves.
    """
    random = np.random.default_rng(1)
    for trial in range(30):
        turns = random.integers(1, 4)
        facets = random.integers(2, 6)
        sector = random.uniform(0.0, 2.0 * np.pi / turns, facets)
        angle = np.concatenate([sector + 2.0 * np.pi * k / turns for k in range(turns)])
        radius = np.tile(random.uniform(0.95, 1.05, facets), turns)
        if random.random() < 0.7:
            angle = np.append(angle, -angle)
            radius = np.append(radius, radius)
        outline = radius[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
        bar = np.array([(*p, z) for z, p in product((-1.5, 1.5), outline)])
        if len(outline) < 4 or np.abs(bar.mean(axis=0)).max() > 0.2:
            continue
        part = part_from_mesh(*moved(shapes.hull_mesh(bar), rotation(trial)))
        assert_as_in_the_contract(part, (0.01, 0.03, 0.06, 0.1, 0.2))


@every_body
def test_the_lowest_member_stands_for_the_pose(name):
    part = part_from_mesh(*BODIES[name][0])
    single = resting_poses(part, 0.0, round_sides=0).poses
    for tolerance in TOLERANCES:
        for pose in resting_poses(part, tolerance, round_sides=0).poses:
            members = [single[i] for i in pose.members]
            (statistics,) = (
                member for member in members if np.array_equal(member.down, pose.down)
            )
            assert statistics.height <= min(member.height for member in members) * (
                1.0 + 2e-6
            )
            assert (pose.height, pose.top) == (statistics.height, statistics.top)
            for field in ("orientation", "position", "support_polygon", "outline"):
                assert np.array_equal(getattr(pose, field), getattr(statistics, field))


@every_body
def test_spread_is_the_widest_angle_of_members_that_are_low(name):
    part = part_from_mesh(*BODIES[name][0])
    single = resting_poses(part, 0.0, round_sides=0).poses
    for tolerance in TOLERANCES:
        for pose in resting_poses(part, tolerance, round_sides=0).poses:
            low = downs(
                [
                    single[i]
                    for i in pose.members
                    if single[i].height < (1.0 + tolerance) * pose.height
                    or np.array_equal(single[i].down, pose.down)
                ]
            )
            chord = np.linalg.norm(low[:, None] - low[None], axis=-1).max()
            # Near half a turn the angle is the root of what rounding leaves of the
            # chord.
            assert pose.spread == pytest.approx(
                2.0 * np.arcsin(min(chord / 2.0, 1.0)), abs=1e-7
            )


@pytest.mark.parametrize("method", ["area", "csae", "adre", "qse", "eae", "meae"])
def test_probabilities_add_up_over_members(method):
    for name in ("cylinder", "ellipsoid", "bolt"):
        part = part_from_mesh(*BODIES[name][0])
        single = {
            pose.index: pose.probability
            for pose in estimate(
                part, method, cluster_tolerance=0.0, round_sides=0
            ).poses
        }
        for tolerance in (0.0025, 0.1):
            sums = (
                Counter()
            )  # of a group: one of its poses may have what lies between them
            for pose in estimate(
                part, method, cluster_tolerance=tolerance, round_sides=0
            ).poses:
                sums[pose.group] += pose.probability - sum(
                    single[i] for i in pose.members
                )
            assert max(map(abs, sums.values())) < 1e-12


def test_the_nonlinear_rule_acts_on_the_sum():
    """Facet by facet Eq. 6 would give a curve the less the finer it is divided."""
    shares = []
    for sides in (48, 128, 256):
        part = part_from_mesh(*shapes.cylinder(sides, 1.0, 2.0))
        (side,) = (
            pose
            for pose in estimate(part, "nqse", round_sides=0).poses
            if len(pose.members) == sides
        )
        shares.append(side.probability)
    assert shares == pytest.approx([shares[-1]] * 3, abs=0.005)


def test_of_tied_members_the_largest_face_stands_for_the_pose():
    """All sides touch one inner circle, but they differ in width."""
    angles = np.cumsum(np.tile([0.08, 0.1, 0.13, 0.09], 20))
    angles *= 2.0 * np.pi / angles[-1]
    half = np.diff(np.append(angles, angles[0] + 2.0 * np.pi)) / 2.0
    corners = np.column_stack((np.cos(angles + half), np.sin(angles + half)))
    corners /= np.cos(half)[:, None]
    bar = np.array([(*p, z) for z, p in product((-1.5, 1.5), corners)])
    poses = poses_of(shapes.hull_mesh(bar), 0.01, center_of_mass=(0.0, 0.0, 0.0))
    (side,) = (pose for pose in poses if len(pose.members) > 1)
    widths = half + np.roll(half, 1)
    lying = np.argmin(np.abs(np.exp(1j * angles) - complex(*side.down[:2])))
    assert widths[lying] == pytest.approx(widths.max(), rel=1e-9)


class TestClosedForms:
    """A tolerance of 0.0025 is a tilt of 4 degrees: sqrt(1 + t^-2) < 1.0025 from t =
    14.1 on.
    """

    @pytest.mark.parametrize("sides", [45, 49, 200])
    def test_a_fine_cylinder_as_it_is_in_the_file(self, sides):
        poses = poses_of(shapes.cylinder(sides, 9.0, 22.0))
        assert sorted(len(pose.members) for pose in poses) == [1, 1, sides]
        (side,) = (pose for pose in poses if len(pose.members) == sides)
        apothem = 9.0 * np.cos(np.pi / sides)
        assert side.height == pytest.approx(apothem, rel=1e-12)
        assert side.margin == pytest.approx(np.arctan2(11.0, apothem), rel=1e-9)
        assert side.barrier == pytest.approx(
            np.hypot(apothem, 11.0) - apothem, rel=1e-9
        )
        assert side.spread == pytest.approx(np.pi * (1.0 - sides % 2 / sides), abs=1e-6)

    def test_a_ball_is_one_pose(self):
        (pose,) = poses_of(shapes.hull_mesh(shapes.sphere_points(3000, seed=3)), 0.02)
        assert pose.barrier == np.inf
        assert pose.spread > 3.0

    def test_shelves_change_neither_group_nor_margin_nor_spread(self):
        """From a thin plate's face the way out is over its edge, by 86 degrees."""
        poses = sorted(
            poses_of(shapes.box(1.0, 14.3, 14.3)), key=lambda pose: len(pose.members)
        )
        assert [len(pose.members) for pose in poses] == [1, 5]
        assert [pose.group for pose in poses] == [0, 0]
        assert [pose.spread for pose in poses] == [0.0, 0.0]
        assert values(poses, "margin") == pytest.approx(np.arctan2(14.3, 1.0), abs=1e-6)

    def test_a_shelf_goes_to_the_face_across_its_lower_saddle(self):
        """Oblique sides of an octagon are left at 1.057 to those of 0.95, else at
        1.082.
        """
        angles = np.radians(45.0) * np.arange(8)
        normals = np.column_stack((np.cos(angles), np.sin(angles)))
        distances = np.where(np.arange(8) % 4 == 2, 0.95, 1.0)
        corners = [
            np.linalg.solve(normals[[k, k - 1]], distances[[k, k - 1]])
            for k in range(8)
        ]
        bar = np.array([(*p, z) for z, p in product((-1.0, 1.0), corners)])
        poses = poses_of(shapes.hull_mesh(bar), 0.07)
        assert len(poses) == 6
        assert [len(pose.members) for pose in poses if abs(pose.down[1]) > 0.9] == [
            3,
            3,
        ]

    def test_a_shallow_pose_beside_a_deep_one_belongs_to_it(self):
        """Its saddle is 0.00002 radii above it and 0.4 above the other."""
        part = part_from_mesh(*oblique_prism(1.2, 2.0), center_of_mass=(0.99, 0.1, 0.5))
        single, merged = (
            resting_poses(part, tolerance, 0).poses for tolerance in (0.0, 0.0025)
        )
        (shallow,) = (pose for pose in single if pose.barrier < 1e-3)
        (deep,) = (pose for pose in merged if len(pose.members) > 1)
        assert len(merged) == len(single) - 1
        assert shallow.index in deep.members
        assert deep.barrier > 0.1

    def test_a_single_pose_has_an_infinite_barrier(self):
        part = part_from_mesh(
            *random_polyhedron(6, 1329), center_of_mass=(-1.18, 0.55, 0.92)
        )
        (pose,) = estimate(part, "meae", cluster_tolerance=0.0, round_sides=0).poses
        assert (pose.barrier, pose.probability, pose.spread) == (np.inf, 1.0, 0.0)
        assert 0.0 < pose.margin <= np.pi / 2.0
