"""`flips`: the matrix, what a feeder gets, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import load_part, simulate_flips
from tests.running import answer, answer_json, refusal

KICKED = "--kick", 0.05, "--flips", 200, "--drops", 500, "--seed", 5, "--wanted", "0,1"


def test_the_object_is_the_librarys(box):
    values = answer_json("flips", *box, "--kick", 0.02, "--flips", 50, "--seed", 5)
    expected = simulate_flips(load_part(box[0], unit="mm"), 0.02, 50, seed=5).as_dict()
    timeless = {"seconds": None, "part_id": None}
    assert {**values, **timeless} == {**expected, **timeless}
    np.testing.assert_allclose(np.sum(values["transition"], axis=1), 1.0)


def test_kicks_are_set_beside_dropping_again(box):
    feeding = answer_json("flips", *box, *KICKED)["feeding"]
    again, kicked = feeding["dropped_again"], feeding["kicked"]
    assert again["per_minute"]["value"] == pytest.approx(60.0 * again["accepted"]["value"])
    assert again["passes"]["value"] == pytest.approx(1.0 / again["accepted"]["value"])
    assert kicked["accepted"]["value"] == 1.0 and kicked["flips"]["value"] > 0.0
    for number in (*again.values(), *kicked.values()):
        assert number["low"] <= number["value"] <= number["high"]
    lines = answer("flips", *box, *KICKED).splitlines()
    assert lines[0] == "box: kicked by 50 mm on a frictionless plate, restitution 0.5"
    assert any(line.strip().startswith("kicked") for line in lines)


def test_wanted_poses_of_which_symmetry_has_more_are_pointed_out(box):
    asked = ("flips", *box, "--kick", 0.05, "--flips", 20, "--drops", 100, "--seed", 5,
             "--wanted", 0)
    warning = "WANTED_ALIKE: pose 1 looks the same as pose 0"
    assert warning in answer(*asked)
    assert warning in answer_json(*asked)["warnings"][-1]


@pytest.mark.parametrize(("options", "words"), [
    (("--kick", -1), "kick height of 0 m or more"),
    (("--kick", 0.01, "--wanted", 9), "wanted poses out of 0 to 5"),
    (("--kick", 0.01, "--wanted", "0", "--rate", 0), "a rate above 0"),
])
def test_refused_in_one_line(box, options, words):
    assert words in refusal("flips", *box, "--flips", 20, "--drops", 20, *options)
