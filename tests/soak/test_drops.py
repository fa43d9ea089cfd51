"""The soak run in small, and that it would notice what it looks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.soak import drops as soak
from tests.soak.drop_tally import ROUNDING, Tally, judge, report

DROPS = 6000


@pytest.fixture(scope="module")
def sample():
    """A task of a hundred drops with its outcomes."""
    task = next(soak.tasks(300, 1))
    return task, soak.drop(task)


def judged(task, outcomes):
    tally = Tally()
    judge(task, outcomes, tally)
    return tally


def test_twenty_bodies_pass():
    told = []
    tally = soak.soak(DROPS, 20, 2, lambda found: told.append(found.drops))
    assert (tally.drops, tally.unsettled, tally.faults) == (DROPS, 0, [])
    assert tally.passed
    assert tally.lowest > -ROUNDING
    assert tally.closest > 0.0
    assert told == sorted(told) and told[-1] == DROPS


def test_the_drops_are_spread_evenly():
    found = list(soak.tasks(1000, 7))
    assert sum(task.drops for task in found) == 1000
    assert {task.drops for task in found} == {47, 48}
    assert len({task.part.digest for task in found}) == 7
    assert len({task.seed for task in found}) == len(found) == 21


def test_a_good_outcome_passes(sample):
    assert judged(*sample).passed


@pytest.mark.parametrize(("name", "value", "word"), [
    ("energy_left", np.nan, "NaN"), ("energy_left", -1.0, "energy"),
    ("energy_left", 9.0, "energy"), ("pose", 99, "no stable pose"), ("seconds", np.inf, "NaN"),
])
def test_faults_are_noticed(sample, name, value, word):
    task, outcomes = sample
    wrong = getattr(outcomes, name).copy()
    wrong[7] = value
    tally = judged(task, replace(outcomes, **{name: wrong}))
    assert any(word in fault for fault in tally.faults)
    assert not tally.passed
    assert "FAULT" in report(tally, 1.0)


def test_unsettled_drops_and_exceptions_fail(sample):
    task, outcomes = sample
    pose = outcomes.pose.copy()
    pose[3] = -1
    assert judged(task, replace(outcomes, pose=pose)).unsettled == 1
    assert not judged(task, replace(outcomes, pose=pose)).passed
    assert "ZeroDivisionError" in judged(task, ZeroDivisionError("by zero")).faults[0]


def test_the_exit_status(capsys, monkeypatch):
    assert soak.main(["--drops", "300", "--bodies", "2", "--workers", "1"]) == 0
    shown = capsys.readouterr()
    assert "300 drops in" in shown.out and "passed" in shown.out
    assert "300 drops, 0 unsettled" in shown.err
    monkeypatch.setattr(soak, "drop", lambda task: ValueError("broken"))
    assert soak.main(["--drops", "30", "--bodies", "2"]) == 1
    with pytest.raises(SystemExit):
        soak.main(["--drops", "0"])
