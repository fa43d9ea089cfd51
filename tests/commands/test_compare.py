"""`compare`: the table, the JSON object, the page, and refusals."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from ros_pose_stats import cli, load_part, shapes
from ros_pose_stats.commands.design.compare import name_variants
from ros_pose_stats.commands.design.comparison_table import comparison_table
from ros_pose_stats.design.compare import compare
from tests.bodies import write_stl
from tests.running import ROOT, strict_json

CENTERS = "--com", 0.0, 0.0, 0.0, "--com", 0.0, 0.0, -4.0


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    """Boxes 20 x 30 x 16 and 20 x 30 x 24, about their middles, in millimetres."""
    folder = tmp_path_factory.mktemp("parts")
    found = []
    for name, height in (("flat", 16.0), ("high", 24.0)):
        vertices, triangles = shapes.box(20.0, 30.0, height)
        middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        write_stl(folder / f"{name}.stl", (vertices - middle, triangles))
        found.append(str(folder / f"{name}.stl"))
    return found


def run(capsys, *arguments):
    status = cli.main(["compare", *map(str, arguments)])
    return status, *capsys.readouterr()


def test_the_object_is_the_library_s(boxes, capsys):
    status, out, _ = run(capsys, *boxes, "--unit", "mm", "--drops", 300, "--seed", 5, "--wanted",
                         "0,1", "--json")
    found = strict_json(out)
    expected = compare([load_part(one, "mm") for one in boxes], [0, 1], 300, seed=5).as_dict()
    assert status == 0 and found.keys() == expected.keys()
    assert found["comparisons"] == expected["comparisons"]
    assert [one["part_id"] for one in found["variants"]] == ["flat", "high"]


def test_the_unit_is_for_files_that_declare_none(tmp_path, capsys):
    import trimesh

    files = [tmp_path / "box.3mf", tmp_path / "box.stl"]
    for file, length in zip(files, (80.0, 8.0), strict=True):
        trimesh.creation.box((length, 0.5 * length, 0.4 * length)).export(file)
    status, out, _ = run(capsys, *files, "--unit", "cm", "--drops", 250, "--seed", 5)
    assert status == 0
    assert {line.rpartition(", ")[2] for line in out.splitlines()[:2]} == {"radius 47.5 mm"}
    assert "UNIT_OVERRIDDEN" not in out


def test_the_table(boxes, capsys):
    status, out, error = run(capsys, *boxes, "--unit", "mm", "--drops", 1250, "--seed", 5,
                             "--wanted", "0,1")
    lines = out.splitlines()
    assert status == 0 and error == ""
    assert lines[:2] == ["A flat: 6 stable poses, radius 19.72 mm",
                         "B high: 6 stable poses, radius 21.66 mm"]
    first = next(line for line in lines if line.startswith("Accepted are "))
    assert ": difference shown, in the model and on a plate in 1250 drops of each." in first
    assert "1250 drops of each from the same starts, 0 unsettled, seed 5" in lines
    assert lines[lines.index(first) + 1:][-1].startswith("computed in ")


def test_another_unit_is_told_before_the_verdict(boxes, capsys, tmp_path):
    vertices, triangles = shapes.box(20.0, 30.0, 16.0)
    small = write_stl(tmp_path / "small.stl", (vertices / 25.4, triangles))
    page = tmp_path / "units.html"
    lines = run(capsys, boxes[0], small, "--unit", "mm", "--drops", 100, "--seed", 5, "-o",
                page)[1].splitlines()
    (warned,) = [k for k, line in enumerate(lines) if line.startswith("UNITS_DIFFER: A is 25.4 ")]
    assert lines[warned + 1].startswith("A and B: ")
    text = page.read_text(encoding="utf-8")
    assert 0 < text.index("Are the files in the same unit?") < text.index('class="lead"')


def test_wanted_poses_of_which_symmetry_has_more(boxes, capsys):
    asked = *boxes, "--unit", "mm", "--drops", 300, "--seed", 5, "--wanted"
    said = ["WANTED_ALIKE: pose 3 looks the same as pose 2 (symmetry)",
            "WANTED_ALIKE: pose 1 looks the same as pose 0 (symmetry)"]
    found = strict_json(run(capsys, *asked, "2", "--json")[1])
    assert [line.partition(" and is")[0] for one in found["variants"]
            for line in one["warnings"]] == said
    text = run(capsys, *asked, "2")[1]
    assert f"A: {said[0]}" in text and f"B: {said[1]}" in text
    assert "WANTED_ALIKE" not in run(capsys, *asked, "0-1")[1]


def test_a_centre_of_mass_for_each(boxes, capsys):
    _, out, _ = run(capsys, boxes[0], boxes[0], "--unit", "mm", *CENTERS, "--drops", 300,
                    "--seed", 1, "--json")
    first, second = strict_json(out)["variants"]
    down = {tuple(round(x) for x in pose["down"]): pose["height"] for pose in second["poses"]}
    assert first["part_digest"] != second["part_digest"]
    assert down[0, 0, -1] == pytest.approx(0.004) and down[0, 0, 1] == pytest.approx(0.012)


def test_the_page(boxes, capsys, tmp_path):
    page = tmp_path / "boxes.html"
    status, out, _ = run(capsys, *boxes, "--unit", "mm", "--drops", 300, "--seed", 5, "-o", page)
    text = page.read_text(encoding="utf-8")
    assert status == 0 and f"{page}: " in out
    assert f"ros_pose_stats compare {boxes[0]} {boxes[1]} --unit mm" in text
    assert "--drops 300 --seed 5" in text


@pytest.mark.parametrize(("files", "names"), [
    (("old/box.stl", "new/box.stl"), ["old/box", "new/box"]),
    (("x/old/box.stl", "y/old/box.stl", "x/old/cup.stl"), ["x/old/box", "y/old/box", "cup"]),
    (("box.stl", "new/box.stl"), ["./box", "new/box"]),
    (("box.stl", "box.stl"), ["box", "box"]),
    (("box.stl", "./box.stl", "new/box.stl"), ["./box", "./box", "new/box"]),
    (("box.stl", "box.STEP"), ["box.stl", "box.STEP"]),
    (("old/box.stl", "old/cup.stl"), ["box", "cup"]),
])
def test_equal_names_are_told_apart_by_their_folders(files, names):
    assert name_variants(files) == names


def test_files_of_one_name_keep_their_folders(boxes, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder, file in zip(("old", "new"), boxes, strict=True):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "bracket.stl").write_bytes(Path(file).read_bytes())
    out = run(capsys, "old/bracket.stl", "new/bracket.stl", "--unit", "mm", "--drops", 100,
              "--seed", 5, "-o", "page.html")[1]
    assert out.startswith("A old/bracket: ") and "\nB new/bracket: " in out
    text = Path("page.html").read_text(encoding="utf-8")
    assert "<title>A old/bracket and B new/bracket</title>" in text
    assert "compare old/bracket.stl new/bracket.stl --unit mm" in text


@pytest.mark.parametrize(("arguments", "said"), [
    (["one"], "2 to 26 variants"),
    (["both", "--com", 0, 0, 0, "--com", 0, 0, 0, "--com", 0, 0, 0], "--com once, or once for"),
    (["both", "--wanted", 9], "wanted poses out of 0 to 5"),
    (["both", "--com", 0, 0, 90], "inside the part's convex hull"),
    (["both", "--plate-error", 2], "a plate error from 0 to 1"),
    (["both", "-o", "page.txt"], "ends in .html"),
    (["both", "--restitution", 1], "a coefficient of restitution"),
])
def test_refusals(boxes, capsys, arguments, said):
    files = boxes if arguments[0] == "both" else boxes[:1]
    status, out, error = run(capsys, *files, "--unit", "mm", *arguments[1:])
    assert (status, out) == (2, "")
    assert said in error and error.count("\n") == 1


def test_nothing_done_can_be_printed(boxes):
    parts = [load_part(one, "mm") for one in boxes]
    found = compare(parts, [0], seed=1, should_stop=lambda: True)
    text = comparison_table(found)
    assert "nan" not in text and "0 drops of each" in text


def test_ctrl_c_reports_what_is_done(boxes):
    """At such a restitution a drop takes so long that no look at the drops ends the comparison."""
    terminal, stderr = pty.openpty()
    running = subprocess.Popen(
        [sys.executable, "-m", "ros_pose_stats", "compare", *boxes, "--unit", "mm", "--drops",
         "100000000", "--restitution", "0.9995", "--seed", "1", "--workers", "2", "--json"],
        stdout=subprocess.PIPE, stderr=stderr, text=True, cwd=ROOT)
    os.close(stderr)
    try:
        shown = ""
        while "drops" not in shown:
            shown += os.read(terminal, 4096).decode()
        running.send_signal(signal.SIGINT)
        out, _ = running.communicate(timeout=60.0)
    finally:
        running.kill()
        os.close(terminal)
    assert running.returncode == 130
    assert strict_json(out)["interrupted"] is True
