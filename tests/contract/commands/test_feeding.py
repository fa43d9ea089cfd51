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

"""`feeding`: the library's plan, a table of its kicks, and refusals."""

import re

import pytest

from ros_pose_stats import FeederCell, estimate, load_part, plan_feeding, simulate_flips
from tests.running import answer, answer_json, refusal

ASKED = "--plate", "300mm", 0.2, "--flips", 60, "--kicks", 0.02, 0.005


def test_the_plan_is_the_librarys(box):
    values = answer_json(
        "feeding", *box, "--wanted", "0,1", "--clearance", 0.002, *ASKED
    )
    part = load_part(box[0], unit="mm")
    flips = [
        simulate_flips(part, kick, 60, seed=values["seed"]) for kick in (0.005, 0.02)
    ]
    plan = plan_feeding(
        estimate(part), [0, 1], FeederCell(60.0, (0.3, 0.2), 0.002), flips
    )
    assert {**values, **plan.as_dict(), "units": values["units"]} == values
    assert [option["kick_height"] for option in values["options"]] == [0.0, 0.005, 0.02]
    assert values["actions"][:2] == ["pick", "pick"] and values["plate_error"] > 0.0


def test_the_table_and_a_picture_mark_the_best_kick(box, tmp_path):
    from matplotlib.image import imread

    lines = answer(
        "feeding",
        *box,
        "--wanted",
        0,
        *ASKED,
        20,
        "--seed",
        1,
        "--png",
        tmp_path / "kicks.png",
    ).splitlines()
    assert re.fullmatch(
        "box: robot picks one part at a time, all others are kicked together; "
        r"300 × 200 mm plate, \d+ parts",
        lines[0],
    )
    assert re.match(
        r"[\d.]+ \([\d.]+ to [\d.]+\) picked a minute, kicked by .*; [\d.]+ without ",
        lines[1],
    )
    assert any(
        line.startswith("HEIGHT_SUSPECT: a kick height of 20 m") for line in lines
    )
    assert imread(tmp_path / "kicks.png").std() > 0.0
    assert sum(bool(re.search("  100 or more .*  best$", line)) for line in lines) == 1
    assert any(
        line.startswith("WANTED_ALIKE: pose 1 looks the same as pose 0")
        for line in lines
    )
    answer("feeding", *box, "--wanted", 0, *ASKED[:-1], "--png", tmp_path / "one.png")


def test_what_a_camera_takes_for_a_wanted_pose_is_warned_of(bar):
    words = "feeding", *bar, "--wanted", "0,1", *ASKED[:3], "--kicks"
    (warning,) = (
        warning
        for warning in answer_json(*words)["warnings"]
        if warning["code"] == "ALIKE_FROM_ABOVE"
    )
    shares = {
        pose["index"]: pose["probability"]
        for pose in answer_json("estimate", *bar)["poses"]
    }
    share = 100.0 * (shares[2] + shares[3])
    assert warning["acts"] and warning["text"] == (
        "poses 2, 3 look from above like poses 0, 1 and are not wanted: by the "
        f"silhouette alone {share:.1f} % of the parts would be picked wrongly."
    )
    mistaken = "pick: 0, 1, 2 and 3; poses 2, 3 by mistake, only wanted ones count"
    assert mistaken in answer(*words)
    answers = (
        answer(*words, "--pixel", "0.01mm"),
        answer("feeding", *bar, "--wanted", "0-3", *ASKED[:3], "--kicks"),
    )
    assert not any(
        words in text for text in answers for words in ("ALIKE_FROM_ABOVE", "mistake")
    )


def test_what_is_not_kicked_has_no_error_of_flips(box):
    words = "feeding", *box, "--wanted", 0, "--flips", 50
    footnotes = [
        next(line for line in text.splitlines() if line.startswith("in brackets:"))
        for text in (answer(*words), answer(*words, "--kicks", "5mm"))
    ]
    assert ["flips" in footnote for footnote in footnotes] == [False, True]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--wanted", 9, *ASKED), "wanted poses out of 0 to 5"),
        (("--wanted", 0, *ASKED, "--rate", 0), "a rate above 0"),
        (("--wanted", 0, "--plate", 0, 0.2), "a plate with sides above 0 m"),
        (("--wanted", 0, *ASKED, "--clearance", -1), "a clearance of 0 or more"),
        (("--wanted", 0, *ASKED, "--png", "kicks.jpg"), ".png"),
        (
            ("--wanted", 0, *ASKED, "--kicks", "--png", "kicks.png"),
            "--kicks with heights",
        ),
        (("--wanted", 0, "--png", "kicks.png"), "--kicks with heights"),
    ],
)
def test_refused_in_one_line(box, options, words):
    assert words in refusal("feeding", *box, *options)
