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

"""Where methods fail: the walks through each trouble, on a page that names the failing
ones.
"""

import numpy as np
import pytest

from tests.answers import METHODS
from tests.running import strict_json

from .programs import assert_drawn, study

pytestmark = pytest.mark.long

OLD = ("area", "csae", "adre", "qse")
"""Estimators that jump where a face becomes unstable."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stability") / "docs"
    study("stability", "--quick", "-o", folder)
    return folder


@pytest.fixture(scope="module")
def results(folder):
    return strict_json((folder / "measured" / "numbers" / "stability.json").read_text())


@pytest.fixture(scope="module")
def walks(results):
    return {walk["name"]: walk for walk in results["walks"]}


@pytest.fixture(scope="module")
def sections(folder, walks):
    """What the page says of each walk."""
    page = (folder / "measured" / "stability.md").read_text(encoding="utf-8")
    assert "nan" not in page
    return dict(zip(walks, page.split("\n## ")[1:], strict=False))


def methods(walk):
    return {entry["method"]: entry for entry in walk["methods"]}


def test_the_page_names_the_failing_ones_of_every_walk_beside_its_figure(
    walks, sections, folder
):
    """By number and largest size of the jumps of each method."""
    assert len(walks) > 10 and sections.keys() == walks.keys()
    for name, walk in walks.items():
        assert sections[name].startswith(walk["title"])
        assert f"(../figures/stability_{name}.png)" in sections[name]
        assert_drawn(folder / "figures" / f"stability_{name}.png")
        assert tuple(methods(walk)) == METHODS
        rows = [line for line in sections[name].splitlines() if line.startswith("| ")]
        for entry, row in zip(walk["methods"], rows[-len(METHODS) :], strict=True):
            cells = [cell.strip() for cell in row.strip("|").split("|")]
            jumps = [abs(jump["size"]) for jump in entry["jumps"]]
            assert int(cells[1]) == len(jumps)
            assert cells[2] == (f"{100 * max(jumps):.1f}" if jumps else "")


def test_a_marginal_face_makes_the_older_ones_jump_at_the_edge_of_its_base(walks):
    leaning = methods(walks["marginal_face"])
    for name in OLD:
        (jump,) = leaning[name]["jumps"]
        assert jump["at"] == pytest.approx(1.0, abs=1e-6) and jump["size"] < -0.02
    for name in ("eae", "meae"):
        assert leaning[name]["jumps"] == [] and leaning[name]["probability"][-1] == 0.0


def test_plate_needle_and_cube_stand_as_they_must(walks):
    """Where length over width is a, the square faces have 1 - O(a) and O(1/a)."""
    for entry in (*walks["needle"]["methods"], walks["needle"]["simulation"]):
        assert entry["probability"][0] > 0.97 and entry["probability"][-1] < 0.01
    walk = walks["broken_symmetry"]
    for entry in walk["methods"]:
        assert entry["probability"][0] == pytest.approx(1.0 / 6.0, abs=1e-7)
    # The error of the drops at the first value, four of it.
    settled = walk["simulation"]["settled"][0]
    assert walk["simulation"]["probability"][0] == pytest.approx(
        1.0 / 6.0, abs=4.0 * np.sqrt(5.0 / 36.0 / settled)
    )


def test_cylinders_and_gears_are_round_from_some_number_of_sides_on(walks):
    """A cylinder as high as wide: the discs' solid angle, however many sides the file
    has.
    """
    walk = walks["cylinder_sides"]
    fine = np.array(walk["values"]) >= 15
    assert set(np.array(walk["poses"])[fine]) == {3}
    csae = np.array(methods(walk)["csae"]["probability"])[fine]
    assert csae == pytest.approx(np.full(fine.sum(), 1.0 - np.sqrt(0.5)), abs=2e-3)
    assert (walks["gear_teeth"]["poses"][0] > 3) and walks["gear_teeth"]["poses"][
        -1
    ] == 3


def test_holes_and_nudges_change_what_they_must(walks):
    """A blind hole makes the closed end heavier, a larger nudge lists fewer poses."""
    for name, entry in methods(walks["hole_size"]).items():
        if name != "area":  # of the hull, which stays
            assert entry["probability"][-1] > entry["probability"][0] + 0.01, name
    assert np.all(np.diff(walks["nudge"]["poses"]) <= 0)
    for name in OLD:
        assert np.all(
            np.diff(methods(walks["nudge"])[name]["probability"]) >= -1e-12
        ), name


def test_scenes_move_those_alone_that_know_them(walks):
    for name in ("restitution", "rocking", "drop_height"):
        for method, entry in methods(walks[name]).items():
            assert (np.ptp(entry["probability"]) == 0.0) == (method != "split")


def test_larger_expected_errors_mean_larger_true_ones(results):
    """From the lowest bin to the highest; and each within a third, or three errors."""
    assert set(results["reliability"]) == {*METHODS, "simulation, n = 100"}
    for name, bins in results["reliability"].items():
        assert np.all(np.diff([entry["expected"] for entry in bins]) >= 0.0)
        assert bins[-1]["true"] > 1.3 * bins[0]["true"], name
        for entry in bins:
            difference = abs(entry["true"] - entry["expected"])
            assert difference < entry["expected"] / 3 + 3 * entry["error"]
