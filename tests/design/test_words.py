"""What a comparison says in its first sentence, and of sizes that differ as units do."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import DropScene, part_from_mesh, resting_poses
from ros_pose_stats.design.compare import compare
from ros_pose_stats.design.comparison import SHOWN
from ros_pose_stats.design.correspondence import find_correspondence
from ros_pose_stats.design.paired_drops import PairedDrops
from ros_pose_stats.design.verdicts import compare_pairs
from ros_pose_stats.design.words import describe_verdict
from ros_pose_stats.records.statistics import DEFAULT_PLATE_ERROR
from tests.bodies import random_polyhedron

from .variants import clamp, stretched


def parts_of(*surfaces):
    return [part_from_mesh(*one) for one in surfaces]


class TestWords:
    def test_the_largest_difference_is_named(self):
        found = compare(parts_of(clamp(), stretched(clamp(), 1.0, 1.0, 1.5)), drops=1250, seed=1)
        (one,) = found.variants
        shown = [pose for pose in one.poses if pose.share.on_plate == SHOWN]
        largest = max(shown, key=lambda pose: abs(pose.share.difference.value))
        words = describe_verdict(found, one)
        assert words.startswith("A and B: difference shown, in the model and on a plate. The "
                                "largest shown on a plate is ")
        assert f"{100 * largest.share.difference.value:+.1f} points (" in words
        assert f"of pose {largest.poses.first[0]} of A" in words

    def test_wanted_poses_come_first_whatever_the_others_do(self):
        """Drops made up: pose 0 gains from pose 1, and pose 2 is wanted."""
        part = part_from_mesh(*random_polyhedron(10, 1))
        resting = resting_poses(part)
        outcome = np.tile(np.arange(20_000) % len(resting.poses), (2, 1))
        outcome[1, np.flatnonzero(outcome[0] == 1)[:800]] = 0
        pairs = PairedDrops(DropScene(drop_height=1.0), 0, (resting, resting), outcome)
        found = compare_pairs([part, part], pairs, [find_correspondence(resting, resting)], (2,),
                              0.5, DEFAULT_PLATE_ERROR)
        (one,) = found.variants
        share = f"{100 / len(resting.poses):.1f} %"
        assert describe_verdict(found, one) == (
            f"Accepted are {share} of A and {share} of B, B - A +0.0 points (+0.0 to +0.0): no "
            "difference shown in 20000 drops of each. Of single poses the largest difference "
            f"shown on a plate is {_points(one.poses, 0)}, of pose 0 of A and pose 0 of B.")

    @pytest.mark.parametrize("factor", [0.001, 1.0 / 25.4, 10.5, 25.4, 1000.0])
    def test_sizes_that_differ_as_units_do(self, factor):
        found = compare(parts_of(clamp(), stretched(clamp(), *(3 * [factor]))), drops=10, seed=1)
        (line,) = found.variants[0].warnings
        larger = f"B is {factor:.4g} times as large as A" if factor > 1.0 else (
            f"A is {1.0 / factor:.4g} times as large as B")
        assert line.startswith(f"UNITS_DIFFER: {larger}: most likely one of the files")
        assert found.as_dict()["comparisons"][0]["warnings"] == [line]

    @pytest.mark.parametrize("factor", [1.0, 2.54, 3.0, 8.0, 60.0])
    def test_others_do_not(self, factor):
        found = compare(parts_of(clamp(), stretched(clamp(), *(3 * [factor]))), drops=10, seed=1)
        assert found.variants[0].warnings == ()


def _points(poses, index):
    known = next(pose.share for pose in poses if index in pose.poses.first).difference
    return f"{100 * known.value:+.1f} points ({100 * known.low:+.1f} to {100 * known.high:+.1f})"
