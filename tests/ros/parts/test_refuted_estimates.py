"""What the node answers once drops have contradicted the estimate, without a node."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from ros_pose_stats import DropScene, estimate, simulate
from ros_pose_stats.ros.messages.statistics_messages import Answer, statistics_message
from ros_pose_stats.ros.parts.refinement import Refinement

from ..harness.parts import WEDGE, library_part

PART, SCENE = library_part(WEDGE, "part"), DropScene()


def message(found, *warnings):
    return statistics_message(replace(found, warnings=warnings), Answer(0, "plate", "", 1))


def refinement(drops):
    results = SimpleNamespace(estimate=lambda *asked: message(estimate(PART)),
                              find_drops=lambda *asked: drops)
    settings = SimpleNamespace(drops=10_000, max_drops=10_000, max_job_seconds=60.0)
    job = SimpleNamespace(job_id="run_0001", recorded=True)
    return Refinement(lambda: settings, results, SimpleNamespace(submit=lambda *asked: job))


@pytest.fixture(scope="module")
def dropped():
    return simulate(PART, 400, seed=3)


KNOWN = SimpleNamespace(part=PART, content=b"")


@pytest.mark.parametrize(("target", "said"), [
    (0.0, "Drops already made contradict split."),
    (0.2, "simulation with the 400 drops already made is within"),
    (0.005, "simulation with the 400 drops already made is within")])
def test_the_drops_answer_in_its_place(dropped, target, said):
    told = message(dropped, "CONFLICT: drops contradict the estimate.")
    found, why = refinement(told).answer(KNOWN, target, SCENE)
    assert (found.method, found.drops) == ("simulation", 400)
    assert why.startswith(said)
    assert any("TARGET_MISSED" in line for line in found.warnings) == (target == 0.005)


def test_drops_that_agree_leave_the_estimate_its_say(dropped):
    found, _ = refinement(message(dropped)).answer(KNOWN, 0.2, SCENE)
    assert (found.method, found.drops) == ("split", 0)
