"""The command `report` as a user runs it."""

import pytest

from ros_pose_stats import simulate
from ros_pose_stats.cli import main
from ros_pose_stats.shapes.closed_forms import box
from tests.bodies import write_stl
from tests.running import complaints


@pytest.fixture
def block(tmp_path):
    return write_stl(tmp_path / "block.stl", box(40.0, 30.0, 20.0))


def run(capsys, *words):
    status = main([str(word) for word in words])
    return status, *capsys.readouterr()


def test_the_page_and_the_figure_are_written(block, tmp_path, capsys):
    page, figure = tmp_path / "out" / "block.html", tmp_path / "out" / "block.png"
    status, said, error = run(capsys, "report", block, "--unit", "mm", "--drops", 100, "-o", page,
                              "--png", figure, "--wanted", 0, 1, "--rate", 60)
    assert (status, complaints(error)) == (0, [])
    assert str(page) in said
    assert "100 drops" in said
    text = page.read_text(encoding="utf-8")
    assert text.startswith("<!DOCTYPE html>")
    assert "accepted parts a minute" in text
    assert "A wanted pose has others" not in text
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert {file.name for file in page.parent.iterdir()} == {"block.html", "block.png"}
    again = "ros_pose_stats simulate block.stl --unit mm --cluster-tolerance 0.0025"
    assert again in text


@pytest.mark.long
def test_the_same_request_gives_the_same_page(block, tmp_path, capsys):
    pages = []
    for _ in range(2):
        run(capsys, "report", block, "--unit", "mm", "--drops", 50, "-o", tmp_path / "a.html")
        pages.append((tmp_path / "a.html").read_bytes())
    assert pages[0] == pages[1]


def test_however_many_drops_were_done_the_counts_can_be_had_again(block, tmp_path, capsys):
    import re

    from ros_pose_stats import load_part

    run(capsys, "report", block, "--unit", "mm", "--seed", 3, "-o", tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    drops = int(re.search(r"--drops (\d+) --seed 3", text)[1])
    found = simulate(load_part(block, unit="mm"), drops, seed=3)
    for pose in found.poses:
        assert f"<td>{pose.count}</td>" in text


@pytest.mark.parametrize(("words", "told"), [
    (("-o", "page.pdf"), "a file name that ends in .html"),
    (("-o", "page.html", "--wanted", "6"), "wanted poses out of 0 to 5, at least one, got 6"),
    (("-o", "page.html", "--rate", "60"), "wanted poses out of 0 to 5, at least one, got none"),
    (("-o", "page.html", "--wanted", "0", "--rate", "-1"), "a rate above 0"),
    (("-o", "page.html", "--wanted", "0", "--kick", "0.02"), "a rate of parts a minute beside"),
    (("-o", "page.html", "--png", "page.svg"), "ends in .png"),
    (("-o", "page.html", "--drops", "0"), "1 to 1000000000 drops"),
])
def test_what_cannot_be_is_refused_in_one_line_and_nothing_is_written(
        block, tmp_path, capsys, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    status, said, error = run(capsys, "report", block, "--unit", "mm", *words)
    (line,) = complaints(error)
    assert (status, said) == (2, "")
    assert told in line
    assert [file.name for file in tmp_path.iterdir()] == ["block.stl"]
