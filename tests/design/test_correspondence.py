"""Which poses of two variants are the same pose."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, resting_poses, shapes, shift_center
from tests.bodies import moved, random_polyhedron, rotation

from .variants import CUBE, NEAR_CUBE, SIDE, clamp, correspondence, exported, stretched


def pairs(found):
    return [(one.first, one.second) for one in found.matches if one.is_pair]


def alone(found):
    return [(one.first, one.second) for one in found.matches if not one.is_pair]


def downs_of(surface):
    return np.array([pose.down for pose in resting_poses(part_from_mesh(*surface)).poses])


class TestInOneFrame:
    def test_a_part_and_its_export(self):
        found = correspondence(clamp(), exported(clamp(), 3))
        assert found.by_orientation and found.turn is None and not alone(found)
        assert np.array_equal(found.partner, np.arange(7))

    def test_poses_are_followed_whatever_their_numbers(self):
        other = stretched(clamp(), 1.08, 1.0, 1.0)
        found = correspondence(clamp(), other)
        first, second = downs_of(clamp()), downs_of(other)
        cosines = (first * second[found.partner]).sum(axis=1)
        assert cosines.min() > math.cos(math.radians(10.0))
        assert found.partner.tolist() != list(range(7))  # two have changed places

    def test_symmetry_counts_as_far_as_both_have_it(self):
        found = correspondence(CUBE, NEAR_CUBE)
        assert found.turn is None
        assert sorted(len(one) for one, _ in pairs(found)) == [2, 4]
        downs = downs_of(NEAR_CUBE)
        short = next(other for _, other in pairs(found) if len(other) == 2)
        assert np.abs(downs[list(short)][:, 2]).min() == pytest.approx(1.0)

    def test_a_pose_without_a_partner_says_so(self):
        box = shapes.box(1.0, 1.0, 1.0)
        low, high = box[0].min(axis=0), box[0].max(axis=0)
        cut = high - 0.6 * np.eye(3)  # the corner is cut off by a plane
        left = box[0][(box[0] < high - 1e-9).any(axis=1)]
        bevelled = shapes.hull_mesh(np.concatenate([left, cut]))
        assert low == pytest.approx(bevelled[0].min(axis=0))
        found = correspondence(box, bevelled)
        ((first, (bevel,)),) = alone(found)
        assert first == ()
        assert downs_of(bevelled)[bevel] == pytest.approx(np.full(3, math.sqrt(1.0 / 3.0)))
        assert sum(len(one) for one, _ in pairs(found)) == 6

    def test_a_centre_moved_to_the_other_side_is_no_turn(self):
        """The outer shapes are equal; turned upside down the bodies would be, too."""
        box = part_from_mesh(*shapes.box(0.02, 0.03, 0.01))
        up, down = (shift_center(box, (0.0, 0.0, z)) for z in (0.002, -0.002))
        found = correspondence(up, down)
        assert found.turn is None and found.by_orientation
        first = next(pose.index for pose in resting_poses(up).poses if pose.down[2] < -0.9)
        second = next(pose.index for pose in resting_poses(down).poses if pose.down[2] < -0.9)
        assert found.partners([first]) == (second,)

    def test_a_round_side_is_found_where_another_export_has_other_facets(self):
        coarse, fine = (shapes.prism(sides, 0.01, 0.03) for sides in (60, 96))
        found = correspondence(coarse, fine)
        assert found.by_orientation and not alone(found)


class TestTurnedInTheFile:
    @pytest.mark.parametrize("seed", range(6))
    def test_the_turn_is_found(self, seed):
        surface, turn = random_polyhedron(9, seed), rotation(seed)
        found = correspondence(surface, moved(surface, turn, (1.0, 2.0, 3.0)))
        assert found.turn == pytest.approx(turn, abs=1e-6) and found.same_body
        assert np.array_equal(found.partner, np.arange(found.partner.size))
        assert 2.0 * math.cos(found.angle) + 1.0 == pytest.approx(np.trace(turn))

    def test_axes_that_changed_places(self):
        """Every pose has one of the same direction down, but not of the same footprint."""
        found = correspondence(shapes.box(0.01, 0.02, 0.03), shapes.box(0.02, 0.01, 0.03))
        assert found.turn is not None
        assert pairs(found) == [((0, 1), (0, 1)), ((2, 3), (2, 3)), ((4, 5), (4, 5))]

    def test_a_near_cube_with_another_short_axis(self):
        found = correspondence(NEAR_CUBE, shapes.box(0.97 * SIDE, SIDE, SIDE))
        assert found.turn is not None
        assert sorted(map(len, (one for one, _ in pairs(found)))) == [2, 4]

    @pytest.mark.parametrize("seed", range(4))
    def test_turned_and_changed(self, seed):
        turn = rotation(seed)
        found = correspondence(clamp(), moved(stretched(clamp(), 1.02, 1.0, 1.0), turn))
        assert not found.same_body
        away = math.acos(min(1.0, 0.5 * (np.trace(found.turn @ turn.T) - 1.0)))
        assert away < math.radians(3.0)
        unturned = correspondence(clamp(), stretched(clamp(), 1.02, 1.0, 1.0))
        assert np.array_equal(found.partner, unturned.partner)

    def test_a_mirrored_part_is_matched_by_footprint(self):
        """No turn lays it on the first one, and none of its sides is one of the first."""
        stone = random_polyhedron(9, 5)
        vertices, triangles = moved(stone, rotation(1))
        found = correspondence(stone, (-vertices, triangles[:, ::-1]))
        assert found.turn is None and not found.by_orientation
        assert np.array_equal(found.partner, np.arange(found.partner.size))


def test_two_parts_that_have_nothing_in_common():
    found = correspondence(clamp(), moved(random_polyhedron(8, 2), scale=0.1))
    assert not found.by_orientation and not pairs(found)
    assert found.partners([0, 1]) == ()


def test_one_pose_in_all():
    weighted = part_from_mesh(*shapes.icosahedron(), center_of_mass=(0.0, 0.0, 0.0))
    heavy = shift_center(weighted, (0.0, 0.0, -0.6))
    assert correspondence(heavy, heavy).turn is None
