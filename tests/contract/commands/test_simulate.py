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

"""`simulate`: the table, the JSON object and the refusals."""

import math

import pytest
from scipy import stats

from ros_pose_stats import load_part, simulate
from tests.running import answer, answer_json, refusal

from .tables import table_head, table_rows

ASKED = "--drops", 300, "--seed", 5


@pytest.fixture(scope="module")
def table(box):
    return answer("simulate", *box, *ASKED)


@pytest.fixture(scope="module")
def values(box):
    return answer_json("simulate", *box, *ASKED)


def test_the_table_says_what_was_done(table):
    lines = table.splitlines()
    assert lines[:2] == [
        "box: released 539 mm above a frictionless plate, restitution 0.5",
        "6 stable poses in 3 groups, 12 triangles, 20 x 30 x 40 mm",
    ]
    assert "300 drops, 0 unsettled, seed 5," in lines
    assert "computed in" in lines[-1]


def test_the_columns_are_those_of_an_estimate_and_the_drops(box, table):
    estimated = answer("estimate", *box, "--method", "split")
    names = [
        "poses",
        "number",
        "group",
        "probability",
        "90 % interval",
        "drops",
        "height",
        "barrier",
        "topple",
        "down",
    ]
    assert table_head(table) == names
    assert table_head(estimated) == [name for name in names if name != "drops"]
    downs, others = (
        {row["poses"]: row["down"] for row in table_rows(text)}
        for text in (table, estimated)
    )
    assert downs == others and downs["0, 1"] == "(-1.000, +0.000, +0.000)"


def test_rows_of_each_pose_are_those_of_the_object(box, values):
    rows = table_rows(answer("simulate", *box, *ASKED, "--each"))
    for row, pose in zip(rows, values["poses"], strict=True):
        assert row["probability"].startswith(f"{100.0 * pose['probability']:.2f}%")
        assert {
            name: row[name] for name in row if name not in ("probability", "down")
        } == {
            "pose": str(pose["index"]),
            "group": str(pose["group"]),
            "90 % interval": f"{100.0 * pose['probability_low']:.2f} - "
            f"{100.0 * pose['probability_high']:.2f}",
            "drops": str(pose["count"]),
            "height": f"{1e3 * pose['height']:.4g}",
            "barrier": f"{1e3 * pose['barrier']:.4g}",
            "topple": f"{math.degrees(pose['margin']):.2f}",
        }


def test_drops_of_like_poses_are_added(table, values):
    for row in table_rows(table):
        count = sum(
            pose["count"]
            for pose in values["poses"]
            if str(pose["group"]) == row["group"]
        )
        assert row["drops"] == str(count)
        bounds = 100.0 * stats.beta(count + 0.5, 300 - count + 0.5).ppf([0.05, 0.95])
        assert [float(x) for x in row["90 % interval"].split(" - ")] == pytest.approx(
            bounds.tolist(), abs=0.0051
        )


def test_the_object_says_what_was_done(values):
    assert (values["method"], values["drops"]) == ("simulation", 300)
    assert sum(pose["count"] for pose in values["poses"]) + values["unsettled"] == 300


def test_it_is_the_librarys_answer_whatever_the_workers(box):
    values = answer_json(
        "simulate",
        *box,
        "--drops",
        400,
        "--seed",
        9,
        "--restitution",
        0.2,
        "--drop-height",
        0.1,
        "--workers",
        3,
    )
    expected = simulate(
        load_part(box[0], unit="mm"), 400, 0.2, 9, 0.1, workers=1
    ).as_dict()
    assert {**values, "seconds": None} == {**expected, "seconds": None}


def test_a_fresh_seed_is_reported_and_repeats_the_run(box):
    first = answer_json("simulate", *box, "--drops", 100)
    repeated = answer_json("simulate", *box, "--drops", 100, "--seed", first["seed"])
    assert first["poses"] == repeated["poses"]
    assert answer_json("simulate", *box, "--drops", 100)["seed"] != first["seed"]


def test_a_target_ends_the_run_early_or_is_missed_aloud(box):
    reached = answer_json("simulate", *box, "--target-error", 0.02, "--seed", 1)
    assert (
        reached["drops"] < 10_000
        and reached["expected_error"] <= 0.02
        and reached["warnings"] == []
    )
    missed = answer_json("simulate", *box, "--drops", 200, "--target-error", 0.001)
    assert missed["drops"] == 200
    assert [warning["code"] for warning in missed["warnings"]] == ["TARGET_MISSED"]


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--drops", "0", "1 to 1000000000 drops, got 0"),
        ("--drops", "1e10", "1 to 1000000000 drops, got 10000000000"),
        ("--restitution", "1", "restitution"),
        ("--drop-height", "-1", "drop height"),
        ("--seed", "-1", "seed"),
        ("--workers", "0", "workers"),
        ("--target-error", "1", "target error"),
        ("--target-error", "nan", "target error"),
    ],
)
def test_refused_in_one_line(box, option, value, words):
    assert words in refusal("simulate", *box, option, value)
