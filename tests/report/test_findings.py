"""What a report finds out, and how long it may take."""

import pytest

from ros_pose_stats import part_from_mesh, simulate
from ros_pose_stats.errors import RequestError
from ros_pose_stats.estimators import ESTIMATORS
from ros_pose_stats.report import findings, investigate
from ros_pose_stats.shapes.closed_forms import box
from tests.report.parts import block


def test_every_method_is_asked_about_the_same_poses():
    found = block()
    assert [one.method for one in found.estimates] == list(ESTIMATORS)
    assert found.simulated.drops == found.hybrid.drops == 300
    assert found.hybrid.expected_error <= found.simulated.expected_error
    assert found.graph.poses == tuple(range(6))
    assert len(found.sphere.downs) == 6
    assert found.wanted is None
    assert len(set(found.warnings)) == len(found.warnings)


def test_dropping_ends_in_time_and_what_was_done_can_be_had_again(monkeypatch):
    monkeypatch.setattr(findings, "LONGEST", 0.0)
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    short = investigate(part, seed=5, workers=1).simulated
    assert 0 < short.drops < findings.MOST_DROPS
    again = simulate(part, short.drops, seed=5, workers=1)
    assert [pose.count for pose in again.poses] == [pose.count for pose in short.poses]


def test_drops_that_are_asked_for_are_all_done(monkeypatch):
    monkeypatch.setattr(findings, "LONGEST", 0.0)
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    assert investigate(part, drops=400, seed=5).simulated.drops == 400
    stopped = investigate(part, drops=10**6, seed=5, should_stop=lambda: True).simulated
    assert stopped.drops < 10**6


def test_a_feeder_that_wants_what_is_not_there_is_refused_before_anything_is_dropped():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    with pytest.raises(RequestError, match="poses from 0 to 5, got 9"):
        investigate(part, drops=10**9, wanted=(9,))
