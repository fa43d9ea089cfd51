"""The documents: everything is there, whole or not at all."""

from __future__ import annotations

import re

import pytest

from ros_pose_stats import whole_files
from ros_pose_stats.errors import RequestError
from ros_pose_stats.plots import files
from ros_pose_stats.study import accuracy_documents
from ros_pose_stats.study.accuracy_documents import (
    Documents,
    measure_documents,
    write_chart,
    write_documents,
    write_prisms,
)
from ros_pose_stats.study.chart import Plan, chart
from ros_pose_stats.study.chart.methods import Effort
from ros_pose_stats.study.output import markdown_table, plain, plus_minus, points, with_error
from ros_pose_stats.study.prisms import prism_runs, prisms
from ros_pose_stats.study.table import dataset_table, table
from ros_pose_stats.whole_files import refuse_unwritable, write_whole
from tests.running import strict_json
from tests.study.tables import first_bodies, shipped, some

PLANS = (Plan(0, 0, 0, Effort(1, 10, (10,)), 3, 0),)

FILES = ["benchmarks/chart.json", "benchmarks/prisms.json", "benchmarks/table.json",
         *(f"figures/{name}.{kind}" for name in ("estimators", "noise", "prisms",
                                                 "speed_accuracy")
           for kind in ("png", "svg")),
         "study/accuracy.md"]


@pytest.fixture(scope="module")
def measured():
    datasets = [some(22), first_bodies(shipped(0.25), 21)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prism_runs, "CURVE_RATIOS", 5)
        bars = prisms(10, 10)
    return Documents(datasets[0], [table(one, rerun=False) for one in datasets], bars,
                     chart(datasets[0], PLANS))


@pytest.fixture(scope="module")
def folder(measured, tmp_path_factory):
    path = tmp_path_factory.mktemp("documents") / "new" / "docs"
    write_documents(measured, path)
    return path


def names(folder):
    return sorted(one.relative_to(folder).as_posix() for one in folder.rglob("*")
                  if one.is_file())


@pytest.mark.long
class TestWritten:
    def test_all_files_and_nothing_else(self, folder):
        assert names(folder) == FILES
        assert all(file.stat().st_size > 500 for file in folder.rglob("*") if file.is_file())

    def test_json_is_strict(self, folder, measured):
        found = {name: strict_json((folder / "benchmarks" / f"{name}.json").read_text())
                 for name in ("table", "prisms", "chart")}
        assert [one["spec"]["shift"] for one in found["table"]] == [0.0, 0.25]
        assert found["chart"] == measured.measured.as_dict()
        assert found["prisms"] == measured.bars.as_dict()

    def test_the_page_shows_every_figure_and_table(self, folder, measured):
        page = (folder / "study/accuracy.md").read_text()
        shown = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", page)
        assert sorted(shown) == [f"../{name}" for name in FILES if name.endswith(".png")]
        assert all((folder / "study" / name).is_file() for name in shown)
        assert "### Shift 0 (inertia), 22 bodies" in page
        assert "### Shift 0.25 (inertia), 21 bodies" in page
        assert f"### {measured.measured.sizes[0].title}" in page
        assert "nan" not in page

    def test_files_are_readable_by_others(self, folder):
        assert (folder / "study/accuracy.md").stat().st_mode & 0o044 == 0o044

    def test_written_again_it_replaces_its_own_and_keeps_the_rest(self, folder, measured):
        (folder / "node.md").write_text("kept")
        (folder / "study/accuracy.md").write_text("old")
        files = write_documents(measured, folder)
        assert sorted(one.relative_to(folder).as_posix() for one in files) == FILES
        assert (folder / "node.md").read_text() == "kept"
        assert (folder / "study/accuracy.md").read_text().startswith("# Accuracy")
        (folder / "node.md").unlink()

    @pytest.mark.parametrize("error", [OSError(28, "No space left on device"),
                                       KeyboardInterrupt()])
    def test_cut_short_it_changes_nothing(self, measured, tmp_path, monkeypatch, error):
        (tmp_path / "study").mkdir()
        (tmp_path / "study/accuracy.md").write_text("old")
        calls = []

        def fail(figure, stem):
            calls.append(stem)
            if len(calls) == 3:
                raise error
            return save(figure, stem)

        save = files.save_figure
        monkeypatch.setattr(files, "save_figure", fail)
        with pytest.raises(type(error)):
            write_documents(measured, tmp_path)
        assert len(calls) == 3
        assert names(tmp_path) == ["study/accuracy.md"]
        assert (tmp_path / "study/accuracy.md").read_text() == "old"


