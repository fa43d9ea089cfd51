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

"""`sensitivity`: the table, the JSON object, a suggestion with its files, and
refusals.
"""

import re

import numpy as np
import pytest

from ros_pose_stats import load_part, sensitivity, simulate
from tests.running import answer, answer_json, refusal

ASKED = (
    *("--wanted", "2,3", "--step", "4mm"),
    *("--checks", 3, "--drops", 1600, "--seed", 5),
)
"""Steps so large that few drops are sure of them."""


@pytest.fixture(scope="module")
def suggested(box, tmp_path_factory):
    """The object with a suggestion, and the folder of its files."""
    folder = tmp_path_factory.mktemp("suggested")
    values = answer_json(
        "sensitivity",
        *box,
        *ASKED,
        "--suggest",
        "--within",
        "1mm",
        "--stl",
        folder / "hull.stl",
        "--png",
        folder / "changes.png",
    )
    return values, folder


@pytest.fixture(scope="module")
def table(box):
    return answer("sensitivity", *box, *ASKED, "--suggest", "--within", 0.001)


def test_effects_are_the_librarys(box, suggested):
    values, _ = suggested
    part = load_part(box[0], unit="mm")
    expected = sensitivity(part, [2, 3], step=0.004, checks=0)
    assert [effect["slope"] for effect in values["effects"]] == [
        effect.slope for effect in expected.effects
    ]
    assert {(effect["unit"], effect["slope_unit"]) for effect in values["effects"]} == {
        ("m", "1/m"),
        ("1", "1"),
    }
    assert values["wanted"] == [2, 3]


def test_the_part_as_it_is_has_the_answer_of_estimate(box, suggested):
    values, _ = suggested
    answer = answer_json("estimate", *box, "--seed", 5)
    wanted = [pose for pose in answer["poses"] if pose["index"] in (2, 3)]
    assert values["method"] == answer["method"]
    for share, name in (
        ("share", "probability"),
        ("share_low", "probability_low"),
        ("share_high", "probability_high"),
    ):
        total = sum(pose[name] for pose in wanted)
        assert values[share] == pytest.approx(total, rel=1e-12)


def test_a_suggestion_gains_within_its_bound(suggested):
    suggestion = suggested[0]["suggestion"]
    assert suggestion["within"] == 1e-3 and "step" not in suggestion["units"]
    assert all(
        abs(change["step"]) > 1e-6
        for step in suggestion["steps"]
        for change in step["changes"]
    )
    assert suggestion["estimate"]["gain"] > 0.0
    assert "convex hull" in suggestion["judged"]


def test_the_changed_hull_and_the_picture_are_written(suggested):
    from matplotlib.image import imread

    _, folder = suggested
    part = load_part(folder / "hull.stl", unit="mm")
    # In single precision, and the bound is kept to 1e-5.
    np.testing.assert_allclose(
        part.surface_vertices.max(axis=0), -part.surface_vertices.min(axis=0), atol=1e-8
    )
    size = np.ptp(part.surface_vertices, axis=0)
    assert np.abs(size - (0.02, 0.03, 0.04)).max() <= 2e-3 * (1.0 + 1e-5)
    assert imread(folder / "changes.png").std() > 0.0
    assert len(list(folder.iterdir())) == 2


def test_the_changed_hull_has_the_gain_with_the_centre_of_mass_that_is_told(
    suggested, table
):
    values, folder = suggested
    words = re.search(
        r"^with the hull of --stl: --com (\S+)mm (\S+)mm (\S+)mm$", table, re.M
    )
    center = [1e-3 * float(word) for word in words.groups()]
    np.testing.assert_allclose(
        center, values["suggestion"]["center_of_mass"], atol=1e-6
    )
    part = load_part(folder / "hull.stl", unit="mm", center_of_mass=center)
    dropped = simulate(part, 2000, seed=5).column("probability")
    assert values["wanted"] == [2, 3]
    after = values["suggestion"]["by_drops"]["after"]
    assert after["low"] - 0.02 < dropped[2] + dropped[3] < after["high"] + 0.02


