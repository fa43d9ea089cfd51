"""Parts that contradicted an estimate, as training reads them."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, shapes, simulate
from ros_pose_stats.recording.conflicts import keep_conflict
from training.conflicts import main, score_cases

PART = part_from_mesh(*shapes.box(20.0, 30.0, 41.0), unit="mm", part_id="crate")


@pytest.fixture
def folder(tmp_path):
    found = simulate(PART, 400, 0.4, 3, 0.3, workers=1)
    keep_conflict(tmp_path, PART, replace(found, warnings=("CONFLICT: one.",)))
    return tmp_path


def test_a_case_is_scored_against_what_the_weights_say_now(folder):
    (score,) = score_cases(folder)
    found = estimate(PART, "split", restitution=0.4, drop_height=0.3)
    by_index = sorted(found.poses, key=lambda pose: pose.index)
    share = score.case.counts / 400
    apart = np.abs([pose.probability for pose in by_index] - share)
    assert score.largest == pytest.approx(apart.max())
    assert score.expected == found.expected_error
    assert score.error ** 2 == pytest.approx(
        max(np.mean(apart ** 2 - share * (1.0 - share) / 399), 0.0))


def test_the_command_prints_a_row_each(folder, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["conflicts", str(folder)])
    main()
    assert [line.split()[:4] for line in capsys.readouterr().out.splitlines()[2:]] == [
        ["crate", "6", "400", "0.4"]]
