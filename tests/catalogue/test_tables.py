"""The tables, whatever the names of files hold."""

import csv
from pathlib import Path

import pytest
from pyarrow import parquet

from ros_pose_stats.catalogue.request import find_parts
from ros_pose_stats.catalogue.tables import write_tables

ODD = ("a\rb.stl", "c\nd.stl", "e\r\nf.stl", 'g"h,i;j\tk.stl', " l .stl", "\rm.stl",
       "ü\x85\u2028.stl")


def parts_of(folder, name):
    if name.endswith(".parquet"):
        return [row["file"] for row in parquet.read_table(folder / name).to_pylist()]
    with (folder / name).open(newline="") as lines:
        return [row["file"] for row in csv.DictReader(lines)]


def refusals(names):
    return lambda: ({"file": name, "refusal": f"no part, {name}"} for name in names)


def test_every_name_has_one_row_and_is_the_same_in_both_kinds(tmp_path):
    write_tables(tmp_path, refusals(ODD), parquet=True)
    assert parts_of(tmp_path, "catalogue.csv") == list(ODD)
    assert parts_of(tmp_path, "catalogue.parquet") == list(ODD)


def test_lines_end_as_those_of_unix(tmp_path):
    write_tables(tmp_path, refusals(["a.stl"]), parquet=False)
    assert b"\r" not in (tmp_path / "catalogue.csv").read_bytes()


@pytest.mark.parametrize("name", ["=1+1.stl", "+a.stl", "-b.stl", "@c.stl", "\td.stl", "\re.stl"])
def test_a_name_that_a_spreadsheet_would_compute_is_a_path(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text("no part")
    (tmp_path / "=folder").mkdir()
    (tmp_path / "=folder" / "a.stl").write_text("no part")
    (found,) = find_parts([name])
    assert found.name == f"./{name}"
    assert Path(found.name).stat().st_size == found.bytes == 7
    assert [one.name for one in find_parts(["."])] == sorted([f"./{name}", "./=folder/a.stl"])
    assert [one.name for one in find_parts(["=folder"])] == ["./=folder/a.stl"]
    assert [one.name for one in find_parts([tmp_path / name])] == [str(tmp_path / name)]
