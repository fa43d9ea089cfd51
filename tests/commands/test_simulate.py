"""`simulate`: the table, the JSON object, the bar, the refusals and Ctrl-C."""

from __future__ import annotations

import io
import json
import math
import os
import pty
import signal
import subprocess
import sys

import pytest
from scipy import stats

from ros_pose_stats import cli, load_part, shapes, simulate
from ros_pose_stats.commands.progress_bar import ProgressBar, bar_line, drops_done
from ros_pose_stats.records import DropProgress
from tests.bodies import write_stl
from tests.commands.pose_tables import table_head, table_rows
from tests.commands.test_estimate import POSE_KEYS, STATISTICS_KEYS
from tests.running import ROOT, answer, command, complaints, strict_json


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A box 20 x 30 x 40, in millimetres."""
    path = tmp_path_factory.mktemp("parts") / "box.stl"
    write_stl(path, shapes.box(20.0, 30.0, 40.0))
    return path


def printed(capsys, *arguments):
    """Standard output of a run in this process that must succeed."""
    assert cli.main(["simulate", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert complaints(err) == []
    return out


def progress(**changes):
    """A state of a run."""
    state = {"drops": 250, "bound": 1000, "unsettled": 0, "expected_error": 0.02,
             "error_bound": 0.04,
             "target_error": 0.0, "seconds": 0.5, "statistics": None, **changes}
    return DropProgress(**state)


class TestTable:
    def test_it_says_what_was_done(self, box):
        lines = answer("simulate", box, "--unit", "mm", "--drops", 300, "--seed", 5).splitlines()
        assert lines[:2] == [
            "box: released 539 mm above a frictionless plate, restitution 0.5",
            "6 stable poses in 3 groups, 12 triangles, 20 x 30 x 40 mm"]
        assert lines[4] == "300 drops, 0 unsettled, seed 5,"
        assert "computed in" in lines[-1]

    def test_the_columns_are_those_of_an_estimate_and_the_drops(self, box, capsys):
        simulated = printed(capsys, box, "--unit", "mm", "--drops", 300, "--seed", 5)
        assert cli.main(["estimate", str(box), "--unit", "mm"]) == 0
        estimated = capsys.readouterr().out
        names = ["poses", "number", "group", "probability", "90 % interval", "drops", "height",
                 "barrier", "margin", "down"]
        assert table_head(simulated) == names
        assert table_head(estimated) == [name for name in names if name != "drops"]
        downs = [{row["poses"]: row["down"] for row in table_rows(text)}
                 for text in (simulated, estimated)]
        assert downs[0] == downs[1]
        assert downs[0]["0, 1"] == "(-1.000, +0.000, +0.000)"

    def test_the_values_are_those_of_the_json_object(self, box, capsys):
        arguments = (box, "--unit", "mm", "--drops", 300, "--seed", 5)
        rows = table_rows(printed(capsys, *arguments, "--each"))
        poses = strict_json(printed(capsys, *arguments, "--json"))["poses"]
        for row, pose in zip(rows, poses, strict=True):
            assert row["probability"].startswith(f"{100.0 * pose['probability']:.2f}%")
            assert {name: row[name] for name in row if name not in ("probability", "down")} == {
                "pose": str(pose["index"]), "group": str(pose["group"]),
                "90 % interval": f"{100.0 * pose['probability_low']:.2f} - "
                                 f"{100.0 * pose['probability_high']:.2f}",
                "drops": str(pose["count"]), "height": f"{1e3 * pose['height']:.4g}",
                "barrier": f"{1e3 * pose['barrier']:.4g}",
                "margin": f"{math.degrees(pose['margin']):.2f}"}

    def test_drops_of_like_poses_are_added(self, box, capsys):
        arguments = (box, "--unit", "mm", "--drops", 300, "--seed", 5)
        poses = strict_json(printed(capsys, *arguments, "--json"))["poses"]
        for row in table_rows(printed(capsys, *arguments)):
            count = sum(pose["count"] for pose in poses if str(pose["group"]) == row["group"])
            assert row["drops"] == str(count)
            bounds = stats.beta(count + 0.5, 300 - count + 0.5).ppf([0.05, 0.95])
            assert row["90 % interval"] == " - ".join(f"{100.0 * one:.2f}" for one in bounds)


class TestJson:
    def test_the_keys_of_the_contract(self, box, capsys):
        found = strict_json(printed(capsys, box, "--unit", "mm", "--drops", 200, "--json"))
        assert set(found) == STATISTICS_KEYS
        assert set(found["poses"][0]) == POSE_KEYS
        assert found["method"] == "simulation"
        assert found["drops"] == 200
        assert sum(pose["count"] for pose in found["poses"]) + found["unsettled"] == 200

    def test_it_is_the_library_s_answer_whatever_the_workers(self, box, capsys):
        found = strict_json(printed(capsys, box, "--unit", "mm", "--drops", 400, "--seed", 9,
                                    "--restitution", 0.2, "--drop-height", 0.1, "--workers", 3,
                                    "--sampling", "lattice", "--json"))
        same = simulate(load_part(box, unit="mm"), 400, 0.2, 9, 0.1, workers=1,
                        sampling="lattice")
        assert [pose["count"] for pose in found["poses"]] == [pose.count for pose in same.poses]
        assert found["expected_error"] == pytest.approx(same.expected_error)
        assert found["seed"] == 9

    def test_a_fresh_seed_is_reported_and_repeats_the_run(self, box, capsys):
        first = strict_json(printed(capsys, box, "--drops", 100, "--unit", "mm", "--json"))
        again = strict_json(printed(capsys, box, "--drops", 100, "--unit", "mm", "--json",
                                    "--seed", first["seed"]))
        assert first["poses"] == again["poses"]

    def test_a_target_ends_the_run_early(self, box, capsys):
        found = strict_json(printed(capsys, box, "--unit", "mm", "--target-error", 0.02,
                                    "--json"))
        assert found["drops"] < 10_000
        assert found["expected_error"] <= 0.02


class TestWarnings:
    def test_a_height_in_the_wrong_unit(self, box, capsys):
        found = strict_json(printed(capsys, box, "--unit", "mm", "--drops", 20, "--drop-height",
                                    540, "--json"))
        assert any(line.startswith("HEIGHT_SUSPECT") for line in found["warnings"])

    @pytest.mark.parametrize(("target", "missed"), [(0.001, True), (0.1, False), (0.0, False)])
    def test_a_target_out_of_reach(self, box, capsys, target, missed):
        found = strict_json(printed(capsys, box, "--unit", "mm", "--drops", 200,
                                    "--target-error", target, "--json"))
        assert missed == any(line.startswith("TARGET_MISSED") for line in found["warnings"])


class TestRefusals:
    @pytest.mark.parametrize(("option", "value", "said"), [
        ("--drops", "0", "drops"), ("--restitution", "1", "restitution"),
        ("--drop-height", "-1", "drop height"), ("--seed", "-1", "seed"),
        ("--workers", "0", "workers"), ("--target-error", "1", "target error"),
        ("--target-error", "nan", "target error"), ("--sampling", "even", "sampling"),
        ("--drops", "many", "drops")])
    def test_one_line_and_status_2(self, box, capsys, option, value, said):
        try:
            status = cli.main(["simulate", str(box), "--unit", "mm", option, value])
        except SystemExit as refusal:
            status = refusal.code
        out, err = capsys.readouterr()
        assert (status, out) == (2, "")
        (line,) = complaints(err)
        assert said in line


class TestInterrupt:
    def interrupted(self, box, *options):
        """A long run, watched on a terminal, that gets Ctrl-C once its bar is there."""
        terminal, stderr = pty.openpty()
        running = subprocess.Popen(
            [sys.executable, "-m", "ros_pose_stats", "simulate", str(box), "--unit", "mm",
             "--drops", "100000000", "--workers", "2", *options],
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
        return running.returncode, out

    def test_the_object_so_far(self, box):
        status, out = self.interrupted(box, "--json", "--seed", "3")
        assert status == 130
        found = strict_json(out)
        assert found["interrupted"] is True
        assert 0 < found["drops"] < 100_000_000
        assert sum(pose["count"] for pose in found["poses"]) == found["drops"]

    def test_the_table_so_far(self, box):
        status, out = self.interrupted(box)
        assert status == 130
        assert "interrupted after" in out.splitlines()[-1]


class TestProgress:
    def test_drops_rate_time_left_and_error(self):
        line = bar_line(*drops_done(progress()))
        assert line == ("[#####..................] 250 of 1000 drops, 500/s, 2 s left, "
                        "error 2.00 points")

    def test_a_target_shortens_the_time_left(self):
        line = bar_line(*drops_done(progress(target_error=0.02)))
        assert "2 s left" in line  # four times the drops in all, the bound is at 1000
        assert "1 s left" in bar_line(*drops_done(progress(bound=10 ** 9, target_error=0.0284)))

    def test_nothing_settled_yet(self):
        line = bar_line(*drops_done(progress(expected_error=math.nan, drops=0)))
        assert "? left" in line
        assert "error" not in line

    @pytest.mark.parametrize("columns", [30, 60, 80, 200])
    def test_it_fits_the_terminal(self, columns):
        for bound in (1000, 10 ** 9):
            line = bar_line(*drops_done(progress(bound=bound)), columns)
            assert len(line) < columns
            assert "250 of" in line

    def test_long_times_are_readable(self):
        assert "2 h 46 min left" in bar_line(*drops_done(progress(bound=5_000_250)))

    def test_it_draws_on_a_terminal_and_wipes_itself_away(self, monkeypatch):
        stream = io.StringIO()
        monkeypatch.setattr(stream, "isatty", lambda: True)
        with ProgressBar(stream) as bar:
            monkeypatch.setattr(bar, "_next", 0.0)
            bar.show(progress())
        assert "250 of 1000 drops" in stream.getvalue()
        assert stream.getvalue().endswith(" \r")

    def test_it_is_silent_elsewhere(self):
        stream = io.StringIO()
        with ProgressBar(stream) as bar:
            bar.show(progress())
        assert stream.getvalue() == ""

    def test_json_is_alone_on_standard_output(self, box):
        done = command("simulate", box, "--unit", "mm", "--drops", 50, "--json")
        assert json.loads(done.stdout)["drops"] == 50
