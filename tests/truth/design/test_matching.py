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

"""Which poses of two variants are the same pose: by the direction down, a turn, or
footprints.
"""

import math

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import moved, rotation
from ros_pose_stats import compare, part_from_mesh, resting_poses, shift_center
from ros_pose_stats.core.shapes.demo_parts import DEMO_PARTS

CUBE = shapes.box(16.0, 16.0, 16.0)
NEAR_CUBE = shapes.box(16.0, 16.0, 15.52)


def clamp(*factors):
    vertices, triangles = DEMO_PARTS["clamp"]()
    return vertices * (factors or 1.0), triangles


def matched(first, second):
    """Of two surfaces or parts: how, and pairs of indices, none where there is no
    partner.
    """
    parts = [
        surface if hasattr(surface, "digest") else part_from_mesh(*surface)
        for surface in (first, second)
    ]
    (variant,) = compare(parts, drops=1, seed=1).variants
    pairs = [(pose.poses.first, pose.poses.second) for pose in variant.poses]
    return variant.correspondence, sorted(pairs)


def alone(pairs):
    return [pair for pair in pairs if not all(pair)]


def downs_of(surface):
    return np.array(
        [pose.down for pose in resting_poses(part_from_mesh(*surface)).poses]
    )


def same_numbers(pairs):
    return all(first == second for first, second in pairs)


class TestInOneFrame:
    def test_poses_are_followed_whatever_their_numbers(self):
        longer = clamp(1.08, 1.0, 1.0)
        _, pairs = matched(clamp(), longer)
        first = downs_of(clamp())
        second = downs_of(longer)
        for (pose,), (partner,) in pairs:
            assert first[pose] @ second[partner] > math.cos(math.radians(10.0))
        assert not same_numbers(pairs)  # two have changed places

    def test_symmetry_counts_as_far_as_both_have_it(self):
        _, pairs = matched(CUBE, NEAR_CUBE)
        assert sorted(len(first) for first, _ in pairs) == [2, 4]
        short = next(second for _, second in pairs if len(second) == 2)
        assert np.abs(downs_of(NEAR_CUBE)[list(short)][:, 2]).min() == pytest.approx(
            1.0
        )

    def test_a_face_that_is_new_has_no_partner(self):
        vertices, _ = shapes.box(1.0, 1.0, 1.0)
        high = vertices.max(axis=0)
        corners = vertices[(vertices < high - 1e-9).any(axis=1)]
        bevelled = shapes.hull_mesh(np.concatenate([corners, high - 0.6 * np.eye(3)]))
        _, pairs = matched(shapes.box(1.0, 1.0, 1.0), bevelled)
        ((first, (bevel,)),) = alone(pairs)
        assert first == ()
        assert downs_of(bevelled)[bevel] == pytest.approx(
            np.full(3, math.sqrt(1.0 / 3.0))
        )
        assert sum(len(first) for first, _ in pairs) == 6

    def test_a_centre_moved_to_the_other_side_is_no_turn(self):
        """The outer shapes are equal; turned upside down the bodies would be, too."""
        box = part_from_mesh(*shapes.box(0.02, 0.03, 0.01))
        up, down = (shift_center(box, (0.0, 0.0, z)) for z in (0.002, -0.002))
        frame, pairs = matched(up, down)
        assert frame.turn is None
        lying = [
            next(
                pose.index for pose in resting_poses(part).poses if pose.down[2] < -0.9
            )
            for part in (up, down)
        ]
        assert ((lying[0],), (lying[1],)) in pairs

    def test_a_round_side_is_one_pose_whatever_its_facets(self):
        _, pairs = matched(*(shapes.prism(sides, 0.01, 0.03) for sides in (60, 96)))
        assert alone(pairs) == []


class TestTurnedInTheFile:
    @pytest.mark.parametrize("seed", range(3))
    def test_the_turn_of_the_same_body(self, seed):
        surface = random_polyhedron(9, seed)
        turn = rotation(seed)
        frame, pairs = matched(surface, moved(surface, turn, (1.0, 2.0, 3.0)))
        assert frame.turn == pytest.approx(turn, abs=1e-6) and frame.same_body
        assert same_numbers(pairs) and not alone(pairs)

    def test_axes_that_changed_places(self):
        """Every pose has one of the same direction down, but not of the same
        footprint.
        """
        frame, pairs = matched(
            shapes.box(0.01, 0.02, 0.03), shapes.box(0.02, 0.01, 0.03)
        )
        assert frame.turn is not None
        assert pairs == [((0, 1), (0, 1)), ((2, 3), (2, 3)), ((4, 5), (4, 5))]

    def test_turned_and_changed(self):
        turn = rotation(1)
        longer = clamp(1.02, 1.0, 1.0)
        frame, pairs = matched(clamp(), moved(longer, turn))
        assert not frame.same_body
        away = math.acos(min(1.0, 0.5 * (np.trace(frame.turn @ turn.T) - 1.0)))
        assert away < math.radians(3.0)
        assert pairs == matched(clamp(), longer)[1]

    def test_a_mirrored_part_is_matched_by_footprint(self):
        """No turn lays it on the first one, and none of its sides is one of the
        first.
        """
        stone = random_polyhedron(9, 5)
        vertices, triangles = moved(stone, rotation(1))
        frame, pairs = matched(stone, (-vertices, triangles[:, ::-1]))
        assert frame.turn is None and not frame.by_orientation
        assert same_numbers(pairs) and not alone(pairs)


def test_two_parts_that_have_nothing_in_common():
    frame, pairs = matched(clamp(), moved(random_polyhedron(8, 2), scale=100.0))
    assert not frame.by_orientation and pairs == alone(pairs)
