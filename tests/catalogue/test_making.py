"""Making a catalogue: the same tables whoever makes them and however often it stops."""

import csv
import json
import os
import shutil

import pytest
from pyarrow import parquet

from ros_pose_stats import shapes
from ros_pose_stats.batch.folder import WorkFolder
from ros_pose_stats.catalogue import processes
from ros_pose_stats.catalogue.making import CLAIM, make_catalogue
from ros_pose_stats.catalogue.processes import on_processes
from ros_pose_stats.catalogue.request import CatalogueRequest, find_parts
from ros_pose_stats.catalogue.tables import COLUMNS
from ros_pose_stats.errors import BatchError, MassPropertiesError, RequestError
from ros_pose_stats.records import DropScene
from tests.bodies import write_stl
from tests.catalogue import SIZES, boxes, here

MM = CatalogueRequest(unit="mm")
TABLES = ("catalogue.csv", "poses.csv")


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    """Six boxes, one file that is none and one that is empty."""
    folder = boxes(tmp_path_factory.mktemp("catalogue") / "parts")
    (folder / "letter.stl").write_text("Dear colleague,")
    (folder / "empty.step").touch()
    (folder / "notes.txt").write_text("no part")
    (folder / ".hidden.stl").write_text("no part")
    return folder


@pytest.fixture(scope="module")
def whole(parts, tmp_path_factory):
    """The tables as they come in one go."""
    folder = tmp_path_factory.mktemp("whole")
    made = make_catalogue(folder, find_parts([parts]), MM, here())
    assert made.complete
    return tables(folder)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "catalogue"


def tables(folder):
    return [(folder / name).read_bytes() for name in TABLES]


def rows_of(folder, name="catalogue.csv"):
    with (folder / name).open(newline="") as lines:
        return list(csv.DictReader(lines))


def stopped_after(folder, parts, count, request=MM):
    made = []
    found = make_catalogue(folder, find_parts([parts]), request, here(made),
                           should_stop=lambda: len(made) >= count)
    assert not found.complete
    return made


class TestTheSameTables:
    def test_whatever_the_order(self, parts, whole, folder):
        assert make_catalogue(folder, find_parts([parts]), MM, here(backwards=True)).complete
        assert tables(folder) == whole

    def test_by_processes(self, parts, whole, folder):
        assert make_catalogue(folder, find_parts([parts]), MM, on_processes(2)).complete
        assert tables(folder) == whole

    @pytest.mark.parametrize("count", [1, 4, 7])
    def test_stopped_and_gone_on_with(self, parts, whole, folder, count):
        first = stopped_after(folder, parts, count)
        assert len(rows_of(folder)) == count  # a table of what is there
        made, seen = [], []
        found = make_catalogue(folder, find_parts([parts]), MM, here(made),
                               on_progress=seen.append)
        assert found.complete and tables(folder) == whole
        refused = {("letter.stl", False), ("empty.step", False)}
        assert set(first) & set(made) <= refused  # these may go well now
        assert (seen[0].parts, seen[-1].parts, seen[-1].bound) == (8 - len(made), 8, 8)

    def test_a_second_run_looks_at_what_was_refused_only(self, parts, whole, folder):
        make_catalogue(folder, find_parts([parts]), MM, here())
        made = []
        found = make_catalogue(folder, find_parts([parts]), MM, here(made))
        assert sorted(made) == [("empty.step", False), ("letter.stl", False)]
        assert (found.done, found.found, len(found.tally.refused)) == (8, 6, 2)
        assert tables(folder) == whole

    def test_of_drops(self, tmp_path):
        """Stopped between the estimates and the drops, and in the middle of the drops."""
        parts = boxes(tmp_path / "parts", SIZES[:3])
        request = CatalogueRequest(DropScene(0.8), "mm", target_error=0.004)
        whole = tmp_path / "whole"
        made = []
        assert make_catalogue(whole, find_parts([parts]), request, here(made)).complete
        assert made == [(f"box_{k}.stl", drop) for drop in (False, True) for k in range(3)]
        assert all(int(row["drops"]) > 0 for row in rows_of(whole))
        for count in (2, 3, 5):
            folder = tmp_path / f"stopped_{count}"
            stopped_after(folder, parts, count, request)
            assert {int(row["drops"]) > 0 for row in rows_of(folder)} == (
                {False, True} if count == 5 else {False})
            assert make_catalogue(folder, find_parts([parts]), request, here()).complete
            assert tables(folder) == tables(whole)


