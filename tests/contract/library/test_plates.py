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

"""Plates learnt by `fit`: tables of counts as people write them, what is found, and the
file.
"""

import json

import pytest
import yaml

from lab.bodies import shapes
from ros_pose_stats import estimate, load_part
from tests.answers import write_stl
from tests.running import answer_json, call, refusal

RESTITUTION = 0.2
HEIGHT = 0.02
SIZES = {"a": (20.0, 30.0, 12.0), "b": (10.0, 10.0, 7.5), "c": (16.0, 22.0, 20.0)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plates")
    for name, size in SIZES.items():
        write_stl(folder / f"{name}.stl", shapes.box(*size))
    return folder


def table_of(folder, names, parts, restitution, height, **options):
    """A table of what is counted on a plate as the estimate has it."""
    rows = [
        f"{name}.stl,{pose.index},{round(parts * pose.probability)}"
        for name in names
        for pose in estimate(
            load_part(folder / f"{name}.stl", unit="mm"),
            "split",
            restitution=restitution,
            drop_height=height,
            **options,
        ).poses
    ]
    file = folder / f"{'-'.join(names)}-{restitution}.csv"
    file.write_text("\n".join(rows))
    return file


def fit(table, *options):
    return answer_json(
        "fit",
        table,
        "--unit",
        "mm",
        "--plate",
        "glass",
        "--plates",
        table.with_suffix(".yaml"),
        *options,
    )


@pytest.fixture(scope="module")
def fitted(folder):
    """What is printed for a plate, and the file, which was there before, as a link."""
    table = table_of(folder, "ac", 600, RESTITUTION, HEIGHT)
    real = folder / "real.yaml"
    link = table.with_suffix(".yaml")
    real.write_text("plates:\n  steel: {restitution: 0.2, note: by hand}\n")
    link.symlink_to(real)
    return fit(table), link


def test_the_scene_of_a_plate_is_found(fitted):
    fit, _ = fitted
    assert fit["restitution_low"] <= RESTITUTION <= fit["restitution_high"]
    assert fit["drop_height_low"] <= HEIGHT <= fit["drop_height_high"]
    assert fit["p_value"] > 0.5 and 0.0 < fit["plate_error"] < 0.05
    assert abs(fit["counted"] - 1200) < 4 and sorted(fit["parts"]) == ["a", "c"]
    assert fit["default_weight"] < 0.5
    assert (
        fit["stands_out"] is None
        and fit["use"]
        and fit["verdict"].startswith("use it (expected error on another")
    )


def test_a_fit_that_is_no_better_is_not_to_be_used(folder):
    fit_ = fit(table_of(folder, "ac", 600, 0.5, None))
    assert not fit_["use"] and fit_["plate_error"] >= fit_["default_error"]
    assert fit_["verdict"].startswith("do not use it: the default is as good")


def test_a_part_that_was_counted_wrongly_stands_out(folder):
    """The counts of a box are entered under the numbers of poses in turned order."""
    table = table_of(folder, "abc", 600, RESTITUTION, HEIGHT)
    rows = [line.split(",") for line in table.read_text().splitlines()]
    counts = [count for name, _, count in rows if name == "a.stl"]
    turned = iter(counts[::-1])
    wrong = folder / "wrong.csv"
    wrong.write_text(
        "\n".join(
            f"{name},{pose},{next(turned) if name == 'a.stl' else count}"
            for name, pose, count in rows
        )
    )
    fit_ = fit(wrong)
    assert fit_["stands_out"] == "a" and fit_["verdict"].startswith("a stands out, ")
    # Both errors are mostly of this part, so neither tells which is better.
    assert fit_["plate_error"] < fit_["default_error"] and not fit_["use"]
    assert "; do not use it before that (expected" in fit_["verdict"]
    errors = {part["part_id"]: part["left_out_error"] for part in fit_["evidence"]}
    assert errors["a"] == max(errors.values()) > 0.1


def test_the_order_of_counts_says_nothing_and_a_unit_is_guessed(folder, fitted):
    table = folder / "turned.csv"
    table.write_text("\n".join((folder / "a-c-0.2.csv").read_text().splitlines()[::-1]))
    fitted_plate = json.loads(
        call(
            "fit",
            table,
            "--plate",
            "glass",
            "--plates",
            folder / "turned.yaml",
            "--json",
        ).stdout
    )
    assert [note.split(":")[1] for note in fitted_plate["notes"]] == [
        " UNIT_GUESSED"
    ] * 2
    others = dict.fromkeys(("date", "file", "seconds", "notes"))
    assert fitted_plate | others == fitted[0] | others


def test_the_file_stays_where_it_is_with_what_else_it_holds(fitted):
    fit, link = fitted
    assert link.is_symlink()
    plates = yaml.safe_load(link.read_text(encoding="utf-8"))["plates"]
    assert plates["steel"] == {"restitution": 0.2, "note": "by hand"}
    for name in ("restitution", "drop_height", "plate_error", "counted", "version"):
        assert plates["glass"][name] == fit[name]
    assert not [
        file
        for file in link.parent.iterdir()
        if file.suffix not in (".stl", ".csv", ".yaml")
    ]


def test_a_plate_unlike_the_model_is_said_to_be_so(folder, fitted):
    """A fifth of each part is moved from the most frequent pose to the rarest."""
    moved = folder / "moved.csv"
    rows = [
        line.split(",") for line in (folder / "a-c-0.2.csv").read_text().splitlines()
    ]
    for name in "ac":
        part_rows = [row for row in rows if row[0] == f"{name}.stl"]
        most = max(part_rows, key=lambda row: int(row[2]))
        least = min(part_rows, key=lambda row: int(row[2]))
        most[2] = str(int(most[2]) - 120)
        least[2] = str(int(least[2]) + 120)
    moved.write_text("\n".join(map(",".join, rows)))
    fit_ = fit(moved)
    assert fit_["p_value"] < 0.01 < fitted[0]["p_value"]
    assert fit_["plate_error"] > 0.03


def test_few_counts_say_little_of_the_plate(folder):
    """Shares as the model has them by luck, and a part seen once as it hardly ever
    lies.
    """
    few_counts = table_of(folder, "bc", 30, RESTITUTION, HEIGHT)
    assert 0.02 < fit(few_counts)["plate_error"] <= 0.05
    many_counts = table_of(folder, "ac", 600, RESTITUTION, HEIGHT)
    poses = estimate(load_part(folder / "b.stl", unit="mm"), "split").poses
    single = folder / "once.csv"
    single.write_text(f"{many_counts.read_text()}\nb.stl,{poses[-1].index},1")
    assert fit(single)["plate_error"] < 0.06
    single.write_text(
        f"b.stl,{poses[-1].index},500"
    )  # a single part, unlike in every scene
    assert fit(single)["plate_error"] > 0.2


@pytest.mark.parametrize(
    "text",
    [
        "part,pose,count\na.stl,0,40\nb.stl,2,6\na.stl,0,3\n",
        "a.stl;0;43\n\nb.stl;2;6",
        '\ufeff"a.stl", 0 , 43\n b.stl,2,6\n',
        "part\tpose\tcount\r\na.stl\t0\t43\r\nb.stl\t2\t6",
        "a.stl,0,000000000000043\nb.stl,2,6",
    ],
    ids=["head and twice", "semicolons", "byte order mark", "tabs", "leading zeros"],
)
def test_tables_as_people_write_them(folder, text):
    """Of parts that lie beside the table; rows of the same pose add."""
    table = folder / "written.csv"
    table.write_text(text, encoding="utf-8")
    line = refusal(
        "fit", table, "--unit", "mm", "--plate", "glass", "--plates", folder / "no"
    )
    assert "got 49; count 1 more" in line


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a.stl,0,117\na.stl,1\n", "'a.stl,1' in line 2"),
        ("a.stl,0,117\na.stl,zero,4", "in line 2"),
        ("a.stl,0,-3\n", "a.stl,0,-3"),
        ("a.stl,0,1.5", "whole numbers"),
        (",0,117", "whole numbers"),
        ("a.stl,0,99999999999999999999", "whole numbers"),
        ("a.stl,0,117,9", "whole numbers"),
        ("", "none in"),
        ("part,pose,count", "none in"),
        ('"a.stl,0,1', "expected a CSV file"),
        ("\x00\udcff", "expected a CSV file"),
        ("a.stl,6,500", "poses 0 to 5"),
        ("a.stl,0,0\na.stl,1,0", "got 0; count 50 more"),
    ],
)
def test_tables_that_are_none(folder, text, words):
    table = folder / "bad.csv"
    table.write_text(text, encoding="utf-8", errors="surrogateescape")
    line = refusal(
        "fit", table, "--unit", "mm", "--plate", "glass", "--plates", folder / "no"
    )
    assert words in line


def test_round_parts_tell_what_rolling_loses(folder):
    """A cylinder as high as wide and a box, dropped with 48 sides a turn."""
    write_stl(folder / "round.stl", shapes.prism(64, 10.0, 20.0))
    table = table_of(folder, ("round", "a"), 2000, 0.5, 0.4, round_sides=48)
    fit_ = fit(table)
    otherwise = fit(table, "--round-sides", "96")
    for name in ("default_weight", "plate_error"):
        # Whichever sides number the poses.
        assert otherwise[name] == pytest.approx(fit_[name], rel=1e-9)
    assert fit_["round_sides_low"] == fit_["round_sides"] == 48
    assert fit_["round_sides_high"] < 384
    assert fit_["restitution_low"] <= 0.5 <= fit_["restitution_high"]
    assert fit_["drop_height_low"] <= 0.4 <= fit_["drop_height_high"]
