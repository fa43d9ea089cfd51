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

"""`flips`: the matrix, what a feeder gets, and refusals."""

import numpy as np
import pytest

from ros_pose_stats import learn_flips, load_part, simulate_flips
from tests.running import answer, answer_json, refusal

KICKED = "--kick", 0.05, "--flips", 200, "--seed", 5, "--wanted", 0


def test_the_object_is_the_librarys(box):
    values = answer_json("flips", *box, "--kick", 0.02, "--flips", 50, "--seed", 5)
    expected = simulate_flips(load_part(box[0], unit="mm"), 0.02, 50, seed=5).as_dict()
    timeless = {"seconds": None, "part_id": None}
    assert {**values, **timeless} == {**expected, **timeless}
    np.testing.assert_allclose(np.sum(values["transition"], axis=1), 1.0)


def test_with_wanted_poses_it_plans_the_cell(box):
    lines = answer("flips", *box, *KICKED).splitlines()
    assert lines[0] == "box: parts come singly, no plate"
    assert "box: kicked by 50 mm on a frictionless plate, restitution 0.5" in lines
    assert any(
        line.startswith("WANTED_ALIKE: pose 1 looks the same as pose 0")
        for line in lines
    )


def test_a_kick_that_frees_no_part_is_not_given(box):
    plan = answer_json("flips", *box, *KICKED[2:], "--kick", 0.0)["feeding"]
    assert set(plan["actions"]) == {"pick", "leave"}
    assert plan["flips"]["value"] == 0.0
    lines = answer("flips", *box, *KICKED[2:], "--kick", 0.0).splitlines()
    assert lines[1].endswith(
        " picked a minute, not kicked: a kick of 0 µm gains nothing"
    )


def test_counted_flips_make_the_matrix_of_a_setting(box, tmp_path):
    """The library's, for each setting; and `feeding` plans with them."""
    file = tmp_path / "flips.csv"
    file.write_text(
        "setting,from,to,count\nslow,2,0,30\nslow,2,2,10\nfast,0,4,7\nslow,2,0,5\n"
    )
    request = *box, "--counts", file, "--flips", 50, "--seed", 1
    values = answer_json("flips", *request)["settings"]
    part = load_part(box[0], unit="mm")
    slow = np.zeros((6, 6), np.int64)
    slow[2, [0, 2]] = 35, 10
    kicks = [
        simulate_flips(part, kick, 50, seed=1)
        for kick in values[0]["radius"] * np.geomspace(0.05, 5.0, 13)
    ]
    expected = learn_flips(kicks, slow, "slow").as_dict()
    assert [value["feeder_setting"] for value in values] == ["slow", "fast"]
    assert all(
        values[0][name] == expected[name]
        for name in (
            "kick_height",
            "counted_flips",
            "transition",
            "standard_error",
            "counts",
        )
    )
    plan = answer_json("feeding", *request, "--wanted", 0, "--plate", 0.3, 0.2)
    assert {value["feeder_setting"] for value in plan["options"]} == {
        "",
        "slow",
        "fast",
    }
    assert "45 flips counted at setting slow" in answer("flips", *request)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("slow,2,6,1", "poses 0 to 5"),
        ("slow,2,0", "a row of setting, from, to, count"),
        ("slow,2,0,-1", "'slow,2,0,-1' in line 1"),
    ],
)
def test_counted_flips_that_are_none_are_refused(box, tmp_path, row, words):
    file = tmp_path / "flips.csv"
    file.write_text(row)
    assert words in refusal("flips", *box, "--counts", file)


def test_refused_in_one_line(box):
    assert "kick height of 0 m or more" in refusal("flips", *box, "--kick", -1)
    assert "of 0 m or more and at most " in refusal("flips", *box, "--kick", 1e99)
