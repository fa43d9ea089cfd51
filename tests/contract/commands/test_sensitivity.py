"""`sensitivity`: the table, the JSON object, a suggestion with its files, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import load_part, sensitivity
from tests.running import answer, answer_json, refusal

ASKED = "--wanted", "2,3", "--drops", 200, "--seed", 5


@pytest.fixture(scope="module")
def suggested(box, tmp_path_factory):
    """The object with a suggestion, and the folder of its files."""
    folder = tmp_path_factory.mktemp("suggested")
    values = answer_json("sensitivity", *box, *ASKED, "--suggest", "--within", 1, "--stl",
                         folder / "hull.stl", "--png", folder / "changes.png")
    return values, folder


@pytest.fixture(scope="module")
def table(box):
    return answer("sensitivity", *box, *ASKED, "--suggest", "--within", 1)


def test_effects_are_the_librarys(box, suggested):
    values, _ = suggested
    expected = sensitivity(load_part(box[0], unit="mm"), [2, 3], drops=200, seed=5)
    assert [effect["slope"] for effect in values["effects"]] == [
        effect.slope for effect in expected.effects]
    assert {effect["unit"] for effect in values["effects"]} == {"m", "1"}
    assert values["wanted"] == [2, 3] and values["share"] == expected.share


def test_a_suggestion_gains_within_its_bound(suggested):
    suggestion = suggested[0]["suggestion"]
    assert suggestion["within"] == 1e-3
    assert suggestion["estimate"]["gain"] > 0.0
    assert "convex hull" in suggestion["judged"]


def test_the_changed_hull_and_the_picture_are_written(suggested):
    from matplotlib.image import imread

    _, folder = suggested
    part = load_part(folder / "hull.stl", unit="mm")
    # In single precision, and the bound is kept to 1e-5.
    np.testing.assert_allclose(part.surface_vertices.max(axis=0),
                               -part.surface_vertices.min(axis=0), atol=1e-8)
    size = np.ptp(part.surface_vertices, axis=0)
    assert np.abs(size - (0.02, 0.03, 0.04)).max() <= 2e-3 * (1.0 + 1e-5)
    assert imread(folder / "changes.png").std() > 0.0
    assert len(list(folder.iterdir())) == 2


class TestTable:
    def test_like_faces_share_rows(self, table):
        """Three kinds of them, and three axes twice."""
        lines = table.splitlines()
        assert lines[0].startswith("box: wanted poses 2, 3: ")
        assert sum("  points per " in line for line in lines) == 9
        assert any(line.startswith("in the order of what a step changes") for line in lines)

    def test_steps_are_in_millimetres(self, table):
        for step in ("by 1.35 mm", "by 5 % along x (1 mm)", "along z (2 mm)"):
            assert step in table

    def test_the_suggestion_is_in_words(self, table):
        assert "suggestion within 1 mm; the outline moves by" in table
        assert "stretched by" in table and "by drops: " in table

    def test_a_single_wanted_pose_is_warned_about_as_an_estimate_does(self, box):
        text = answer("sensitivity", box[0], "--wanted", 2, "--checks", 0)
        assert text.startswith("box: wanted pose 2: ")
        codes = [line.partition(": ")[0] for line in text.splitlines()
                 if line.partition(": ")[0].isupper()]
        assert codes == ["UNIT_GUESSED", "WANTED_ALIKE"]


def test_warnings_are_in_the_object(box):
    warnings = answer_json("sensitivity", box[0], "--wanted", 2, "--checks", 0)["warnings"]
    assert [line.partition(":")[0] for line in warnings] == ["UNIT_GUESSED", "WANTED_ALIKE"]


@pytest.mark.parametrize(("options", "words"), [
    (("--wanted", 9), "wanted poses out of 0 to 5"),
    (("--wanted", 0, "--suggest"), "--within with --suggest"),
    (("--wanted", 0, "--within", 1), "--suggest with --within"),
    (("--wanted", 0, "--suggest", "--within", 0), "a bound above 0"),
    (("--wanted", 0, "--suggest", "--within", 1, "--stl", "hull.obj"), "ends in .stl"),
    (("--wanted", 0, "--step", 100), "half the part's radius"),
    (("--wanted", 0, "--png", "none/"), "ends in .png"),
])
def test_refused_in_one_line(box, options, words):
    assert words in refusal("sensitivity", *box, *options)