class TestPartsThatTakeTooLong:
    """A limit that nothing can keep stands for a part that never ends."""

    def test_the_row_says_so(self, tmp_path, folder, monkeypatch):
        parts = find_parts([boxes(tmp_path / "parts", SIZES[:2])])
        monkeypatch.setattr(processes, "ESTIMATE_SECONDS", 1e-3)
        made = make_catalogue(folder, parts, MM, on_processes(1))
        assert made.complete and len(rows_of(folder)) == 2
        assert set(made.tally.refused.values()) == {
            "expected a part that is looked at within 0.001 s, got one that takes longer; export "
            "it in fewer faces"}

    def test_drops_have_a_limit_of_their_own(self, tmp_path, folder, monkeypatch):
        parts = find_parts([boxes(tmp_path / "parts", SIZES[:1])])
        monkeypatch.setattr(processes, "DROP_SECONDS", 1e-3)
        request = CatalogueRequest(DropScene(0.8), "mm", target_error=0.004)
        made = make_catalogue(folder, parts, request, on_processes(1))
        (why,) = made.tally.refused.values()
        assert "expected a part that is dropped within 0.001 s" in why
        assert "a larger target error" in why
        assert made.complete


class TestFilesThatChange:
    def test_new_changed_and_removed_ones(self, tmp_path, folder):
        parts = boxes(tmp_path / "parts")
        make_catalogue(folder, find_parts([parts]), MM, here())
        write_stl(parts / "box_1.stl", shapes.box(5.0, 5.0, 50.0))
        write_stl(parts / "new.stl", shapes.box(7.0, 8.0, 9.0))
        (parts / "box_2.stl").unlink()
        made = []
        make_catalogue(folder, find_parts([parts]), MM, here(made))
        assert [name for name, _ in made] == ["box_1.stl", "new.stl"]
        names = [row["file"].rpartition("/")[2] for row in rows_of(folder)]
        assert names == ["box_0.stl", "box_1.stl", "box_3.stl", "box_4.stl", "box_5.stl",
                         "new.stl"]
        other = tmp_path / "other"
        make_catalogue(other, find_parts([parts]), MM, here())
        assert tables(other) == tables(folder)


