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

"""`catalogue`: a row for every part, in tables and object."""

import math
from pathlib import Path

import pytest
from pyarrow import parquet

from ros_pose_stats import estimate, load_part
from tests.running import refusal

from .parts import ASKED, REFUSED, ROCKS, TABLES, rows_of, tables


class TestRows:
    def test_each_file_has_one_in_the_order_of_names_whatever_links_to_it(
        self, catalogue
    ):
        expected = (
            *REFUSED,
            "box.stl",
            "a_changed.stl",
            "a_new.stl",
            "b\udcf6x, 1.stl",
            *(f"below/rock_{seed}.STL" for seed in range(ROCKS)),
        )
        names = ["./\ufeff =1+1.stl", *sorted(f"parts/{name}" for name in expected)]
        assert [row["file"] for row in catalogue[0]["parts"]] == names
        assert [row["file"] for row in rows_of(catalogue[1])] == names

    def test_what_is_no_part_is_refused_with_a_reason_in_one_line(self, catalogue):
        values, _ = catalogue
        reasons = {
            row["file"]: row["refusal"] for row in values["parts"] if row["refusal"]
        }
        assert len(reasons) == values["refused"] == len(REFUSED) + 1
        for name, words in (
            ("letter.stl", "triangles"),
            ("empty.step", "empty"),
            ("flat.obj", "thick"),
            ("bare.step", "STEP"),
        ):
            assert words in reasons[f"parts/{name}"]
        # Names in reasons stand as they are; the reasons themselves break no line.
        assert not any(
            "\n" in reason for name, reason in reasons.items() if "\n" not in name
        )

    def test_a_box_by_its_closed_forms(self, catalogue):
        row = next(
            row for row in catalogue[0]["parts"] if row["file"] == "parts/box.stl"
        )
        assert (row["stable_poses"], row["distinct_poses"], row["triangles"]) == (
            6,
            3,
            12,
        )
        assert [row[f"size_{axis}_m"] for axis in "xyz"] == pytest.approx(
            [0.01, 0.02, 0.03]
        )
        best = [
            row[name] for name in ("footprint_length_m", "footprint_width_m", "top_m")
        ]
        assert best == pytest.approx([0.03, 0.02, 0.01])
        shares = {pose["group"]: pose["group_share"] for pose in row["poses"]}
        assert row["entropy_bits"] == pytest.approx(
            -sum(share * math.log2(share) for share in shares.values())
        )
        for end, counterpart in (("", ""), ("_low", "_high"), ("_high", "_low")):
            assert row[f"passes{end}"] == pytest.approx(
                1.0 / row[f"best_share{counterpart}"]
            )
        for pose in row["poses"]:
            sides = [
                pose[name]
                for name in ("footprint_length_m", "footprint_width_m", "top_m")
            ]
            assert sorted(sides) == pytest.approx([0.01, 0.02, 0.03])
            assert pose["height_m"] == pytest.approx(0.5 * pose["top_m"])

    def test_the_options_reach_the_estimate(self, home, catalogue):
        row = next(
            row for row in catalogue[0]["parts"] if row["file"].endswith("rock_3.STL")
        )
        part = load_part(home / row["file"], "cm", density=7850.0)
        expected = estimate(part, restitution=0.2, drop_height=0.4)
        assert row["part_digest"] == part.digest
        assert row["warnings"] == [warning._asdict() for warning in expected.warnings]
        assert {pose["pose"]: pose["probability"] for pose in row["poses"]} == {
            pose.index: pose.probability for pose in expected.poses
        }


class TestTables:
    def test_they_hold_what_the_object_says(self, catalogue):
        values, folder = catalogue
        assert values["tables"] == [
            str(Path("out", name).with_suffix(kind))
            for name in TABLES
            for kind in (".csv", ".parquet")
        ]
        for row, entry in zip(rows_of(folder), values["parts"], strict=True):
            assert row["refusal"] == entry["refusal"]
            assert row["best_share"] == (
                "" if entry["refusal"] else str(entry["best_share"])
            )
        poses = rows_of(folder, "poses.csv")
        assert len(poses) == sum(len(row.get("poses", ())) for row in values["parts"])
        for name in ("parts/box.stl", "parts/below/rock_3.STL"):
            assert sum(
                float(pose["probability"]) for pose in poses if pose["file"] == name
            ) == pytest.approx(1.0)

    @pytest.mark.parametrize("name", TABLES)
    def test_parquet_holds_the_same(self, catalogue, name):
        rows = parquet.read_table(
            (catalogue[1] / name).with_suffix(".parquet")
        ).to_pylist()
        for row, text in zip(rows, rows_of(catalogue[1], name), strict=True):
            assert {
                key: "" if value is None else str(value) for key, value in row.items()
            } == {
                key: value.encode(errors="replace").decode()
                for key, value in text.items()
            }

    def test_lines_end_as_those_of_unix(self, catalogue):
        text = (catalogue[1] / "poses.csv").read_bytes()
        assert b"\r" not in text and text.endswith(b"\n")


def test_no_module_comes_from_where_the_command_is_started(home, catalogue):
    assert not (home / "ran").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--unit", "mm"), "unit"),
        (("--restitution", 0.3), "restitution"),
        (("--target-error", 0.1), "target_error"),
    ],
)
def test_a_folder_of_another_request_is_refused_and_kept(catalogue, options, words):
    contents = tables(catalogue[1])
    line = refusal(*ASKED, *options, "-o", "out")
    assert "the same catalogue" in line and words in line
    assert tables(catalogue[1]) == contents
