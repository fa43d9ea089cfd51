"""The page about variants: what it says, and how it stands in a browser."""

from __future__ import annotations

import re

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, resting_poses
from ros_pose_stats.design.compare import compare
from ros_pose_stats.plots.beside import pictures_beside
from ros_pose_stats.report.comparison_page import comparison_page
from tests.bodies import moved, random_polyhedron, rotation
from tests.browser import Browser, browser_file
from tests.design.variants import clamp, stretched


@pytest.fixture(scope="module")
def compared():
    surfaces = {"clamp": clamp(), "long <b>clamp</b>": stretched(clamp(), 1.0, 1.0, 1.4),
                "turned": moved(clamp(), rotation(3)),
                "stone": moved(random_polyhedron(8, 2), scale=0.01)}
    parts = [part_from_mesh(*one, part_id=name) for name, one in surfaces.items()]
    return compare(parts, [0, 1], 400, seed=1)


@pytest.fixture(scope="module")
def page(compared):
    return comparison_page(compared, ("ros_pose_stats compare a.stl b.stl",))


def test_it_says_what_was_found(page, compared):
    text = " ".join(re.sub(r"<style>.*?</style>|<[^>]+>", " ", page, flags=re.S).split())
    assert "Accepted are " in text and ", in the model and on a plate in " in text
    assert "C is the same body as A, turned by" in text
    assert "Wanted of A, and without a partner in D" in text
    assert "D has no such pose" in text and "A has no such pose" in text
    assert "ros_pose_stats compare a.stl b.stl" in text
    assert f"{compared.drops} drops of each variant" in text


def test_names_are_escaped(page):
    assert "<b>clamp</b>" not in page and "long &lt;b&gt;clamp&lt;/b&gt;" in page


def test_every_pair_has_its_pictures(page, compared):
    shown = sum(min(len(one.poses), 12) * 2 - sum(
        not pose.poses.is_pair for pose in one.poses[:12]) for one in compared.variants)
    assert page.count('src="data:image/png;base64,') == shown


@pytest.mark.parametrize("turn", [None, rotation(4)])
def test_a_turned_part_looks_as_the_first_one(turn):
    surface = random_polyhedron(9, 3)
    parts = [part_from_mesh(*one) for one in (
        surface, surface if turn is None else moved(surface, turn))]
    first, second = (resting_poses(one).poses for one in parts)
    radius = resting_poses(parts[0]).body.radius
    rows = [(first[k], second[k]) for k in range(3)]
    for left, right in pictures_beside(tuple(parts), turn, rows, radius, pixels=120):
        # An edge may fall on the next pixel.
        assert np.mean(np.abs(left.astype(int) - right.astype(int)).max(axis=2) > 40) < 0.02


@pytest.mark.skipif(browser_file() is None, reason="no Chromium: apt install chromium")
@pytest.mark.parametrize("width", [1200, 390])
def test_in_a_browser(page, tmp_path, width):
    file = tmp_path / "variants.html"
    file.write_text(page, encoding="utf-8")
    browser = Browser(tmp_path / "profile")
    try:
        browser.open(file.as_uri(), width, 844, phone=width < 600)
        assert browser.evaluate("document.documentElement.scrollWidth") <= width
        assert browser.evaluate("[...document.images].every(one => one.naturalWidth > 0)")
        rows = browser.evaluate("""[...document.querySelectorAll('.two')].every(one =>
            Math.abs(one.children[0].getBoundingClientRect().width
                     - one.children[1].getBoundingClientRect().width) < 2)""")
        assert rows
        assert browser.requests == [file.as_uri()] and browser.complaints == []
    finally:
        browser.close()