class TestWhatLiesInTheFolder:
    @pytest.mark.parametrize("damage", ["cut", "flipped", "older", "foreign", "emptied"])
    def test_damaged_rows_are_made_again(self, parts, whole, folder, damage):
        stopped_after(folder, parts, 6)
        path = folder / "parts.jsonl"
        lines = path.read_bytes().splitlines(keepends=True)
        lines[-1] = {"cut": lines[-1][:100], "flipped": b"\xff" + lines[-1],
                     "older": lines[-1].replace(b'"unit_declared": false, ', b""),
                     "foreign": b'{"row": []}\n', "emptied": b"\n"}[damage]
        path.write_bytes(b"".join(lines))
        made = []
        assert make_catalogue(folder, find_parts([parts]), MM, here(made)).complete
        assert ("box_5.stl", False) in made and ("box_0.stl", False) not in made
        assert tables(folder) == whole

    @pytest.mark.parametrize("emptied", [False, True])
    def test_a_picture_that_is_gone_is_made_again(self, parts, whole, folder, emptied):
        make_catalogue(folder, find_parts([parts]), MM, here())
        picture = next((folder / "pictures").rglob("*.png"))
        content = picture.read_bytes()
        picture.write_bytes(b"")
        if not emptied:
            picture.unlink()
        make_catalogue(folder, find_parts([parts]), MM, here())
        assert picture.read_bytes() == content
        assert tables(folder) == whole

    def test_what_a_killed_run_left_half_written_goes(self, parts, whole, folder):
        make_catalogue(folder, find_parts([parts]), MM, here())
        for left in (folder / ".unfinished-1", folder / "rows" / ".unfinished-2"):
            left.mkdir(parents=True)
            (left / "catalogue.csv").write_text("half a row")
        make_catalogue(folder, find_parts([parts]), MM, here())
        assert not list(folder.rglob(".unfinished-*"))
        assert tables(folder) == whole

    def test_no_parquet_of_an_earlier_run_stays(self, parts, whole, folder):
        make_catalogue(folder, find_parts([parts]), MM, here(), parquet=True)
        assert len(list(folder.glob("*.parquet"))) == 2
        make_catalogue(folder, find_parts([parts]), MM, here())
        assert not list(folder.glob("*.parquet"))
        assert tables(folder) == whole

    @pytest.mark.parametrize("name", ["catalogue.parquet", "poses.parquet"])
    def test_a_parquet_file_of_somebody_else_is_kept(self, parts, folder, name):
        folder.mkdir()
        (folder / name).write_text("mine")
        with pytest.raises(BatchError, match="another one"):
            make_catalogue(folder, find_parts([parts]), MM, here())
        assert (folder / name).read_text() == "mine"

    def test_another_request_is_refused(self, parts, whole, folder):
        make_catalogue(folder, find_parts([parts]), MM, here())
        for other in (CatalogueRequest(unit="cm"),
                      CatalogueRequest(DropScene(0.3), "mm"),
                      CatalogueRequest(unit="mm", target_error=0.1)):
            with pytest.raises(BatchError, match="the same catalogue") as refusal:
                make_catalogue(folder, find_parts([parts]), other, here())
            assert "\n" not in str(refusal.value)
        assert tables(folder) == whole

    def test_another_version_is_refused(self, parts, folder):
        make_catalogue(folder, find_parts([parts]), MM, here())
        claim = json.loads((folder / CLAIM).read_text())
        (folder / CLAIM).write_text(json.dumps({**claim, "written_by": "ros_pose_stats 0.0.1"}))
        with pytest.raises(BatchError, match=r"0\.0\.1"):
            make_catalogue(folder, find_parts([parts]), MM, here())

    def test_a_page_of_somebody_else_is_kept(self, parts, folder):
        folder.mkdir()
        (folder / "index.html").write_text("my home")
        with pytest.raises(BatchError, match="another one"):
            make_catalogue(folder, find_parts([parts]), MM, here())
        assert [one.name for one in folder.iterdir() if one.name != ".lock"] == ["index.html"]
        assert (folder / "index.html").read_text() == "my home"

    def test_two_runs_at_once(self, parts, folder):
        with (WorkFolder(folder, CLAIM, MM.as_dict(), lambda: False, "a catalogue"),
              pytest.raises(BatchError, match="in use")):
            make_catalogue(folder, find_parts([parts]), MM, here())
        assert make_catalogue(folder, find_parts([parts]), MM, here()).complete

    def test_a_full_disk(self, parts, whole, folder, monkeypatch):
        """Everything that was written before is kept."""
        write, left = os.pwritev, [5]

        def failing(*arguments):
            left[0] -= 1
            if left[0] < 0:
                raise OSError(28, "No space left on device")
            return write(*arguments)

        with monkeypatch.context() as patch:
            patch.setattr(os, "pwritev", failing)
            with pytest.raises(BatchError, match="No space left on device"):
                make_catalogue(folder, find_parts([parts]), MM, here())
        made = []
        assert make_catalogue(folder, find_parts([parts]), MM, here(made)).complete
        assert ("box_0.stl", False) not in made and ("box_5.stl", False) in made
        assert tables(folder) == whole

    def test_a_place_where_nothing_can_be_written(self, parts, tmp_path):
        (tmp_path / "file").touch()
        with pytest.raises(BatchError, match="directory"):
            make_catalogue(tmp_path / "file" / "c", find_parts([parts]), MM, here())


