"""Which counts of cameras cannot be compared, without a node."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from ros_pose_stats_msgs.msg import PoseCounts, PoseStatistics, StablePose

from ros_pose_stats.ros.pose_counts import count_problem

DIGEST = "ab" * 32


def known(part_id):
    """One part that has two poses."""
    if part_id != "clamp":
        return None
    latched = PoseStatistics(cluster_tolerance=0.0025, round_sides=192,
                             poses=[StablePose(index=1), StablePose(index=0)])
    return SimpleNamespace(part=SimpleNamespace(digest=DIGEST), latched=latched)


def problem(**fields):
    return count_problem(PoseCounts(**{
        "part_id": "clamp", "part_digest": DIGEST, "cluster_tolerance": 0.0025,
        "round_sides": 192, "index": [0, 1], "count": [5, 3], **fields}), known)


def test_counts_of_the_same_poses():
    assert problem() == problem(part_digest="") == ""


@pytest.mark.parametrize(("fields", "counted"), [
    ({"round_sides": 0}, "cluster_tolerance 0.0025 and round_sides 0"),
    ({"cluster_tolerance": 0.005}, "cluster_tolerance 0.005 and round_sides 192"),
    ({"cluster_tolerance": float("nan")}, "cluster_tolerance unknown and round_sides 192"),
])
def test_another_numbering_is_named_with_that_of_the_results(fields, counted):
    assert problem(**fields) == (
        f"it has {counted}, the results have cluster_tolerance 0.0025 and round_sides 192; copy "
        "both from PoseStatistics")


@pytest.mark.parametrize(("fields", "said"), [
    ({"count": [5]}, "2 pose indices and 1 counts"),
    ({"part_id": "other"}, "is known"),
    ({"part_digest": "cd" * 32}, "another part_digest"),
    ({"index": [0, 7]}, "no pose 7"),
])
def test_what_else_is_in_the_way(fields, said):
    assert said in problem(**fields)