class TestTable:
    def test_it_says_first_what_gains_most_and_of_all_others_that_it_is_not_sure(
        self, table, suggested
    ):
        first, *lines = table.splitlines()
        checks = [
            effect for effect in suggested[0]["effects"] if effect["check"] is not None
        ]
        best = max(checks, key=lambda effect: effect["check"]["change"])
        change = f"{100.0 * best['check']['change']:+.1f} points by drops ("
        assert first.startswith("gains most: ") and change in first and best["gains"]
        ends = ("  not sure", "  drops contradict the estimate")
        remarks = [line for line in lines if line.endswith(ends)]
        assert len(remarks) == sum(not effect["gains"] for effect in checks)
        assert f"{suggested[0]['drops']} drops of the part before and after" in table
        assert "\na gain is sure where chance alone shows one in at most" in table

    def test_the_suggestion_is_in_words_with_the_gain_of_each_step(
        self, table, suggested
    ):
        assert "suggestion within 1 mm: " in table and "the outline moves by" in table
        suggestion = suggested[0]["suggestion"]
        gains = [step["estimated"] for step in suggestion["steps"]]
        assert 0 < len(gains) <= 3 and min(gains) >= 0.003
        assert sum(gains) == pytest.approx(suggestion["estimate"]["gain"])

    def test_nothing_to_gain_is_said(self, box):
        text = answer("sensitivity", *box, "--wanted", "0-5", "--drops", 50)
        assert text.startswith(
            "nothing to gain: no step of 1.35 mm or 5 % gains more than"
        )

    def test_a_single_wanted_pose_is_warned_about_as_an_estimate_does(self, box):
        request = "sensitivity", box[0], "--wanted", 2, "--checks", 0
        text = answer(*request)
        warnings = answer_json(*request)["warnings"]
        assert "\nbox: wanted pose 2: " in text and "\nreleased 539 mm above a " in text
        assert [warning["code"] for warning in warnings] == [
            "UNIT_GUESSED",
            "WANTED_ALIKE",
        ]
        lines = [f"{warning['code']}: {warning['text']}" for warning in warnings]
        assert "\n".join(lines) in text


def test_wanted_shares_are_set_beside_the_estimated_ones(box):
    request = (*box, "--target", "0,1=1/3", "2,3=1/3", "4,5=1/3")
    values = answer_json("sensitivity", *request, "--checks", 0)
    assert [target["poses"] for target in values["target"]] == [[0, 1], [2, 3], [4, 5]]
    shares = [target["share"] for target in values["target"]]
    met = sum(min(share, 1 / 3) for share in shares)
    assert values["share"] == pytest.approx(met) and sum(shares) == pytest.approx(1.0)
    table = answer("sensitivity", *request, "--drops", 300, "--seed", 1)
    assert f"met to {100.0 * met:.1f} %" in table
    for poses, share in zip(("0, 1", "2, 3", "4, 5"), shares, strict=True):
        assert re.search(rf"^  {poses} +33\.3 +{100.0 * share:.1f}$", table, re.M)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--wanted", 0, "--suggest"), "--within with --suggest"),
        (("--wanted", 0, "--within", "1mm"), "--suggest with --within"),
        (
            ("--wanted", 0, "--suggest", "--within", "1mm", "--stl", "hull.obj"),
            "ends in .stl",
        ),
        (("--wanted", 0, "--png", "none/"), "ends in .png"),
        ((), "--wanted --target"),
        (("--wanted", 0, "--target", "0-5=1"), "not allowed with"),
        (("--target", "0-5"), "poses and their share, for instance 0,1=30% or 2=1/3"),
        (("--target", "0-5=1/0"), "poses and their share"),
        (("--target", "0=50%", "0=50%"), "the same poses twice"),
        (("--target", "0,1=50%", "2-4=50%"), "none for pose 5"),
        (("--target", "0,1=50%", "2-5=40%"), "a sum of 0.9"),
    ],
)
def test_refused_in_one_line(box, options, words):
    assert words in refusal("sensitivity", *box, *options)
