"""`sensitivity`: the table, the JSON object, files, a suggestion, and refusals in one line."""

from __future__ import annotations

import json

import numpy as np
import pytest

from ros_pose_stats import cli, load_part, sensitivity, shapes
from ros_pose_stats.commands.design.sensitivity import _write_files
from ros_pose_stats.design.describe import JUDGED, sensitivity_as_dict
from tests.bodies import write_stl


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A box 20 x 30 x 40, in millimetres."""
    path = tmp_path_factory.mktemp("parts") / "box.stl"
    write_stl(path, shapes.box(20.0, 30.0, 40.0))
    return str(path)


def run(capsys, *arguments):
    status = cli.main(["sensitivity", *map(str, arguments)])
    return status, *capsys.readouterr()


ASKED = ("--unit", "mm", "--wanted", "2,3", "--drops", 200, "--seed", 5)


def test_the_object_is_the_library_s(box, capsys):
    status, out, _ = run(capsys, box, *ASKED, "--json")
    found = json.loads(out)
    expected = sensitivity_as_dict(sensitivity(load_part(box, unit="mm"), [2, 3], drops=200,
                                               seed=5))
    for name in ("seconds", "part_id"):
        found.pop(name), expected.pop(name)
    assert status == 0 and found == json.loads(json.dumps(expected))
    assert {one["unit"] for one in found["effects"]} == {"m", "1"}


def test_the_table(box, capsys):
    lines = run(capsys, box, *ASKED)[1].splitlines()
    assert lines[0].startswith("box: wanted poses 2, 3: ") and lines[-1] == JUDGED
    assert ("in the order of what a step changes, 1.35 mm or 5 % of stretching, the most first"
            in lines)
    # Like faces and edges share rows: three kinds of each, and three axes twice.
    assert sum(line.endswith(("  points per mm", "  points per %")) for line in lines) == 12
    steps = ("by 1.35 mm", "by 5 % along x (1 mm)", "by 5 % along y (1.5 mm)",
             "by 5 % along z (2 mm)", "mm towards")
    assert sum(any(step in line for step in steps) for line in lines) == 5


def test_time_that_ends_the_checks_is_told_with_how_to_go_on(box, capsys, monkeypatch):
    monkeypatch.setattr("ros_pose_stats.design.sensitivity.CHECK_SECONDS", 0.0)
    monkeypatch.setattr("ros_pose_stats.design.suggest.GAIN_SECONDS", 0.0)
    asked = box, "--unit", "mm", "--wanted", "2,3", "--suggest", "--within", 1, "--seed", 5
    lines = run(capsys, *asked)[1].splitlines()
    assert [line for line in lines if line.startswith("time ended")] == [
        f"time ended the drops after 62 of {most}; --drops {most} does them all"
        for most in (2000, 4000)]
    found = json.loads(run(capsys, *asked, "--json")[1])
    assert [(one["drops"], one["most_drops"], one["out_of_time"])
            for one in (found, found["suggestion"])] == [(62, 2000, True), (62, 4000, True)]
    assert "time ended" not in run(capsys, *asked, "--drops", 70)[1]


def test_one_wanted_pose_is_one(box, capsys):
    assert run(capsys, box, "--unit", "mm", "--wanted", 2, "--checks", 0)[1].startswith(
        "box: wanted pose 2: ")


def test_warnings_as_an_estimate_has_them(box, capsys):
    asked = box, "--wanted", 2, "--checks", 0
    lines = run(capsys, *asked)[1].splitlines()
    said = [line.partition(": ")[0] for line in lines if line.partition(": ")[0].isupper()]
    assert said == ["UNIT_SUSPECT", "WANTED_ALIKE"]
    assert lines[-2].startswith("computed in ") and lines[-3].startswith("WANTED_ALIKE: pose 3")
    found = json.loads(run(capsys, *asked, "--json")[1])
    assert [line.partition(":")[0] for line in found["warnings"]] == said


def test_a_suggestion_with_its_files(box, capsys, tmp_path):
    from matplotlib.image import imread

    hull, picture = tmp_path / "hull.stl", tmp_path / "changes.png"
    status, out, _ = run(capsys, box, *ASKED, "--suggest", "--within", 1, "--stl", hull, "--png",
                         picture, "--json")
    found = json.loads(out)["suggestion"]
    assert status == 0 and found["within"] == 1e-3 and found["judged"] == JUDGED
    assert found["estimate"]["gain"] > 0.0
    part = load_part(hull, unit="mm")
    np.testing.assert_allclose(part.surface_vertices.max(axis=0),
                               -part.surface_vertices.min(axis=0), atol=1e-8)
    size = np.ptp(part.surface_vertices, axis=0)
    assert np.abs(size - (0.02, 0.03, 0.04)).max() <= 2e-3 * (1.0 + 1e-5)
    assert imread(picture).shape == (840, 1350, 4)
    words = run(capsys, box, *ASKED, "--suggest", "--within", 1)[1]
    assert "suggestion within 1 mm; the outline moves by" in words
    assert "stretched by" in words and "by drops: " in words


def test_only_files_that_were_written_are_told(tmp_path):
    """An interrupted run has no suggestion."""
    assert _write_files({"png": None, "stl": tmp_path / "hull.stl"}, None, None) == []


@pytest.mark.parametrize(("options", "words"), [
    (("--wanted", 9), "wanted poses out of 0 to 5"),
    (("--wanted", 0, "--suggest"), "--within with --suggest"),
    (("--wanted", 0, "--within", 1), "--suggest with --within"),
    (("--wanted", 0, "--suggest", "--within", 0), "a bound above 0"),
    (("--wanted", 0, "--suggest", "--within", 1, "--stl", "hull.obj"), "ends in .stl"),
    (("--wanted", 0, "--step", 100), "half the part's radius"),
    (("--wanted", 0, "--png", "none/"), "ends in .png"),
])
def test_refusals(box, capsys, options, words):
    status, out, err = run(capsys, box, "--unit", "mm", *options)
    assert (status, out) == (2, "") and words in err and err.count("\n") == 1


def test_a_report_has_the_changes(box, capsys, tmp_path):
    page = tmp_path / "box.html"
    assert cli.main(["report", box, "--unit", "mm", "--wanted", "2,3", "--changes", "--drops",
                     "200", "-o", str(page)]) == 0
    capsys.readouterr()
    text = page.read_text(encoding="utf-8")
    assert "Which change of the part feeds better" in text and "add here" in text
    assert "--changes" in text and "the stronger the" in text
    assert "in the order of what a step changes" in text and "points per mm" in text
    # As many as the command takes.
    assert "2000 each from the" in text
    assert cli.main(["report", box, "--unit", "mm", "--changes", "-o", str(page)]) == 2
    assert "wanted poses" in capsys.readouterr().err
