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

"""The page about a part: one story, that of the estimated drops, in numbers and in
pictures.
"""

import math
import re
from html import unescape

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.variants import subdivided
from ros_pose_stats import load_part, sensitivity
from tests.answers import METHODS, write_stl
from tests.running import answer, answer_json

from .reading import Page, Picture

AREAS = (12.0, 8.0, 6.0)
"""Of the faces of the box, in hundreds of square millimetres."""


@pytest.fixture(scope="module")
def kinds(estimated):
    """Poses by what symmetry makes alike, with totals: (numbers, pose)."""
    poses = sorted(estimated["poses"], key=lambda pose: pose["index"])
    return [((pose["index"], pose["index"] + 1), pose) for pose in poses[::2]]


def percent(share):
    return f"{100.0 * share:.1f} %"


def test_it_is_one_file_that_asks_for_nothing(report, clamp, comparison):
    for page, file in (report, clamp, comparison[:2]):
        assert page.needs_nothing()
        assert file.stat().st_size < 3e6


def test_the_first_sentence_names_the_scene_and_the_commonest_pose(report, estimated):
    page, _ = report
    scene = estimated["scene"][0].upper() + estimated["scene"][1:]
    assert f"{scene}, this part comes to rest in 6 stable poses of 3 kinds" in page.text
    best = max(pose["group_probability"] for pose in estimated["poses"])
    assert f"{percent(best)} of the dropped parts (90 % interval " in page.text
    source = f"by the best estimate and {estimated['drops']} simulated drops"
    assert f"), {source}." in page.text


def test_like_poses_have_a_picture_and_their_total(report, kinds):
    page, _ = report
    pictures = [picture.name for picture in page.named("The part in pose")]
    assert len(pictures) == 3
    for (first, second), pose in kinds:
        total = percent(pose["group_probability"])
        assert (
            f"The part in poses {first}, {second}, {total} of the dropped parts"
            in pictures
        )
        for number in (
            f"each of 2, about {percent(pose['group_probability'] / 2)}",
            f"{1e3 * pose['height']:.4g} mm",
            f"{1e3 * pose['barrier']:.4g} mm",
            f"{math.degrees(pose['margin']):.3g}°",
            "every 180° of yaw",
        ):
            assert number in page.text


def test_a_part_has_one_answer_on_a_page(report, estimated):
    """First box, card, both tables and bar: the rows of `estimate`, ends and all."""
    page, _ = report
    totals = {}
    for pose in estimated["poses"]:
        rows = totals.setdefault(pose["group"], np.zeros(3))
        rows += [
            pose["probability"],
            pose["probability_low"],
            pose["probability_high"],
        ]
    (best, *others) = sorted(totals.values(), key=lambda row: -row[0])
    text = page.text + unescape(page.source).replace("\xa0", " ")
    # Card and two tables; the best, which is wanted, in the first box and the changes.
    for total, places in ((best, 3), *((total, 0) for total in others)):
        share, low, high = 100.0 * total
        interval = f"{low:.1f} to {high:.1f} %"
        assert f"{share:.1f} % ({interval})" in page.text
        assert f"{share:.1f} %, 90 % interval {interval}" in text
        assert page.text.count(interval) == 3 + places
    share, low, high = 100.0 * best
    as_it_is = f"{share:.1f} % [{low:.1f} to {high:.1f} %] by {estimated['method']}"
    assert f"As it is: wanted poses 0, 1: {as_it_is}." in page.text
    assert f"{100.0 * best[0]:.1f} % of the dropped parts lie in the" in page.text


def test_each_pose_is_listed_on_demand_with_its_count(report, estimated):
    (hidden,) = re.findall(r"<details>(.*?)</details>", report[0].source, re.DOTALL)
    rows = [
        re.findall(r"<td>(.*?)</td>", row, re.DOTALL)
        for row in re.findall(r"<tr>(.*?)</tr>", hidden, re.DOTALL)[1:]
    ]
    assert [(int(row[0]), int(row[1]), int(row[4])) for row in rows] == [
        (pose["index"], pose["group"], pose["count"]) for pose in estimated["poses"]
    ]


def test_every_method_tells_every_total(report, kinds):
    titles = unescape(report[0].source).replace("\xa0", " ")
    for method in ("default answer", *METHODS):
        for (first, second), _ in kinds:
            assert f'title="{method}, poses {first}, {second}: ' in titles
    for ((first, second), _), area in zip(kinds, AREAS, strict=True):
        share = percent(area / sum(AREAS))
        assert f'title="area, poses {first}, {second}: {share}' in titles


def test_the_splitting_graph_has_the_levels_of_the_edges_and_the_shares_of_the_table(
    report, estimated
):
    """A box goes from face to face over its edges: half the diagonals of the sides
    between.
    """
    (picture,) = report[0].named("Splitting graph")
    words = picture.words
    for level in (math.hypot(15.0, 10.0), math.hypot(20.0, 10.0)):
        assert f"{level:.2f}" in words
    for pose in estimated["poses"]:
        assert str(pose["index"]) in words and percent(pose["probability"]) in words


