"""Warnings of poses that are close to changing."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, resting_poses, simulate
from ros_pose_stats.resting.trust import pose_warnings
from ros_pose_stats.shapes import box, cylinder, hull_mesh


def codes(warnings):
    return [one.partition(":")[0] for one in warnings]


def leaning(lean):
    """A prism whose bases stop being stable at a lean of 1; turned so that nothing ties."""
    base = np.array([(x, y, 0.0) for x in (-0.5, 0.5) for y in (-0.4, 0.4)])
    top = base + np.array((lean, 0.0, 1.5))
    return part_from_mesh(*hull_mesh(0.01 * np.vstack((base, top))))


def found(part, tolerance=0.0):
    return pose_warnings(resting_poses(part, tolerance))


class TestMarginal:
    @pytest.mark.parametrize(("lean", "warned"), [(0.9, False), (0.999, True), (1.001, False)])
    def test_a_face_about_to_be_lost(self, lean, warned):
        assert ("MARGINAL_POSE" in codes(found(leaning(lean)))) == warned

    def test_it_names_poses_and_tilt(self):
        """Foot of the centre of mass 0.5 (1 - lean) widths inside, 0.75 high."""
        (text,) = [one for one in found(leaning(0.99)) if one.startswith("MARGINAL_POSE")]
        tilt = np.degrees(np.arctan(0.5 * 0.01 / 0.75))
        poses = [pose.index for pose in resting_poses(leaning(0.99), 0.0).poses
                 if pose.margin < 0.0175]
        assert f"poses {', '.join(map(str, poses))} topple" in text
        assert f"{tilt:.2g} degrees" in text


class TestShallow:
    def test_a_pose_beside_deep_ones(self):
        """The roof of a flat ridge: rolling over it takes next to nothing."""
        points = [[x, y, z] for x in (-0.6, 0.6) for y in (-0.5, 0.5) for z in (0.0, 0.7)]
        ridge = [[x, 0.0, 0.71] for x in (-0.6, 0.6)]
        part = part_from_mesh(*hull_mesh(0.01 * np.array(points + ridge)))
        (text,) = [one for one in found(part) if one.startswith("SHALLOW_POSE")]
        barriers = sorted(pose.barrier for pose in resting_poses(part, 0.0).poses)
        assert f"{1e3 * barriers[0]:.2g} mm" in text

    def test_equal_poses_are_not_shallow(self):
        assert found(part_from_mesh(*box(0.01, 0.01, 0.01))) == []


class TestNearTie:
    @pytest.mark.parametrize(("side", "warned"), [(1.0, False), (1.0005, True), (1.2, False)])
    def test_a_tile_that_is_nearly_square(self, side, warned):
        part = part_from_mesh(*box(0.01, 0.02, 0.02 * side))
        assert ("NEAR_TIE" in codes(found(part))) == warned


class TestCurves:
    @pytest.mark.parametrize(("sides", "warned"), [(48, True), (100, False)])
    @pytest.mark.parametrize("tolerance", [0.0, 0.0025])
    def test_coarse_facets_as_the_file_has_them(self, sides, warned, tolerance):
        resting = resting_poses(part_from_mesh(*cylinder(sides, 0.01, 0.02)), tolerance, 0)
        assert ("COARSE_CURVE" in codes(pose_warnings(resting))) == warned

    def test_the_angle_is_that_of_the_facets(self):
        resting = resting_poses(part_from_mesh(*cylinder(60, 0.01, 0.02)), round_sides=0)
        (text,) = [one for one in pose_warnings(resting) if one.startswith("COARSE_CURVE")]
        assert "facets of 6 degrees" in text

    @pytest.mark.parametrize("sides", [24, 600])
    def test_circles_are_rounded(self, sides):
        resting = resting_poses(part_from_mesh(*cylinder(sides, 0.01, 0.02)))
        texts = pose_warnings(resting)
        assert codes(texts) == ["ROUNDED", "CLUSTERED"]
        assert "2 round edges" in texts[0] and "192 sides" in texts[0]

    def test_circles_that_have_so_many_sides_stay(self):
        resting = resting_poses(part_from_mesh(*cylinder(192, 0.01, 0.02)))
        assert codes(pose_warnings(resting)) == ["CLUSTERED"]

    def test_drops_of_coarse_cylinders_do_end_on_the_curve(self):
        """What the warning says, by 600 drops each: 4 binomial errors are 0.08."""
        ends = [sum(pose.probability for pose in
                    simulate(part_from_mesh(*cylinder(sides, 0.01, 0.02)), 600, seed=1,
                             round_sides=0).poses if abs(pose.down[2]) > 0.9)
                for sides in (32, 400)]
        assert ends[1] - ends[0] > 0.08


def test_answers_carry_them():
    part = leaning(0.999)
    assert "MARGINAL_POSE" in codes(estimate(part, cluster_tolerance=0.0).warnings)
    assert "MARGINAL_POSE" in codes(simulate(part, 10, seed=1, cluster_tolerance=0.0).warnings)
    coarse = part_from_mesh(*cylinder(46, 0.01, 0.02))
    assert "COARSE_CURVE" in codes(simulate(coarse, 10, seed=1, round_sides=0).warnings)
    assert "COARSE_CURVE" in codes(estimate(coarse, round_sides=0).warnings)
    assert "ROUNDED" in codes(estimate(coarse).warnings)
