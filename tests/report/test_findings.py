"""What a report finds out, and how many drops it takes."""

import time

import numpy as np

from ros_pose_stats import part_from_mesh, simulate, simulate_flips
from ros_pose_stats.estimators import ESTIMATORS
from ros_pose_stats.planning.kick_sweep import SWEEP_FLIPS
from ros_pose_stats.report import Feeder, findings, investigate
from ros_pose_stats.shapes.closed_forms import box
from tests.report.parts import block


def test_every_method_is_asked_about_the_same_poses():
    found = block()
    assert [one.method for one in found.estimates] == list(ESTIMATORS)
    assert found.simulated.drops == found.hybrid.drops == 300
    assert found.hybrid.expected_error <= found.simulated.expected_error
    assert found.graph.poses == tuple(range(6))
    assert len(found.sphere.downs) == 6
    assert found.afresh is found.sweep is found.kicked is None
    assert len(set(found.warnings)) == len(found.warnings)


def counts(found):
    return {pose.index: pose.count for pose in found.poses}


def test_as_many_drops_as_the_error_takes_on_every_machine():
    """The same drops from one slow worker as from three; and no drop but those of the seed."""
    part = part_from_mesh(*box(0.04, 0.03, 0.02))

    def idle():
        time.sleep(0.02)
        return False

    found = investigate(part, seed=5, workers=3)
    slow = investigate(part, seed=5, workers=1, should_stop=idle).simulated
    assert found.target_error == findings.TARGET_ERROR
    assert found.simulated.expected_error <= findings.TARGET_ERROR
    assert found.simulated.drops < findings.MOST_DROPS
    assert counts(slow) == counts(found.simulated) == counts(
        simulate(part, found.simulated.drops, seed=5, workers=1))


def test_where_the_bound_comes_first_the_page_says_so(monkeypatch):
    monkeypatch.setattr(findings, "MOST_DROPS", 200)
    found = investigate(part_from_mesh(*box(0.04, 0.03, 0.02)), seed=5, workers=1)
    assert found.simulated.drops == 200
    assert [code for code in found.warnings if code.startswith("TARGET_MISSED")]


def test_drops_that_are_asked_for_are_all_done():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    asked = investigate(part, drops=4000, seed=5)
    assert (asked.simulated.drops, asked.target_error) == (4000, 0.0)
    stopped = investigate(part, drops=10**6, seed=5, should_stop=lambda: True).simulated
    assert stopped.drops < 10**6


def test_a_kick_is_one_of_the_sweep_and_flips_as_often():
    found = block((0, 1), 60.0, 0.02)
    assert found.kicked in found.sweep.kicks and len(found.sweep.kicks) == 14
    alone = simulate_flips(found.part, 0.02, SWEEP_FLIPS, seed=1)
    np.testing.assert_array_equal(found.kicked.flips.counts, alone.counts)
    assert found.sweep.afresh == found.afresh and block((0, 1), 60.0).sweep is None


def test_a_stop_leaves_the_kicks_out():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    stopped = investigate(part, drops=10**6, seed=5, feeder=Feeder((0,), 60.0, 0.02),
                          should_stop=lambda: True)
    assert stopped.sweep is None and stopped.kicked is None
