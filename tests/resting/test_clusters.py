"""Stable faces gathered into poses: facets of a curve become one, true poses stay apart."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, resting_poses, shapes
from ros_pose_stats.estimators.quasi_static import nonlinear
from ros_pose_stats.shapes import demo_parts
from tests.bodies import METHODS, clamp_hull, oblique_prism, random_polyhedron
from tests.matching import downs
from tests.reference.clustering import persistent_poses

DEMO = {name: make() for name, make in demo_parts.DEMO_PARTS.items()}


def poses_of(surface, tolerance=0.0025, **properties):
    return resting_poses(part_from_mesh(*surface, **properties), tolerance, round_sides=0).poses


def plate(slenderness):
    return shapes.box(1.0, slenderness, slenderness)


def flattened_octagon():
    """A prism 2 long over an octagon whose faces to -y and +y are 0.95 away, the others 1."""
    angles = np.radians(45.0) * np.arange(8)
    normals = np.column_stack((np.cos(angles), np.sin(angles)))
    distances = np.where(np.arange(8) % 4 == 2, 0.95, 1.0)
    corners = [np.linalg.solve(normals[[k, k - 1]], distances[[k, k - 1]]) for k in range(8)]
    return shapes.hull_mesh(np.array([(x, y, z) for x, y in corners for z in (-1.0, 1.0)]))


class TestRoundParts:
    @pytest.mark.parametrize("sides", [45, 200])
    def test_a_finely_tessellated_cylinder_has_three_poses(self, sides):
        poses = poses_of(shapes.cylinder(sides, 9.0, 22.0))
        assert len(poses) == 3
        assert sorted(len(pose.members) for pose in poses) == [1, 1, sides]

    def test_without_a_tolerance_every_facet_is_a_pose(self):
        assert len(poses_of(shapes.cylinder(64, 9.0, 22.0), 0.0)) == 66

    @pytest.mark.parametrize(("sides", "radius", "length"), [(48, 9.0, 22.0), (64, 10.0, 4.0)])
    def test_geometry_of_the_side(self, sides, radius, length):
        poses = poses_of(shapes.cylinder(sides, radius, length))
        (side,) = (pose for pose in poses if len(pose.members) == sides)
        apothem = radius * np.cos(np.pi / sides)
        assert side.height == pytest.approx(apothem, rel=1e-12)
        assert side.margin == pytest.approx(np.arctan2(length / 2.0, apothem), rel=1e-9)
        assert side.barrier == pytest.approx(np.hypot(apothem, length / 2.0) - apothem, rel=1e-9)
        assert side.spread == pytest.approx(np.pi, abs=1e-6)
        assert side.top == pytest.approx(2.0 * apothem, rel=1e-12)

    @pytest.mark.parametrize("sides", [49, 63])
    def test_spread_of_an_odd_number_of_facets(self, sides):
        poses = poses_of(shapes.cylinder(sides, 9.0, 22.0))
        (side,) = (pose for pose in poses if len(pose.members) == sides)
        assert side.spread == pytest.approx(np.pi * (1.0 - 1.0 / sides), rel=1e-9)

    def test_a_ball_is_one_pose(self):
        (pose,) = poses_of(shapes.hull_mesh(shapes.sphere_points(3000, seed=3)), 0.02)
        assert pose.barrier == np.inf
        assert pose.spread > 3.0


class TestPlatesAndBars:
    """A tolerance of 0.0025 is a tilt of 4 degrees: sqrt(1 + t^-2) < 1.0025 from t = 14.1 on."""

    @pytest.mark.parametrize(("slenderness", "count"), [(14.0, 6), (14.3, 2)])
    def test_a_thin_plate_does_not_stand_on_its_edge(self, slenderness, count):
        assert len(poses_of(plate(slenderness))) == count

    def test_a_bar_keeps_its_four_sides(self):
        poses = poses_of(shapes.box(1.0, 2.0, 60.0))
        assert len(poses) == 4
        assert len({pose.group for pose in poses}) == 2

    def test_shelves_change_neither_group_nor_margin_nor_spread(self):
        """From a thin plate's face the way out is over its edge, by 86 degrees."""
        low, high = poses_of(plate(14.3))
        assert low.group == high.group
        assert sorted([len(low.members), len(high.members)]) == [1, 5]
        assert low.spread == high.spread == 0.0
        tilt = np.arctan2(14.3, 1.0)
        assert max(low.margin, high.margin) == pytest.approx(np.pi / 2.0, abs=1e-6)
        assert min(low.margin, high.margin) == pytest.approx(tilt, abs=1e-6)

    def test_a_shelf_goes_to_the_face_across_its_lower_saddle(self):
        """Oblique sides are left at 1.057 towards those of 0.95, at 1.082 towards those of 1."""
        poses = poses_of(flattened_octagon(), 0.07)
        assert len(poses) == 6
        assert [len(pose.members) for pose in poses if abs(pose.down[1]) > 0.9] == [3, 3]