class TestTables:
    def test_every_row_and_column(self, parts, folder):
        made = make_catalogue(folder, find_parts([parts]), MM, here(), keep_rows=True)
        rows = rows_of(folder)
        assert list(rows[0]) == list(COLUMNS)
        assert [row["file"] for row in rows] == sorted(row["file"] for row in rows)
        answered = [row for row in rows if not row["refusal"]]
        assert (len(rows), len(answered)) == (8, 6)
        for row, kept in zip(rows, made.rows, strict=True):
            assert row["refusal"] == kept["refusal"]
            assert float(row["best_share"] or "nan") == pytest.approx(
                kept.get("best_share", float("nan")), rel=0.0, abs=0.0, nan_ok=True)
        poses = rows_of(folder, "poses.csv")
        assert len(poses) == 36
        for row in answered:
            shares = [float(pose["probability"]) for pose in poses if pose["file"] == row["file"]]
            assert sum(shares) == pytest.approx(1.0)

    def test_a_name_that_is_not_utf_8(self, tmp_path, folder):
        parts = boxes(tmp_path / "parts", SIZES[:1])
        os.rename(os.fsencode(parts / "box_0.stl"),  # noqa: PTH104
                  os.fsencode(parts) + b"/b\xf6x, 1.stl")
        assert make_catalogue(folder, find_parts([parts]), MM, here()).complete
        assert b"/b\xf6x, 1.stl" in (folder / "catalogue.csv").read_bytes()
        assert (folder / "index.html").stat().st_size > 0

    def test_parquet_holds_the_same(self, parts, folder):
        made = make_catalogue(folder, find_parts([parts]), MM, here(), parquet=True)
        assert {one.suffix for one in made.tables} == {".csv", ".parquet"}
        for name in TABLES:
            found = parquet.read_table((folder / name).with_suffix(".parquet")).to_pylist()
            for row, text in zip(found, rows_of(folder, name), strict=True):
                assert {key: "" if value is None else str(value)
                        for key, value in row.items()} == text


class TestWhichFiles:
    def test_folders_below_and_files_by_name(self, tmp_path):
        boxes(tmp_path / "a" / "b", SIZES[:2])
        boxes(tmp_path / "a" / ".cache", SIZES[:1])
        shutil.copy(tmp_path / "a" / "b" / "box_0.stl", tmp_path / "a" / "PART.STL")
        (tmp_path / "a" / "letter.txt").touch()
        found = find_parts([tmp_path / "a", tmp_path / "a" / "b" / "box_0.stl"])
        assert [one.name.removeprefix(f"{tmp_path}/") for one in found] == [
            "a/PART.STL", "a/b/box_0.stl", "a/b/box_1.stl"]
        (named,) = find_parts([tmp_path / "a" / "letter.txt"])
        assert (named.name, named.bytes) == (str(tmp_path / "a" / "letter.txt"), 0)

    @pytest.mark.parametrize("links", [
        {"a/self": "."}, {"one": ".", "two": "."}, {"a/up": "..", "a/b/up": "../.."},
        {"0_first": "a/b"}, {"a/0_first": "b"}, {"a/one": "../z", "a/two": "../z"}])
    def test_every_folder_is_looked_into_once_whatever_links_to_it(self, tmp_path, links):
        """A link to a folder above would lead on for ever; where it is, its own path counts."""
        for folder in ("a/b", "z"):
            boxes(tmp_path / folder, SIZES[:1])
        for name, to in links.items():
            (tmp_path / name).symlink_to(to)
        assert [one.name for one in find_parts([tmp_path])] == [
            f"{tmp_path}/a/b/box_0.stl", f"{tmp_path}/z/box_0.stl"]

    def test_a_link_to_a_folder_elsewhere(self, tmp_path):
        boxes(tmp_path / "elsewhere" / "below", SIZES[:1])
        (tmp_path / "parts").mkdir()
        for name in ("b", "a"):
            (tmp_path / "parts" / name).symlink_to("../elsewhere")
        (tmp_path / "link").symlink_to("parts")
        assert [one.name for one in find_parts([tmp_path / "link"])] == [
            f"{tmp_path}/link/a/below/box_0.stl"]

    def test_none_is_refused(self, tmp_path):
        with pytest.raises(RequestError, match="none in"):
            find_parts([tmp_path])
        with pytest.raises(RequestError, match="no file"):
            find_parts([tmp_path / "gone"])

    @pytest.mark.parametrize(("values", "error"), [
        ({"density": -1.0}, MassPropertiesError), ({"target_error": 1.0}, RequestError),
        ({"target_error": -0.1}, RequestError)])
    def test_bad_requests(self, values, error):
        with pytest.raises(error):
            CatalogueRequest(**values)
