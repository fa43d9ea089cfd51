"""`benchmark table|prisms|chart|figures`: outputs, refusals, closed pipes and Ctrl-C."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from ros_pose_stats import cli
from ros_pose_stats.study import accuracy_documents
from ros_pose_stats.study import chart as charts
from ros_pose_stats.study.chart.methods import Effort
from ros_pose_stats.study.dataset import DatasetSpec, make_dataset, on_threads
from tests.bodies import METHODS
from tests.running import ROOT, command, complaints, strict_json


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """24 bodies, 150 drops of each at two restitutions."""
    file = tmp_path_factory.mktemp("datasets") / "small.npz"
    assert make_dataset(file, DatasetSpec(24, 150, (0.3, 0.7), seed=5), on_threads(1))
    return file


@pytest.fixture
def quick_chart(monkeypatch):
    """A plan of a moment."""
    monkeypatch.setattr(charts, "QUICK", (charts.Plan(0, 0, 0, Effort(1, 10, (10,)), 2, 0),))


def run(*arguments):
    return cli.main(["benchmark", *map(str, arguments)])


def refusal(capsys, *arguments):
    """The one line by which arguments are refused."""
    assert run(*arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    (line,) = complaints(err)
    assert line.startswith("ros_pose_stats: expected ")
    return line


class TestTable:
    def test_json(self, small, capsys):
        assert run("table", "--dataset", small, "--json", "--no-rerun") == 0
        (found,) = strict_json(capsys.readouterr().out)
        assert found["spec"]["bodies"] == 24
        assert found["outliers"] == []
        assert [one["name"] for one in found["estimators"]] == list(METHODS)
        assert found["estimators"][0]["by_restitution"].keys() == {"0.3", "0.7"}
        assert found["first_drops"] == 100

    def test_several_datasets_one_after_the_other(self, small, capsys):
        assert run("table", "--dataset", small, small, "--no-rerun") == 0
        out, err = capsys.readouterr()
        assert out.count("### Shift 0 (inertia), 24 bodies, 150 drops of each") == 2
        assert complaints(err) == []

    @pytest.mark.long
    def test_outliers_are_dropped_again(self, small, capsys):
        assert run("table", "--dataset", small) == 0
        out = capsys.readouterr().out
        assert "10000 drops" in out
        assert out.count("| body ") == 3

    @pytest.mark.long
    def test_a_reference_dataset_by_its_shift(self, capsys):
        assert run("table", "--shift", "0.65", "--shift-moment", "second", "--no-rerun") == 0
        assert "### Shift 0.65 (second), 1057 bodies, 1000 drops" in capsys.readouterr().out

    def test_without_options_all_reference_datasets_are_meant(self, monkeypatch, capsys):
        seen = []
        monkeypatch.setattr("ros_pose_stats.study.dataset.shipped_datasets",
                            lambda: seen.append("all") or [])
        assert run("table") == 0
        assert seen == ["all"]


@pytest.mark.long
class TestChart:
    def test_files_and_json(self, small, quick_chart, tmp_path, capsys):
        stem = tmp_path / "new" / "chart_0.3"
        assert run("chart", "--dataset", small, "--quick", "-o", stem, "--json") == 0
        out, err = capsys.readouterr()
        written = tmp_path / "new" / "chart_0.3.json"
        assert strict_json(out) == strict_json(written.read_text())
        assert {one.suffix for one in written.parent.iterdir()} == {".json", ".png", ".svg"}
        assert f"wrote {written}" in err

    @pytest.mark.long
    def test_an_ending_of_a_figure_is_no_part_of_the_name(self, small, quick_chart, tmp_path,
                                                          capsys):
        assert run("chart", "--dataset", small, "--quick", "-o", tmp_path / "chart.png") == 0
        assert sorted(one.name for one in tmp_path.iterdir()) == [
            "chart.json", "chart.png", "chart.svg"]
        assert "| combined " in capsys.readouterr().out


class TestPrisms:
    @pytest.mark.long
    def test_figures(self, tmp_path, capsys):
        assert run("prisms", "--drops", 5, "--dice-drops", 5, "--json",
                   "-o", tmp_path / "prisms") == 0
        assert strict_json(capsys.readouterr().out)["stopped"] is False
        assert sorted(one.name for one in tmp_path.iterdir()) == ["prisms.png", "prisms.svg"]


class TestFigures:
    def test_measured_then_written(self, tmp_path, monkeypatch, capsys):
        monkeypatch.setattr(accuracy_documents, "measure_documents",
                            lambda quick, say: ("found", quick))
        monkeypatch.setattr(accuracy_documents, "write_documents",
                            lambda found, folder: [folder / f"{found[0]} {found[1]}"])
        assert run("figures", "--quick", "-o", tmp_path / "docs") == 0
        assert f"wrote {tmp_path / 'docs'}/found True" in capsys.readouterr().err


class TestRefusals:
    def test_a_shift_that_does_not_come_with_the_package(self, capsys):
        line = refusal(capsys, "table", "--shift", "0.5")
        assert "got 0.5 (inertia)" in line
        assert "ros_pose_stats dataset" in line
        assert "--dataset" in line

    def test_a_moment_without_a_shift(self, capsys):
        assert "--shift beside" in refusal(capsys, "table", "--shift-moment", "second")

    @pytest.mark.parametrize("kind", ["table", "chart"])
    def test_a_file_that_is_not_there(self, kind, tmp_path, capsys):
        assert "nothing.npz" in refusal(capsys, kind, "--dataset", tmp_path / "nothing.npz")

    def test_a_file_of_another_kind(self, tmp_path, capsys):
        (tmp_path / "text.npz").write_text("no archive")
        refusal(capsys, "table", "--dataset", tmp_path / "text.npz")

    def test_one_drop_of_each_tells_no_noise(self, tmp_path, capsys):
        file = tmp_path / "one.npz"
        make_dataset(file, DatasetSpec(2, 1, (0.5,)), on_threads(1))
        assert "2 settled drops" in refusal(capsys, "table", "--dataset", file, "--no-rerun")

    @pytest.mark.parametrize("kind", ["chart", "prisms", "figures"])
    def test_unwritable_output_before_anything_is_measured(self, kind, tmp_path, capsys,
                                                           monkeypatch):
        for where in ("study.chart.chart", "study.prisms.prisms",
                      "study.accuracy_documents.measure_documents"):
            monkeypatch.setattr(f"ros_pose_stats.{where}", lambda *_, **__: pytest.fail("it ran"))
        (tmp_path / "file").write_text("")
        line = refusal(capsys, kind, "-o", tmp_path / "file" / "deep" / "name")
        assert "name another one with -o" in line

    @pytest.mark.parametrize("output", ["", ".", "..", "folder/"])
    def test_a_stem_without_a_name(self, output, capsys):
        assert "beginning of a file name" in refusal(capsys, "chart", "--quick", "-o", output)

    @pytest.mark.parametrize("arguments", [("benchmark",), ("benchmark", "speed"),
                                           ("benchmark", "table", "--shift", "much"),
                                           ("benchmark", "table", "--dataset"),
                                           ("benchmark", "figures", "--json")])
    def test_unknown_words_take_one_line(self, arguments, capsys):
        with pytest.raises(SystemExit) as status:
            cli.main(list(arguments))
        assert status.value.code == 2
        assert len(capsys.readouterr().err.splitlines()) == 1


class TestProcesses:
    def test_json_is_alone_on_standard_output(self, small):
        done = command("benchmark", "table", "--dataset", small, "--json", "--no-rerun")
        assert done.returncode == 0
        assert len(strict_json(done.stdout)) == 1
        assert complaints(done.stderr) == []

    def test_a_reader_that_goes_away(self, small):
        with subprocess.Popen([sys.executable, "-m", "ros_pose_stats", "benchmark", "table",
                               "--dataset", str(small), "--no-rerun"], cwd=ROOT,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True) as running:
            running.stdout.close()
            err = running.stderr.read()
        assert running.returncode == 0
        assert complaints(err) == []

    @pytest.mark.parametrize("kind", ["chart", "figures"])
    def test_ctrl_c_leaves_nothing(self, kind, tmp_path):
        with subprocess.Popen([sys.executable, "-m", "ros_pose_stats", "benchmark", kind,
                               "-o", str(tmp_path / "out")], cwd=ROOT, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as running:
            try:
                lines = iter(running.stderr.readline, "")
                first = next(line for line in lines if "compiling kernels" not in line)
                running.send_signal(signal.SIGINT)
                out, err = running.communicate(timeout=30.0)
            finally:
                running.kill()
        assert first.startswith(("reading the dataset", "table of shift 0"))
        assert running.returncode == 130
        assert out == ""
        assert err.splitlines()[-1] == "ros_pose_stats: interrupted"
        assert list(tmp_path.iterdir()) == []
