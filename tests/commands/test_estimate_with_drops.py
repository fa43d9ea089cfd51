"""`estimate --method hybrid` and `auto`: answers, options and refusals."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys

import pytest

from ros_pose_stats import auto, cli, hybrid, load_part, shapes
from ros_pose_stats.planning import confidence
from ros_pose_stats.recording.conflicts import read_conflicts
from tests.bodies import write_stl
from tests.commands.test_estimate import POSE_KEYS, STATISTICS_KEYS
from tests.running import ROOT, complaints, strict_json


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A box 20 x 30 x 40, in millimetres."""
    return write_stl(tmp_path_factory.mktemp("parts") / "box.stl", shapes.box(20.0, 30.0, 40.0))


def printed(capsys, *arguments):
    assert cli.main(["estimate", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert complaints(err) == []
    return out


def test_hybrid_is_the_library_s_answer(box, capsys):
    found = strict_json(printed(capsys, box, "--unit", "mm", "--method", "hybrid", "--drops", 120,
                                "--seed", 9, "--restitution", 0.3, "--workers", 2, "--json"))
    assert set(found) == STATISTICS_KEYS and set(found["poses"][0]) == POSE_KEYS
    same = hybrid(load_part(box, unit="mm"), 120, 0.3, 9)
    assert [pose["probability"] for pose in found["poses"]] == [
        pose.probability for pose in same.poses]
    assert (found["method"], found["drops"], found["choice"]) == ("hybrid", 120, "")


def test_auto_says_why(box, capsys):
    arguments = (box, "--unit", "mm", "--method", "auto", "--seed", 9)
    found = strict_json(printed(capsys, *arguments, "--target-error", 0.02, "--json"))
    same = auto(load_part(box, unit="mm"), 0.02, seed=9)
    assert (found["method"], found["drops"], found["choice"]) == (
        same.method, same.drops, same.choice)
    table = printed(capsys, *arguments, "--target-error", 0.02)
    assert same.choice in table and f"method {same.method}" in table
    assert "no target error" in printed(capsys, *arguments)


def test_a_contradicted_estimate_is_kept_for_training(box, capsys, tmp_path, monkeypatch):
    true = confidence.estimated
    arguments = (box, "--unit", "mm", "--method", "hybrid", "--drops", 400, "--seed", 9, "--json",
                 "--keep-conflicts", tmp_path / "kept")
    printed(capsys, *arguments)
    assert not (tmp_path / "kept").exists()
    monkeypatch.setattr(confidence, "estimated", lambda *given: true(*given)[::-1].copy())
    found = strict_json(printed(capsys, *arguments))
    assert found["method"] == "simulation"
    assert any(line.startswith("CONFLICT: ") for line in found["warnings"])
    (case,) = read_conflicts(tmp_path / "kept")
    assert case.counts.tolist() == [pose["count"] for pose in sorted(
        found["poses"], key=lambda pose: pose["index"])]


@pytest.mark.parametrize(("options", "said"), [
    (("--method", "split", "--drops", "5"), "--drops"),
    (("--method", "split", "--seed", "5"), "--seed"),
    (("--method", "split", "--workers", "5"), "--workers"),
    (("--method", "split", "--keep-conflicts", "there"), "--keep-conflicts"),
    (("--method", "split", "--target-error", "0.1"), "--target-error"),
    (("--method", "all", "--drops", "5"), "--drops"),
    (("--method", "auto", "--target-error", "2"), "target error"),
    (("--method", "hybrid", "--drops", "0"), "drops"),
    (("--method", "hybrid", "--seed", "-1"), "seed"),
])
def test_refused_in_one_line(box, capsys, options, said):
    assert cli.main(["estimate", str(box), "--unit", "mm", *options]) == 2
    out, err = capsys.readouterr()
    (line,) = complaints(err)
    assert said in line and out == ""


def test_an_interrupt_reports_what_has_been_done(box):
    terminal, stderr = pty.openpty()
    running = subprocess.Popen(
        [sys.executable, "-m", "ros_pose_stats", "estimate", str(box), "--unit", "mm", "--method",
         "auto", "--target-error", "0.00001", "--seed", "3", "--json"],
        stdout=subprocess.PIPE, stderr=stderr, text=True, cwd=ROOT)
    os.close(stderr)
    try:
        shown = ""
        while "left, error" not in shown:
            shown += os.read(terminal, 4096).decode()
        running.send_signal(signal.SIGINT)
        out, _ = running.communicate(timeout=20.0)
    finally:
        running.kill()
        os.close(terminal)
    assert running.returncode == 130
    found = strict_json(out)
    assert found["interrupted"] is True and found["drops"] > 0 and found["choice"]
