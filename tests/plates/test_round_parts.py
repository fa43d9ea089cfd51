"""Fits of what rolling loses: which parts tell it, what is said of it, and simulated plates."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, resting_poses, shapes, simulate
from ros_pose_stats.plates import count_part, fit_plate
from ros_pose_stats.plates.evidence import ExplainedPart, conclude
from ros_pose_stats.plates.likelihood import scene_likelihood
from ros_pose_stats.plates.response import Shares
from ros_pose_stats.plates.round_parts import SIDES, UNTOLD_SIDES, stand_on_sides
from ros_pose_stats.plates.scenes import SceneGrid, SceneRange

BOXES = ((0.02, 0.03, 0.012), (0.016, 0.022, 0.02))


def cylinder(facets=64):
    """As high as wide."""
    return part_from_mesh(*shapes.prism(facets, 0.01, 0.02), part_id="cylinder")


def boxes():
    return [part_from_mesh(*shapes.box(*size)) for size in BOXES]


ROLLING = {48: 0.1, 96: 0.16, 192: 0.25, 384: 0.33}
"""Share of a cylinder on its ends, about as drops give it."""


class TestWhichParts:
    def test_a_cylinder_stands_with_each_number_of_sides_and_a_box_as_it_is(self):
        told = [count_part(cylinder(), {0: 7, 2: 40}), count_part(boxes()[0], {0: 9})]
        standing = stand_on_sides(told)
        assert list(standing) == list(SIDES)
        for sides, (rolling, box) in standing.items():
            assert rolling.round_sides == sides and rolling.by_group.tolist() == [7, 40]
            assert box is told[1]

    @pytest.mark.parametrize("told", [
        [count_part(part, {0: 50}) for part in boxes()],
        [count_part(cylinder(facets=12), {0: 50}), count_part(boxes()[0], {0: 50})],
        [count_part(cylinder(), {0: 50}, cluster_tolerance=0.0, round_sides=0),
         count_part(boxes()[0], {0: 50})],
        [count_part(cylinder(), {0: 50})],
    ], ids=["no round part", "a prism of twelve", "facets numbered one by one", "one number"])
    def test_parts_that_tell_nothing_of_it_stand_as_they_were_counted(self, told):
        assert stand_on_sides(told) == {192: told}

    def test_numbers_of_poses(self):
        part, ring = cylinder(), part_from_mesh(*shapes.prism(64, 0.01, 0.004))
        fine, coarse = (resting_poses(part, round_sides=sides) for sides in (384, 48))
        assert fine.is_numbered_like(coarse) and coarse.is_numbered_like(fine)
        assert not fine.is_numbered_like(resting_poses(part, 0.0, 48))  # each facet a pose
        assert not fine.is_numbered_like(resting_poses(ring))  # lies lower than it stands


class TestConclusions:
    """Shares that are the same in every scene, and differ with the sides."""

    def concluded(self, on_ends, counted=4000, cylinders=1):
        grid = SceneGrid.over(SceneRange.of_radii([0.02]).bounds, 4)
        group = boxes()[0]
        fixed = self.explained(group, {0: counted // 2, 2: counted // 4, 4: counted // 4},
                               (0.5, 0.25, 0.25), 192)
        return conclude(grid, {sides: [
            *[self.explained(cylinder(), {0: round(counted * on_ends),
                                          2: counted - round(counted * on_ends)},
                             (ROLLING[sides], 1.0 - ROLLING[sides]), sides)
              for _ in range(cylinders)], fixed, fixed, fixed] for sides in SIDES})

    @staticmethod
    def explained(part, counts, shares, sides):
        one = count_part(part, counts, round_sides=sides)
        expected = Shares(np.tile(shares, (16, 1)), np.zeros(16))
        return ExplainedPart(one, expected,
                             scene_likelihood(one.by_group.astype(float), expected))

    @pytest.mark.parametrize("sides", SIDES)
    def test_the_likeliest_sides(self, sides):
        assert self.concluded(ROLLING[sides]).round_sides == (sides, sides, sides)

    def test_sides_that_counts_do_not_exclude(self):
        """Of four the factors are 0.9, 0.94 and 0.69 for 0.16, 0.33 and 0.1; 1 / 3.9 excludes."""
        found = self.concluded(0.25, counted=4)
        assert found.round_sides == UNTOLD_SIDES
        # Of forty they are 0.35, 0.54 and 0.02.
        assert self.concluded(0.25, counted=40).round_sides == (192, 96, 384)

    def test_the_only_round_part_tells_the_sides_and_tests_nothing(self):
        found = self.concluded(0.1)
        assert math.isnan(found.parts[0].left_out_error)
        assert found.plate_error < 0.01 < 0.5 < found.p_value  # of the three boxes
        two = self.concluded(0.13, cylinders=2)
        assert two.parts[0].left_out_error == pytest.approx(0.03, abs=0.002)
        assert two.plate_error > 0.015


@pytest.mark.long
@pytest.mark.parametrize("sides", [48, 192])
def test_simulated_plates(sides):
    """A cylinder and two boxes, dropped with one number of sides and fitted with all."""
    counted = []
    for seed, part in enumerate([cylinder(), *boxes()], start=11):
        found = simulate(part, 3000, 0.4, seed, 0.12, round_sides=sides)
        counted.append(count_part(part, {pose.index: pose.count for pose in found.poses}))
    fit = fit_plate(counted, seed=5)
    best, low, high = fit.round_sides
    assert best == sides and low <= sides <= high
    assert fit.restitution[1] <= 0.4 <= fit.restitution[2]
    assert fit.drop_height[1] <= 0.12 <= fit.drop_height[2]