def demo_poses(name):
    return resting_poses(part_from_mesh(*DEMO[name], unit="mm")).poses


class TestDemoParts:
    @pytest.mark.parametrize(("name", "poses", "groups"), [
        ("prism", 8, 2), ("cylinder", 3, 2), ("gear", 4, 4), ("clamp", 7, 7), ("bracket", 5, 5),
    ])
    def test_counts(self, name, poses, groups):
        found = demo_poses(name)
        assert len(found) == poses
        assert len({pose.group for pose in found}) == groups

    def test_a_bolt_has_a_handful_of_poses(self):
        assert 3 <= len(demo_poses("hex_bolt")) <= 8

    def test_hexagonal_prism_keeps_its_six_sides(self):
        assert len(poses_of(shapes.prism(6, 10.0, 24.0))) == 8


BODIES = {
    "random": random_polyhedron(20, 20),
    "sphere points": shapes.hull_mesh(shapes.sphere_points(60, 4)),
    "ellipsoid": shapes.hull_mesh(shapes.ellipsoid_points(150, 1, (3.0, 2.0, 1.5))),
    "cylinder": shapes.cylinder(48, 1.0, 0.7),
    "box": shapes.box(1.0, 2.0, 3.0),
    "clamp hull": clamp_hull(),
    "bolt": DEMO["hex_bolt"],
}
TOLERANCES = (1e-4, 0.0025, 0.01, 0.1, 0.4)


@pytest.mark.parametrize("surface", BODIES.values(), ids=BODIES)
class TestRule:
    """Against the contract's words, read independently."""

    def test_members_and_barriers(self, surface):
        part = part_from_mesh(*surface)
        for tolerance in TOLERANCES:
            resting = resting_poses(part, tolerance, round_sides=0)
            expected = persistent_poses(resting, tolerance)
            radius = resting.body.radius
            found = {frozenset(pose.members): (pose.height + pose.barrier) / radius
                     for pose in resting.poses}
            assert found.keys() == expected.keys()
            for members, level in expected.items():
                assert found[members] == pytest.approx(level, rel=1e-9)

    def test_the_lowest_member_stands_for_the_pose(self, surface):
        part = part_from_mesh(*surface)
        single = resting_poses(part, 0.0, round_sides=0).poses
        for tolerance in TOLERANCES:
            for pose in resting_poses(part, tolerance, round_sides=0).poses:
                members = [single[i] for i in pose.members]
                lowest = min(member.height for member in members)
                (own,) = (member for member in members if np.array_equal(member.down, pose.down))
                assert own.height <= lowest * (1.0 + 2e-6)
                assert pose.height == own.height
                assert pose.top == own.top
                assert np.array_equal(pose.orientation, own.orientation)
                assert np.array_equal(pose.position, own.position)
                assert np.array_equal(pose.support_polygon, own.support_polygon)

    def test_spread(self, surface):
        part = part_from_mesh(*surface)
        single = resting_poses(part, 0.0, round_sides=0).poses
        for tolerance in TOLERANCES:
            for pose in resting_poses(part, tolerance, round_sides=0).poses:
                own = downs([single[i] for i in pose.members
                             if single[i].height < (1.0 + tolerance) * pose.height
                             or np.array_equal(single[i].down, pose.down)])
                chord = np.linalg.norm(own[:, None] - own[None], axis=-1).max()
                expected = 2.0 * np.arcsin(min(chord / 2.0, 1.0))
                assert pose.spread == pytest.approx(expected, abs=1e-7)

    def test_probabilities_add_up_over_members(self, surface):
        """But of those that ask for the pose as a whole: its probability, or its area."""
        part = part_from_mesh(*surface)
        for method in set(METHODS) - {"nqse", "combined", "split", "pqse"}:
            single = {pose.index: pose.probability
                      for pose in estimate(
                          part, method, cluster_tolerance=0.0, round_sides=0).poses}
            for tolerance in TOLERANCES:
                for pose in estimate(
                        part, method, cluster_tolerance=tolerance, round_sides=0).poses:
                    expected = sum(single[i] for i in pose.members)
                    assert pose.probability == pytest.approx(expected, abs=1e-12)

    def test_the_nonlinear_rule_acts_on_the_sum(self, surface):
        # Facet by facet Eq. 6 would give a curve the less the finer it is tessellated.
        part = part_from_mesh(*surface)
        for tolerance in TOLERANCES:
            found = {name: {pose.index: pose.probability for pose in
                            estimate(part, name, cluster_tolerance=tolerance, round_sides=0).poses}
                     for name in ("qse", "meae", "nqse", "combined")}
            index = sorted(found["qse"])
            weight = nonlinear(np.array([found["qse"][i] for i in index]))
            nqse = weight / weight.sum()
            assert [found["nqse"][i] for i in index] == pytest.approx(nqse, abs=1e-13)
            meae = np.array([found["meae"][i] for i in index])
            assert [found["combined"][i] for i in index] == pytest.approx(
                0.75 * meae + 0.25 * nqse, abs=1e-13)


