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

"""Whoever is asked about a cell, the plan is the same: `feeding`, `flips`, `report`.

The node's is set beside that of `feeding` in `tests/contract/node/test_questions.py`.
"""

import csv
import math
import re

import pytest

from lab.bodies.catalogue_parts import random_part
from tests.answers import write_stl
from tests.contract.pages.reading import Page
from tests.running import answer, answer_json

CELLS = {
    "singly": ("--rate", 40),
    "quickly kicked": ("--rate", 20, "--cycle-time", 0.2),
    "plate": ("--rate", 60, "--plate", 0.3, 0.2, "--clearance", 0.002),
    "slow hopper": ("--rate", 15, "--plate", "400mm", "300mm", "--cycle-time", 0.5),
}
SINGLY = "parts come singly, no plate"
TOGETHER = (
    r"robot picks one part at a time, (all others are kicked together|the plate is "
    r"emptied of the others); \d+ × \d+ mm plate, \d+ parts?"
)
PARTS = 12
QUICK = (1, "singly"), (1, "plate")
KICK = re.compile(r"mm: [\d.]+ a minute")
RADIUS = 0.5 * math.hypot(0.04, 0.03, 0.0298)  # of the bar, metres
UNKICKED = re.compile(r"not kicked, the best: [\d.]+ a minute")


@pytest.fixture(scope="module")
def part_of(tmp_path_factory):
    """A catalogue's part by its number: file and unit."""
    folder = tmp_path_factory.mktemp("cells")

    def write(number):
        file = folder / f"part{number}.stl"
        return write_stl(file, random_part(51, number)), "--unit", "mm"

    return write


@pytest.mark.parametrize(
    "number",
    [
        pytest.param(number, marks=pytest.mark.long if number else ())
        for number in range(PARTS)
    ],
)
def test_a_catalogue_has_the_answer_of_estimate(part_of, tmp_path, number):
    part = part_of(number)
    dropped = answer_json("estimate", *part)
    answer("catalogue", *part, "--workers", 1, "-o", tmp_path / "all")
    with (tmp_path / "all" / "poses.csv").open(encoding="utf-8", newline="") as table:
        rows = {int(row["pose"]): row for row in csv.DictReader(table)}
    for pose in dropped["poses"]:
        for name in ("probability", "probability_low", "probability_high"):
            assert float(rows[pose["index"]][name]) == pytest.approx(pose[name])


@pytest.mark.parametrize(
    ("number", "name"),
    [
        pytest.param(
            number, name, marks=() if (number, name) in QUICK else pytest.mark.long
        )
        for number in range(PARTS)
        for name in CELLS
    ],
)
def test_flips_and_feeding_say_the_same(part_of, number, name):
    """Equal numbers; and where the best plan does not kick, no single kick is given."""
    part = *part_of(number), "--wanted", 0, "--flips", 30, *CELLS[name]
    part = *part, "--seed", 7 + number
    dropped = answer_json("estimate", *part[:3], "--seed", 7 + number)
    radius = dropped["radius"]
    kicks = [0.3 * radius, radius]
    best = answer_json("feeding", *part, "--kicks", *kicks)
    assert re.fullmatch(TOGETHER if "--plate" in part else SINGLY, best["cell"])
    if name == "singly":
        shares = {pose["index"]: pose["probability"] for pose in dropped["poses"]}
        accepted = best["options"][0]["accepted"]["value"]
        assert accepted == pytest.approx(shares[0], rel=1e-12)
    for kick in kicks:
        lone = answer_json("feeding", *part, "--kicks", kick)
        flipped = answer_json("flips", *part, "--kick", kick)["feeding"]
        assert flipped["options"] == lone["options"]
        assert {**lone, **flipped, "units": lone["units"]} == lone
        assert lone["per_minute"]["value"] <= best["per_minute"]["value"]
        assert lone["kick_height"] in (0.0, kick)
        if best["kick_height"] == 0.0:
            assert lone["kick_height"] == 0.0 and "flip" not in lone["actions"]


def test_what_a_camera_mistakes_is_in_the_plan_of_the_page(bar, tmp_path):
    """Wrong parts go the same way, so that fewer good ones come a minute."""
    part = *bar, "--wanted", "0,1", "--flips", 20, *CELLS["quickly kicked"]
    file = tmp_path / "a.html"
    usual_kicks = [0.05 * RADIUS * 100.0 ** (k / 12) for k in range(13)]
    kicks = "--kicks", 0.005, *usual_kicks
    rate, sharp_rate = (
        answer_json("feeding", *part, *pixel, *kicks)["per_minute"]["value"]
        for pixel in ((), ("--pixel", "0.01mm"))
    )
    assert rate < 0.9 * sharp_rate
    answer("report", *part, "--kick", 0.005, "-o", file)
    assert f"{rate:#.3g} parts picked a minute (" in Page(file).text


@pytest.mark.long
@pytest.mark.parametrize(
    ("number", "name"),
    [(number, list(CELLS)[number % len(CELLS)]) for number in range(PARTS)],
)
def test_a_report_has_the_answer_of_estimate_and_the_plan_of_feeding(
    part_of, tmp_path, number, name
):
    """The best plan, whatever kick was typed; and no kick is marked that is none."""
    named = part_of(number)
    part = *named, "--wanted", 0, "--flips", 30, *CELLS[name]
    file = tmp_path / "a.html"
    dropped = answer_json("estimate", *named)
    radius = dropped["radius"]
    kick = 0.17 * radius
    usual_kicks = [0.05 * radius * 100.0 ** (k / 12) for k in range(13)]
    answer("report", *part, "--kick", kick, "-o", file)
    best = answer_json("feeding", *part, "--kicks", kick, *usual_kicks)
    page = Page(file)
    check_shares(page, dropped)
    is_kicking = best["kick_height"] > 0.0
    assert f"can be dropped a minute: {best['cell']}." in page.text
    assert f"{best['per_minute']['value']:#.3g} parts picked a minute (" in page.text
    assert ("), not kicked, where" in page.text) != is_kicking
    (picture,) = page.named("Parts picked a minute over the kick height")
    words = " ".join(picture.words)
    assert bool(KICK.search(words)) == is_kicking
    assert bool(UNKICKED.search(words)) != is_kicking


def check_shares(page, dropped):
    """Card and table of each pose that stands alone have the row of `estimate`."""
    groups = [pose["group"] for pose in dropped["poses"]]
    for pose in dropped["poses"]:
        low, high = pose["probability_low"], pose["probability_high"]
        if groups.count(pose["group"]) > 1 or not 0.01 < low < high < 0.99:
            continue
        share = f"{100.0 * pose['probability']:.1f} %"
        interval = f"{100.0 * low:.1f} to {100.0 * high:.1f} %"
        assert f"Pose {pose['index']} {share} 90 % interval {interval}" in page.text
        assert f"pose {pose['index']} {share} ({interval})" in page.text
