"""The command `bag`: what it prints, writes and refuses."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
import time

import pytest

from ros_pose_stats.cli import main
from ros_pose_stats.commands import progress_bar
from tests.recording.analysis.bags import run_of_a_node, write_recorded, write_run
from tests.recording.analysis.messages import counts, event, result
from tests.running import ROOT, command, strict_json


@pytest.fixture
def log(tmp_path):
    """A log directory with one run, which was killed while its second job ran."""
    write_run(tmp_path / "log", closed=False)
    return tmp_path / "log"


def printed(capsys, *arguments):
    assert main(["bag", *map(str, arguments)]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    return shown.out


class TestReport:
    def test_rows_name_the_scene_where_there_are_several(self, tmp_path, capsys):
        count = (51, 25, 12, 6, 2)
        write_run(tmp_path, [
            ("pose_statistics", result(0.0, method="simulation", count=count)),
            ("pose_statistics", result(1.0, method="simulation", count=count, drop_height=0.1)),
            ("pose_statistics", result(2.0, method="split", drop_height=0.1, error=0.01)),
            ("pose_statistics", result(3.0, method="meae"))])
        lines = printed(capsys, tmp_path).splitlines()
        rows = [line.split()[-1] for line in lines if "02:40:0" in line and "simul" in line]
        assert rows == ["#1", "#2"]
        lines = [line.strip() for line in lines]
        assert "#1: released 400 mm above a frictionless plate, restitution 0.5" in lines
        assert "#2: released 100 mm above a frictionless plate, restitution 0.5" in lines
        assert "estimates against simulation #1" in lines
        against = [line.split()[:2] for line in lines if line.endswith(" chance")]
        assert ["split", "#2"] in against and ["meae", "#1"] not in against

    def test_it_tells_everything(self, log, capsys):
        text = printed(capsys, log)
        for said in ("== clamp (digest 3fa9c1d23fa9, radius 20 mm)",
                     "5 poses in 4 groups at cluster_tolerance 0.005 and round_sides 192, by "
                     "simulation, 2000 drops",
                     "4 results by combined, simulation, meae",
                     "2 accepted, 1 done, 0 cancelled, 0 failed, 1 unfinished",
                     "estimates against simulation", "480 parts in stable poses",
                     "unclassified: 10 of 490, 2.04 %", "LOW_DROP: released low.",
                     "was never closed", "within chance", "beyond chance"):
            assert said in text

    def test_it_fits_a_hundred_columns(self, log, capsys):
        lines = printed(capsys, log).splitlines()
        assert max(len(line) for line in lines if str(log) not in line) <= 100

    def test_it_fits_whatever_there_is(self, tmp_path, capsys):
        long = "a_very_long_name_of_something_" * 4
        methods = ("area", "csae", "adre", "qse", "pqse", "nqse", "eae", "meae", "combined")
        write_run(tmp_path, [
            *(("answers", result(k, method=name, part_id=long))
              for k, name in enumerate(methods)),
            *(("answers", result(20 + k, method="simulation", restitution=0.1 * k, part_id=long,
                                 count=(51234567, 25234567, 12234567, 6234567, 2234567)))
              for k in range(4)),
            ("job_events", event(30.0, "QUEUED", "pose_stats_20260202T024000_000000_4711_000123",
                                 drops=10_000_000, part_id=long)),
            ("job_events", event(30.0, "FAILED", "pose_stats_20260202T024000_000000_4711_000123",
                                 drops=10_000_000, part_id=long, message="no memory " * 20)),
            ("pose_counts", counts(40.0, (4000000, 20, 10, 4, 3), plate=long, part_id=long)),
            ("pose_counts", counts(41.0, (4000000, 20), plate="\x1b[31m\n", part_id=long,
                                   cluster_tolerance=0.01)),
        ])
        text = printed(capsys, tmp_path)
        names = [line for line in text.splitlines() if len(line) > 100]
        assert all(str(tmp_path) in line for line in names)
        assert "\x1b" not in text
        assert "--json and --csv also list" in text
        assert "not compared" in text
        assert "simulation #4" in text

    def test_many_results_show_the_first_some_and_the_last(self, tmp_path, capsys):
        write_run(tmp_path, [("pose_statistics", result(float(k))) for k in range(50)])
        lines = printed(capsys, tmp_path).splitlines()
        rows = [line.split()[0] for line in lines if " combined " in line and ":" in line
                and "by combined" not in line]
        assert rows[0] == "1" and rows[-1] == "50" and len(rows) == 12
        assert "  38 more in between" in lines

    def test_poses_that_were_not_foreseen(self, tmp_path, capsys):
        write_run(tmp_path, [
            ("pose_statistics", result(1.0, (0.6, 0.25, 0.15, 0.0, 0.0))),
            ("pose_statistics", result(2.0, method="simulation", count=(60, 25, 15, 0, 0))),
            ("pose_counts", counts(3.0, (60, 25, 12, 3, 0)))])
        text = printed(capsys, tmp_path)
        assert "3 counted in poses that combined gives the probability 0" in text
        assert "3 counted in poses that no drop of simulation came to" in text

    def test_counts_alone(self, tmp_path, capsys):
        write_run(tmp_path, [("pose_counts", counts(1.0, (5, 6)))])
        text = printed(capsys, tmp_path)
        assert "clamp: camera counts alone" in text
        assert "no result of this part" in text


class TestProgress:
    def test_a_terminal_is_told_and_wiped(self, log, capsys, monkeypatch):
        monkeypatch.setattr(progress_bar, "FIRST_AFTER", -1.0)
        monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
        assert main(["bag", str(log)]) == 0
        shown = capsys.readouterr()
        assert "0 of 0 MB read, " in shown.err and " left" in shown.err
        assert shown.err.endswith(" \r")
        assert "\r" not in shown.out

    def test_sizes_and_time_left(self, monkeypatch):
        stream = io.StringIO()
        monkeypatch.setattr(stream, "isatty", lambda: True)
        bar = progress_bar.ProgressBar(stream)
        monkeypatch.setattr(bar, "_next", 0.0)
        monkeypatch.setattr(bar, "_begin", time.monotonic() - 9.5)
        bar.show_bytes(100_400_000, 500_000_000)
        assert stream.getvalue() == "\r[####....................] 100 of 500 MB read, 38 s left"


class TestJson:
    def test_strict_and_complete(self, log, capsys):
        found = strict_json(printed(capsys, log, "--json"))
        assert found["files"][0]["state"] == "open"
        assert found["messages"]["PoseStatistics"] == 5
        (part,) = found["parts"]
        (numbering,) = part["numberings"]
        for one in (numbering, *part["jobs"], *part["counts"]):
            assert (one["cluster_tolerance"], one["round_sides"]) == (0.005, 192)
        assert [one["method"] for one in numbering["results"]] == [
            "combined", "simulation", "meae", "simulation"]
        assert numbering["results"][0]["largest_change"] is None
        assert numbering["results"][0]["time"] == 1_770_000_000.0
        simulation = numbering["predictions"][1]
        assert simulation["poses"][0]["count"] == 1120
        assert numbering["simulations"][0]["simulation"] == 1
        assert [one["prediction"] for one in numbering["simulations"][0]["estimates"]] == [0, 2]
        assert part["job_counts"] == {"accepted": 2, "done": 1, "cancelled": 0, "failed": 0,
                                      "unfinished": 1}
        (counted,) = part["counts"]
        assert counted["compared"] is True
        assert counted["count"] == [276, 118, 62, 20, 4]
        assert counted["unclassified"] == 10
        test = counted["predictions"][0]["by_pose"]
        assert test["degrees_of_freedom"] == 4
        assert 0.0 < test["p_value"] < 1.0

    def test_too_few_is_null_and_said(self, tmp_path, capsys):
        write_run(tmp_path, [("pose_statistics", result(1.0)),
                             ("pose_counts", counts(2.0, (2, 1, 0, 0, 0)))])
        found = strict_json(printed(capsys, tmp_path, "--json"))
        test = found["parts"][0]["counts"][0]["predictions"][0]["by_pose"]
        assert test["p_value"] is None and test["too_few"] is True


class TestCsv:
    @pytest.fixture
    def written(self, tmp_path, capsys):
        """Writes the tables of a log directory and reads them."""
        def write(log):
            folder = tmp_path / "new" / "tables"
            text = printed(capsys, log, "--csv", folder)
            found = {}
            for path in folder.iterdir():
                assert str(path) in text.splitlines()
                with path.open(newline="", encoding="utf-8") as stream:
                    found[path.name] = list(csv.DictReader(stream))
            return found

        return write

    @pytest.fixture
    def tables(self, written, log):
        return written(log)

    def test_the_files(self, tables):
        assert set(tables) == {"files.csv", "poses.csv", "answers.csv", "jobs.csv", "counts.csv",
                               "comparison.csv"}

    def test_values_come_back(self, tables):
        assert [float(row["probability"]) for row in tables["poses.csv"][:5]] == [
            0.55, 0.25, 0.12, 0.06, 0.02]
        assert [row["height_m"] for row in tables["poses.csv"][:2]] == ["0.005", "0.006"]
        answers = tables["answers.csv"][::5]  # of five poses
        assert [row["result"] for row in answers] == ["1", "2", "3", "4"]
        assert [row["drops"] for row in answers] == ["0", "100", "0", "2000"]
        assert tables["answers.csv"][0]["time_utc"] == "2026-02-02T02:40:00.000000000Z"
        assert tables["answers.csv"][0]["expected_error"] == ""
        assert [row["state"] for row in tables["jobs.csv"]] == ["done", "running"]
        for name in ("poses", "answers", "jobs", "counts", "comparison"):
            assert {(row["cluster_tolerance"], row["round_sides"])
                    for row in tables[f"{name}.csv"]} == {("0.005", "192")}
        counted = {row["pose"]: row["count"] for row in tables["counts.csv"]}
        assert counted == {"0": "276", "1": "118", "2": "62", "3": "20", "4": "4",
                           "unclassified": "10"}
        kinds = {(row["counts_of"], row["method"], row["by"])
                 for row in tables["comparison.csv"]}
        assert ("camera", "simulation", "group") in kinds
        assert ("simulation", "meae", "pose") in kinds

    def test_answers_join_poses(self, written, tmp_path):
        simulated = {"method": "simulation", "count": (5, 3, 2, 0, 0)}
        write_run(tmp_path, [("pose_statistics", one) for one in (
            result(1.0), result(1.0, method="meae"), result(2.0, (0.5, 0.3, 0.1, 0.1, 0.0)),
            result(3.0, **simulated), result(4.0, **simulated, restitution=0.2),
            result(5.0, method="simulation", count=(50, 30, 20, 0, 0)),
            result(6.0, (0.7, 0.3), cluster_tolerance=0.01), result(6.0, part_digest="b" * 64),
            result(6.0, (0.5, 0.3, 0.2), round_sides=0),
            result(7.0, method="meae", drop_height=float("nan"), restitution=0.1),
            result(8.0, method="meae", drop_height=float("nan"), restitution=0.3))])
        tables = written(tmp_path)
        columns = ("part_id", "part_digest", "cluster_tolerance", "round_sides", "prediction",
                   "pose")
        poses = {tuple(row[name] for name in columns): row for row in tables["poses.csv"]}
        assert len(poses) == len(tables["poses.csv"])
        answers = {tuple(row[name] for name in (*columns, "result")): row
                   for row in tables["answers.csv"]}
        assert len(answers) == len(tables["answers.csv"]) == 9 * 5 + 3 + 2
        joined = [(row, poses[key[:-1]]) for key, row in answers.items()]
        assert {tuple(row[name] for name in columns) for row, _ in joined} == poses.keys()
        for answer, pose in joined:
            assert (answer["method"], answer["drop_height_m"]) == (
                pose["method"], pose["drop_height_m"])
        # Of every prediction the answer that knows most is among those joined to it.
        told = {key: [one["probability"] for one, other in joined if other is pose]
                for key, pose in poses.items()}
        assert all(pose["probability"] in told[key] for key, pose in poses.items())

    def test_again_replaces(self, log, tmp_path, capsys):
        folder = tmp_path / "tables"
        printed(capsys, log, "--csv", folder)
        first = (folder / "poses.csv").read_bytes()
        found = strict_json(printed(capsys, log, "--csv", folder, "--json"))
        assert len(found["csv"]) == 6
        assert (folder / "poses.csv").read_bytes() == first
        assert len(list(folder.iterdir())) == 6


class TestRefusals:
    @pytest.mark.parametrize("what", ["nowhere", "empty", "foreign", "file_as_csv"])
    def test_one_line_and_status_2(self, tmp_path, log, what, capsys):
        (tmp_path / "empty").mkdir()
        write_run(tmp_path / "foreign", [])
        (tmp_path / "file").touch()
        arguments = {"file_as_csv": [log, "--csv", tmp_path / "file"]}.get(
            what, [log, tmp_path / what] if what != "foreign" else [tmp_path / what])
        assert main(["bag", *map(str, arguments)]) == 2
        shown = capsys.readouterr()
        assert shown.out == ""
        assert shown.err.count("\n") == 1
        assert shown.err.startswith("ros_pose_stats: expected ")

    def test_in_a_process_of_its_own(self, tmp_path):
        done = command("bag", tmp_path / "nowhere")
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.count("\n") == 1


def test_it_works_where_ros_cannot_be_imported(tmp_path):
    write_recorded(tmp_path / "bag", run_of_a_node())
    code = ("import sys\n"
            "class Refuse:\n"
            "    def find_spec(self, name, path=None, target=None):\n"
            "        if name.split('.')[0] in ('rclpy', 'std_msgs', 'ros_pose_stats_msgs', "
            "'rosbags', 'pandas'):\n"
            "            raise ImportError(name)\n"
            "sys.meta_path.insert(0, Refuse())\n"
            "from ros_pose_stats.cli import main\n"
            f"status = main(['bag', {str(tmp_path / 'bag')!r}, '--json'])\n"
            "assert 'matplotlib' not in sys.modules and 'numba' not in sys.modules\n"
            "sys.exit(status)\n")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["parts"][0]["part_id"] == "clamp"