@pytest.mark.long
class TestMeasured:
    def test_quickly(self, measured, monkeypatch):
        """Each part is asked for; none is written."""
        said = []
        monkeypatch.setattr(dataset_table, "MORE_DROPS", (5, 7))
        monkeypatch.setattr(accuracy_documents, "shipped_dataset", lambda: measured.first)
        monkeypatch.setattr(accuracy_documents, "QUICK", PLANS)
        monkeypatch.setattr(accuracy_documents, "prisms", lambda *drops: (measured.bars, drops))
        found = measure_documents(quick=True, say=said.append)
        assert found.first is measured.first
        ours, theirs = found.tables[0].as_dict(), measured.tables[0].as_dict()
        assert ours["estimators"] == theirs["estimators"]
        assert found.bars[1] == (200, 200)
        assert len(found.measured.sizes) == 1
        assert said[:2] == ["table of shift 0 (inertia)", "square prisms"]

    def test_fully(self, measured, monkeypatch):
        kinds = []
        monkeypatch.setattr(accuracy_documents, "shipped_datasets", lambda: [some(3), some(2)])
        monkeypatch.setattr(accuracy_documents, "table",
                            lambda dataset, rerun: kinds.append((dataset.spec.bodies, rerun)))
        monkeypatch.setattr(accuracy_documents, "prisms", lambda *drops: drops)
        monkeypatch.setattr(accuracy_documents, "chart", lambda dataset, plans, on_progress: plans)
        found = measure_documents()
        assert kinds == [(3, True), (2, True)]
        assert found.bars == ()
        assert [plan.vertices for plan in found.measured] == [0, 200, 2000, 0]  # the last: parts
        assert all(plan.effort.drops == (10, 100, 1_000, 10_000) for plan in found.measured)


@pytest.mark.long
class TestSingleFigures:
    def test_a_chart_has_its_numbers_beside_it(self, measured, tmp_path):
        stem = tmp_path / "deep" / "shift_0.25"
        write_chart(measured.measured, stem)
        assert names(tmp_path) == [f"deep/shift_0.25.{kind}" for kind in ("json", "png", "svg")]
        assert strict_json((tmp_path / "deep" / "shift_0.25.json").read_text())["sizes"]

    def test_prisms(self, measured, tmp_path):
        assert write_prisms(measured.bars, tmp_path / "p") == [tmp_path / "p.png",
                                                                tmp_path / "p.svg"]
        assert names(tmp_path) == ["p.png", "p.svg"]


class TestWholeFiles:
    def test_the_folder_is_looked_at_before_anything_is_measured(self, tmp_path):
        refuse_unwritable(tmp_path / "not" / "yet")
        assert not (tmp_path / "not").exists()
        (tmp_path / "file").write_text("")
        for folder in (tmp_path / "file", tmp_path / "file" / "below"):
            with pytest.raises(RequestError, match="can be written to"):
                refuse_unwritable(folder)
        assert names(tmp_path) == ["file"]

    def test_files_are_moved_in_order(self, tmp_path):
        def write(aside):
            assert aside.name.startswith(whole_files.PREFIX)
            (aside / "sub").mkdir()
            (aside / "sub" / "b").write_text("2")
            (aside / "a").write_text("1")

        assert write_whole(tmp_path, write) == [tmp_path / "a", tmp_path / "sub" / "b"]
        assert names(tmp_path) == ["a", "sub/b"]


class TestPlain:
    def test_keys_and_numbers(self):
        assert plain({0.2: (1, float("nan"), [float("inf"), 2.5, None, "x"])}) == {
            "0.2": [1, None, [None, 2.5, None, "x"]]}


class TestMarkdown:
    def test_columns_line_up(self):
        text = markdown_table(("", "paper"), [("a", "1.0"), ("longer", "10.25")])
        assert text.splitlines() == ["|        | paper |", "| ------ | ----: |",
                                     "| a      |   1.0 |", "| longer | 10.25 |"]

    def test_numbers(self):
        assert points(0.0849) == "8.5"
        assert with_error(0.0849, 0.0012) == "8.49 ± 0.12"
        assert plus_minus(0.5, float("nan"), 3) == "0.500"
