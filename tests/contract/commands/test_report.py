# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""`report`: files that are written, counts that can be had again, and refusals."""

import math
import re

import pytest

from ros_pose_stats import auto, estimate, load_part, simulate
from tests.running import answer, answer_json, refusal


@pytest.fixture(scope="module")
def written(box, tmp_path_factory):
    """What is printed, and the folder that was made."""
    folder = tmp_path_factory.mktemp("report") / "out"
    text = answer(
        "report",
        *box,
        "--seed",
        3,
        "-o",
        folder / "box.html",
        "--png",
        folder / "box.png",
    )
    return text, folder


def test_page_and_figure_are_written_and_named(written):
    text, folder = written
    assert str(folder / "box.html") in text and " drops" in text
    assert (
        (folder / "box.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    )
    assert (folder / "box.png").read_bytes().startswith(b"\x89PNG")
    assert {file.name for file in folder.iterdir()} == {"box.html", "box.png"}


def test_the_page_says_which_commands_give_its_answer_again(box, written, tmp_path):
    part = load_part(box[0], unit="mm")
    dropped = tmp_path / "dropped.html"
    answer("report", *box, "--seed", 3, "--drops", 70, "-o", dropped)
    for page, command, statistics in (
        (written[1] / "box.html", "estimate box.stl", auto(part, seed=3)),
        (dropped, "simulate box.stl", simulate(part, 70, seed=3)),
    ):
        source = page.read_text(encoding="utf-8")
        assert re.search(rf"ros_pose_stats {command} --unit mm .*--seed 3", source)
        for pose in statistics.poses:
            assert f"<td>{pose.count}</td>" in source


def test_the_same_request_gives_the_same_page(box, written):
    page = written[1] / "box.html"
    before = page.read_bytes()
    answer("report", *box, "--seed", 3, "-o", page)
    assert page.read_bytes() == before


@pytest.fixture(scope="module")
def sheet(box, tmp_path_factory):
    """A sheet of the box, and the table beside it."""
    folder = tmp_path_factory.mktemp("sheet")
    text = answer("report", *box, "--count-sheet", "-o", folder / "sheet.html")
    return text, folder / "sheet.html", folder / "counts.csv"


def test_a_sheet_has_a_row_of_boxes_for_each_pose_and_its_table_too(box, sheet):
    text, page, table = sheet
    html = page.read_text(encoding="utf-8")
    drawn = re.findall(r"<h3>Pose (\d+)<", html)
    assert sorted(drawn) == ["0", "2", "4"] and html.count('href="#boxes"') == 4
    assert "with pose 1, which look the same" in html and "size: A4" in html
    rows = [line.split(",") for line in table.read_text().splitlines()]
    assert rows[0] == ["part", "pose", "count"]
    assert [row[1:] for row in rows[1:]] == [["0", "0"], ["2", "0"], ["4", "0"]]
    assert all((table.parent / row[0]).samefile(box[0]) for row in rows[1:])
    assert str(page) in text and str(table) in text


def test_a_sheet_says_which_error_how_many_throws_leave(box, sheet):
    """Of the counts by the variance of shares over the three groups of the box."""
    html = sheet[1].read_text(encoding="utf-8")
    groups = {}
    for pose in estimate(load_part(box[0], unit="mm")).poses:
        groups[pose.group] = groups.get(pose.group, 0.0) + pose.probability
    variance = sum(share * (1.0 - share) for share in groups.values()) / len(groups)
    for throws in (50, 1000):
        row = f"<tr><td>{throws}</td><td>(.*?)</td><td>(.*?)</td></tr>"
        alone, together = map(float, re.search(row, html).groups())
        assert alone == pytest.approx(100.0 * math.sqrt(variance / throws), abs=0.051)
        assert together < min(alone, 5.0)


def test_counts_that_are_there_stay_and_other_parts_get_rows(box, bar, sheet, tmp_path):
    table = tmp_path / "counts.csv"
    table.write_text(f"part;pose;count\n{box[0]};0;7")
    for part in (box, bar):
        answer("report", *part, "--count-sheet", "-o", tmp_path / "sheet.html")
    lines = table.read_text().splitlines()
    assert lines[:2] == ["part;pose;count", f"{box[0]};0;7"] and len(lines) > 3
    assert all((tmp_path / line.split(";")[0]).samefile(bar[0]) for line in lines[2:])


def test_the_table_of_a_sheet_is_read_as_it_is(box, sheet, tmp_path):
    """Of the two sides that look alike one has all counts: no contradiction."""
    lines = sheet[2].read_text().splitlines()
    table = sheet[2].with_name("filled.csv")
    counts = iter((110, 60, 30))
    rows = [f"{line.rpartition(',')[0]},{next(counts)}" for line in lines[1:]]
    table.write_text("\n".join([lines[0], *rows]))
    plate = "--plate", "glass", "--plates", tmp_path / "plates.yaml"
    assert answer_json("fit", table, "--unit", "mm", *plate)["counted"] == 200
    feeding = "feeding", *box, "--wanted", "0,1"
    counted = answer_json(*feeding, "--counts", table)
    assert (counted["method"], counted["counted_parts"]) == ("observed", 200)
    assert "CONFLICT" not in {warning["code"] for warning in counted["warnings"]}
    rates = [plan["per_minute"]["value"] for plan in (counted, answer_json(*feeding))]
    assert min(rates) < max(rates)
    line = refusal("feeding", *box, "--wanted", 0, "--counts", tmp_path / "none.csv")
    assert "a CSV file in UTF-8" in line


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("-o", "page.html", "--count-sheet", "--rate", "60"), "--count-sheet with"),
        (("-o", "page.html", "--count-sheet", "--seed", "2"), "--count-sheet with"),
        (("-o", "page.pdf"), "a file name that ends in .html"),
        (
            ("-o", "page.html", "--wanted", "6"),
            "wanted poses out of 0 to 5, at least one, got 6",
        ),
        (
            ("-o", "page.html", "--rate", "60"),
            "wanted poses out of 0 to 5, at least one, got none",
        ),
        (("-o", "page.html", "--changes"), "wanted poses"),
        (("-o", "page.html", "--wanted", "0", "--rate", "-1"), "a rate above 0"),
        (
            ("-o", "page.html", "--wanted", "0", "--kick", "0.02"),
            "a rate of parts a minute beside",
        ),
        (
            ("-o", "page.html", "--wanted", "0", "--rate", "60", "--kick", "-1"),
            "a kick height of 0 m or more",
        ),
        (("-o", "page.html", "--png", "page.svg"), "ends in .png"),
        (("-o", "page.html", "--drops", "0"), "1 to 1000000000 drops"),
        (
            ("-o", "page.html", "--port", "8000"),
            "--port, --no-browser and --cad with --watch",
        ),
        (("-o", "page.html", "--watch"), "not allowed with argument"),
        (("--watch", "--drops", "100"), "--watch with the part, the scene"),
        (("--watch", "--png", "page.png"), "--watch with the part, the scene"),
        (("--watch", "--no-browser", "--port", "65536"), "a port from 0 to 65535"),
        (("--watch", "--no-browser", "--wanted", "6"), "wanted poses out of 0 to 5"),
        (("--watch", "--no-browser", "--seed", "-1"), "a seed from 0 to 2^64 - 1"),
    ],
)
def test_refused_before_anything_is_written(box, tmp_path, monkeypatch, options, words):
    monkeypatch.chdir(tmp_path)
    assert words in refusal("report", *box, *options)
    assert not list(tmp_path.iterdir())