def test_a_shallow_pose_beside_a_deep_one_belongs_to_it():
    """Its saddle is 0.00002 radii above it and 0.4 above the other."""
    part = part_from_mesh(*oblique_prism(1.2, 2.0), center_of_mass=(0.99, 0.1, 0.5))
    single, merged = (resting_poses(part, tolerance, round_sides=0) for tolerance in (0.0, 0.0025))
    (shallow,) = [pose for pose in single.poses if pose.barrier < 0.001 * single.body.radius]
    assert len(merged.poses) == len(single.poses) - 1
    (deep,) = [pose for pose in merged.poses if len(pose.members) > 1]
    assert shallow.index in deep.members
    assert deep.barrier > 0.1 * single.body.radius


def test_the_nonlinear_estimate_of_a_cylinder_does_not_depend_on_its_facets():
    shares = []
    for sides in (48, 64, 128, 256):
        found = estimate(part_from_mesh(*shapes.cylinder(sides, 1.0, 2.0)), "nqse", round_sides=0)
        (side,) = (pose for pose in found.poses if len(pose.members) == sides)
        shares.append(side.probability)
    assert shares == pytest.approx([shares[-1]] * 4, abs=0.005)


def test_of_tied_members_the_largest_face_stands_for_the_pose():
    # A prism whose base has corners at uneven steps on a circle around it: all sides touch
    # the same inner circle but differ in width.
    angles = np.cumsum(np.concatenate(([0.0], np.tile([0.08, 0.1, 0.13, 0.09], 20))))
    angles = 2.0 * np.pi * angles[:-1] / angles[-1]
    turns = np.diff(np.append(angles, 2.0 * np.pi)) / 2.0
    middle = angles + turns
    corners = np.column_stack((np.cos(middle), np.sin(middle))) / np.cos(turns)[:, None]
    vertices = np.vstack((np.column_stack((corners, np.full(len(middle), -1.5))),
                          np.column_stack((corners, np.full(len(middle), 1.5)))))
    part = part_from_mesh(*shapes.hull_mesh(vertices), center_of_mass=(0.0, 0.0, 0.0))
    resting = resting_poses(part, 0.01, round_sides=0)
    (side,) = (pose for pose in resting.poses if len(pose.members) > 1)
    found = resting.equilibria
    area = found.body.arrays.area[found.faces]
    own = [i for i in side.members if np.array_equal(found.downs[i], side.down)]
    assert area[own[0]] == pytest.approx(max(area[i] for i in side.members), rel=1e-9)
