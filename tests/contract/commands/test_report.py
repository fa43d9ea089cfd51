"""`report`: files that are written, counts that can be had again, and refusals."""

import re

import pytest

from ros_pose_stats import load_part, simulate
from tests.running import answer, refusal


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


def test_however_many_drops_were_done_the_page_says_how_to_have_them_again(
    box, written
):
    page = (written[1] / "box.html").read_text(encoding="utf-8")
    drops = int(
        re.search(
            r"ros_pose_stats simulate box.stl --unit mm .*--drops (\d+) --seed 3", page
        )[1]
    )
    for pose in simulate(load_part(box[0], unit="mm"), drops, seed=3).poses:
        assert f"<td>{pose.count}</td>" in page


def test_the_same_request_gives_the_same_page(box, written):
    page = written[1] / "box.html"
    before = page.read_bytes()
    answer("report", *box, "--seed", 3, "-o", page)
    assert page.read_bytes() == before


@pytest.mark.parametrize(
    ("options", "words"),
    [
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
