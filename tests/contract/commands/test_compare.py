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

"""`compare`: the table, the JSON object, names of variants, and refusals."""

import re
from pathlib import Path

import pytest
import trimesh

from lab.bodies import shapes
from ros_pose_stats import compare, load_part
from tests.answers import write_stl
from tests.running import answer, answer_json, refusal

ASKED = "--unit", "mm", "--seed", 5
CENTERS = "--com", 0.0, 0.0, 0.0, "--com", 0.0, 0.0, "-4mm"


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    """Boxes 20 x 30 x 16 and 20 x 30 x 24 about their middles."""
    folder = tmp_path_factory.mktemp("variants")
    for name, height in (("flat", 16.0), ("high", 24.0)):
        vertices, triangles = shapes.box(20.0, 30.0, height)
        middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        write_stl(folder / f"{name}.stl", (vertices - middle, triangles))
    return folder / "flat.stl", folder / "high.stl"


def test_the_object_is_the_librarys(boxes):
    values = answer_json("compare", *boxes, *ASKED, "--drops", 300, "--wanted", "0,1")
    parts = [load_part(file, "mm") for file in boxes]
    expected = compare(parts, [0, 1], 300, seed=5).as_dict()
    assert values.keys() == expected.keys()
    assert values["comparisons"] == expected["comparisons"]
    assert [variant["part_id"] for variant in values["variants"]] == ["flat", "high"]


def test_the_table_begins_with_the_verdict_and_the_parts(boxes):
    lines = answer(
        "compare", *boxes, *ASKED, "--drops", 1250, "--wanted", "0,1"
    ).splitlines()
    assert re.fullmatch(
        r"A feeds better: [\d.]+ % accepted, B [\d.]+ % \(\+[\d.]+ points, "
        r"[\d.]+ to [\d.]+\); large enough to expect on a real plate",
        lines[0],
    )
    assert lines[2:4] == [
        "A flat: 6 stable poses, radius 19.72 mm",
        "B high: 6 stable poses, radius 21.66 mm",
    ]
    assert any(
        line.startswith("1250 drops of each from the same starts, 0 unsettled, seed 5;")
        for line in lines
    )


def test_what_does_not_differ_is_said_first(boxes):
    request = "compare", boxes[0], boxes[0], *ASKED, "--drops", 50
    assert answer(*request).startswith(
        "50 drops of each show no difference of A and B: no"
    )
    assert answer(*request, "--wanted", "0").startswith(
        "50 drops of each show no difference in feeding: "
    )


@pytest.mark.long
def test_the_unit_is_for_files_that_declare_none(tmp_path):
    files = [tmp_path / "box.3mf", tmp_path / "box.stl"]
    for file, length in zip(files, (80.0, 8.0), strict=True):
        trimesh.creation.box((length, 0.5 * length, 0.4 * length)).export(file)
    text = answer("compare", *files, "--unit", "cm", "--drops", 250, "--seed", 5)
    assert {line.rpartition(", ")[2] for line in text.splitlines()[2:4]} == {
        "radius 47.5 mm"
    }
    assert "UNIT_OVERRIDDEN" not in text


def test_wanted_poses_of_which_symmetry_has_more_are_pointed_out(boxes):
    request = "compare", *boxes, *ASKED, "--drops", 300, "--wanted"
    sentences = [
        "pose 3 looks the same as pose 2 (symmetry)",
        "pose 1 looks the same as pose 0 (symmetry)",
    ]
    values = answer_json(*request, "2")
    assert [
        (warning["code"], warning["text"].partition(" and is")[0])
        for variant in values["variants"]
        for warning in variant["warnings"]
    ] == [("WANTED_ALIKE", sentence) for sentence in sentences]
    text = answer(*request, "2")
    for variant, sentence in zip("AB", sentences, strict=True):
        assert f"\nWANTED_ALIKE: {variant}: {sentence}" in text
    assert "WANTED_ALIKE" not in answer(*request, "0-1")


def test_a_centre_of_mass_for_each(boxes):
    first, second = answer_json(
        "compare", boxes[0], boxes[0], *ASKED, *CENTERS, "--drops", 300
    )["variants"]
    assert first["part_digest"] != second["part_digest"]
    heights = {
        pose["down"][2] > 0.0: pose["height"]
        for pose in second["poses"]
        if abs(pose["down"][2]) > 0.9
    }
    assert heights == {False: pytest.approx(0.004), True: pytest.approx(0.012)}


@pytest.mark.parametrize(
    ("files", "names"),
    [
        (
            ("old/box.stl", "new/box.stl", "cup.stl"),
            ("old/box.stl", "new/box.stl", "cup"),
        ),
        (("old/box.stl", "old/cup.stl"), ("box", "cup")),
        (("box.stl", "box.off"), ("box.stl", "box.off")),
    ],
)
def test_equal_names_are_told_apart_by_their_paths(tmp_path, monkeypatch, files, names):
    monkeypatch.chdir(tmp_path)
    for file in files:
        Path(file).parent.mkdir(parents=True, exist_ok=True)
        trimesh.creation.box((10.0, 20.0, 30.0)).export(file)
    lines = answer("compare", *files, *ASKED, "--drops", 50).splitlines()
    assert [line.partition(": ")[0] for line in lines[len(files) : 2 * len(files)]] == [
        f"{letter} {name}" for letter, name in zip("ABC", names, strict=False)
    ]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            ("--com", 0, 0, 0, "--com", 0, 0, 0, "--com", 0, 0, 0),
            "--com once, or once for",
        ),
        (("--wanted", 9), "wanted poses out of 0 to 5"),
        (("--com", 0, 0, "90mm"), "inside the part's convex hull"),
        (("-o", "page.txt"), "ends in .html"),
    ],
)
def test_refused_in_one_line(boxes, options, words):
    assert words in refusal("compare", *boxes, *ASKED, *options)