def test_the_first_box_has_the_best_plan_and_not_the_kick_that_was_typed(
    report, parts, estimated
):
    """It is that of `feeding`, asked for all kicks that the page looks at."""
    page, _ = report
    usual_kicks = estimated["radius"] * np.geomspace(0.05, 5.0, 13)
    cell = parts / "box.stl", "--unit", "mm", "--wanted", "0,1", "--flips", 100
    plan = answer_json("feeding", *cell, "--kicks", 0.02, *usual_kicks)
    value, low, high = plan["per_minute"].values()
    kick = f"kicked by {1e3 * plan['kick_height']:.3g} mm"
    assert plan["kick_height"] not in (0.0, 0.02)
    accepted, passes = (
        plan["options"][0][name]["value"] for name in ("accepted", "passes")
    )
    assert f"{percent(accepted)} of the dropped parts lie in the accepted" in page.text
    # The table beside it says the same of these poses.
    row = rf"poses 0, 1 {percent(accepted)} \([^()]*\) {passes:#.3g} "
    assert re.search(row, page.text.replace("–", ", "))
    assert (
        f"{value:#.3g} parts picked a minute ({low:#.3g} to {high:#.3g}), {kick}, "
        f"where 60 can be dropped a minute: {plan['cell']}."
    ) in page.text
    without_kick, own = (
        next(
            option["per_minute"]["value"]
            for option in plan["options"]
            if option["kick_height"] == height
        )
        for height in (0.0, 0.02)
    )
    others = (
        f"{without_kick:#.3g} a minute without kicks, {own:#.3g} with one of 20 mm."
    )
    assert others in page.text
    assert "Feeding: dropped again or flipped" in page.text
    (picture,) = page.named("Parts picked a minute over the kick height")
    assert any(f"mm: {value:.3g} a minute" in words for words in picture.words)
    assert "A wanted pose has others" not in page.text


def test_changes_are_in_a_table_and_on_the_part(report):
    page, _ = report
    assert "Which change of the part feeds better" in page.text
    assert "What a step gains" in page.text
    assert page.named(
        "The part from two sides, coloured where to add and where to take away"
    )


@pytest.mark.long
def test_changes_are_those_of_the_command_and_the_library(report, parts):
    page, _ = report
    _, _, changes = page.text.partition("Which change of the part feeds better ")
    gain, goal, *_ = answer(
        "sensitivity", parts / "box.stl", "--unit", "mm", "--wanted", "0,1"
    ).splitlines()
    goal = goal.removeprefix("box: ").removesuffix(", in brackets 90 % intervals")
    assert changes.lower().startswith(gain) and f"As it is: {goal}." in changes
    by_library = sensitivity(load_part(parts / "box.stl", unit="mm"), [0, 1])
    assert by_library.describe_gain() == gain
    assert by_library.describe_goal() == goal


def test_all_can_be_had_again(report, estimated):
    page, _ = report
    assert "ros_pose_stats report box.stl --unit mm" in page.text
    assert "ros_pose_stats estimate box.stl --unit mm" in page.text
    assert estimated["part_digest"] in page.text


def test_a_part_without_symmetry_has_a_picture_a_pose(clamp):
    page, _ = clamp
    assert len(page.named("The part in pose ")) == 7
    assert "<details>" not in page.source and "Feeding: dropped" not in page.text


def test_warnings_come_in_plain_words(parts, tmp_path):
    answer(
        "report",
        parts / "cylinder.stl",
        "--unit",
        "mm",
        "--drops",
        50,
        "--wanted",
        1,
        "--drop-height",
        0.03,
        "-o",
        tmp_path / "a.html",
    )
    text = Page(tmp_path / "a.html").text
    for words in (
        "A wanted pose has others that look the same",
        "tilt to topple across its axis",
        "at any yaw",
    ):
        assert words in text
    assert text.count("* The part rolls in this pose") == 1
    assert text.count("The part is released low") == 1  # though nine methods say so


def test_large_lengths_have_no_exponent_and_stay_with_their_units(tmp_path):
    write_stl(tmp_path / "hall.stl", shapes.box(22.0, 18.0, 14.0))
    answer(
        "report",
        tmp_path / "hall.stl",
        "--unit",
        "m",
        "--drops",
        50,
        "-o",
        tmp_path / "a.html",
    )
    page = Page(tmp_path / "a.html")
    assert "22000 × 18000 × 14000\xa0mm" in unescape(page.source)
    assert not re.search(r"\de[+-]\d", page.text)
    assert not re.findall(r"<(?:p|dd)\b[^>]*>[^<]*\d (?:mm\b|%)", unescape(page.source))


def test_names_of_parts_cannot_write_html_and_are_cut_to_the_width_of_the_figure(
    parts, tmp_path
):
    name = "<b>&'" + 40 * "W$_"
    (tmp_path / f"{name}.stl").write_bytes((parts / "box.stl").read_bytes())
    answer(
        "report",
        tmp_path / f"{name}.stl",
        "--unit",
        "mm",
        "--drops",
        20,
        "-o",
        tmp_path / "a.html",
        "--png",
        tmp_path / "a.png",
    )
    page = Page(tmp_path / "a.html")
    assert "<b>&" not in page.source and f"{name}: how it comes to rest" in page.text
    pixels = Picture("key figure", (tmp_path / "a.png").read_bytes()).pixels
    assert (pixels[:, :5] == 255).all() and (pixels[:, -5:] == 255).all()


def test_the_page_of_a_fine_part_stays_small(tmp_path):
    surface = shapes.box(20.0, 30.0, 40.0)
    for _ in range(6):
        surface = subdivided(surface)
    assert len(surface[1]) > 40_000
    write_stl(tmp_path / "fine.stl", surface)
    answer(
        "report",
        tmp_path / "fine.stl",
        "--unit",
        "mm",
        "--drops",
        50,
        "-o",
        tmp_path / "a.html",
    )
    assert (tmp_path / "a.html").stat().st_size < 3e6


def test_poses_stand_whole_on_white_paper(report):
    for picture in report[0].named("The part in pose"):
        pixels = picture.pixels
        rim = np.concatenate([pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]])
        assert (rim == 255).all()
        assert (np.ptp(pixels, axis=2) > 20).mean() > 0.03  # blue is no grey
