"""Tables of counts and files of plates: round trips, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from ros_pose_stats import PoseStatsError, part_from_mesh, shapes
from ros_pose_stats.plates import PlateProfile, count_part, read_count_rows, read_profiles
from ros_pose_stats.plates.counts import merge_counts
from ros_pose_stats.plates.profile import write_profile

GLASS = PlateProfile("glass", 0.4, 0.3, 0.5, 0.05, 0.04, 0.07, 0.03, 0.4, ("a", "b"), 900,
                     "2026-11-23T12:00:00+00:00", "0.2.0")


class TestTables:
    def read(self, folder, text):
        file = folder / "counts.csv"
        file.write_text(text, encoding="utf-8")
        return {part.name: dict(counts) for part, counts in read_count_rows(file).items()}

    @pytest.mark.parametrize("text", [
        "part,pose,count\na.stl,0,117\nb.stl,2,4\na.stl,0,3\n", "a.stl;0;120\n\nb.stl;2;4",
        '\ufeff"a.stl", 0 , 120\n b.stl,2,4\n',
        "part\tpose\tcount\r\na.stl\t0\t120\r\nb.stl\t2\t4",
    ])
    def test_rows(self, tmp_path, text):
        assert self.read(tmp_path, text) == {"a.stl": {0: 120}, "b.stl": {2: 4}}

    @pytest.mark.parametrize(("text", "words"), [
        ("a.stl,0,117\na.stl,1\n", "'a.stl,1' in line 2"), ("a.stl,0,-3\n", "a.stl,0,-3"),
        ("a.stl,0,117\na.stl,zero,4", "in line 2"), ("a.stl,0,1.5", "whole numbers"),
        (",0,117", "whole numbers"), ("", "none in"), ("part,pose,count", "none in"),
        ("a.stl,0,99999999999999999999", "whole numbers"), ('"a.stl,0,1', "expected a CSV file"),
        ("a.stl,0,117,9", "whole numbers"),
    ])
    def test_bad_rows_are_refused(self, tmp_path, text, words):
        with pytest.raises(PoseStatsError, match=words):
            self.read(tmp_path, text)

    def test_files_that_are_none(self, tmp_path):
        (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00")
        for name in ("missing.csv", "bytes.csv"):
            with pytest.raises(PoseStatsError, match="expected a CSV file"):
                read_count_rows(tmp_path / name)

    def test_parts_lie_beside_the_table(self, tmp_path):
        (tmp_path / "counts.csv").write_text("a.stl,0,1")
        assert list(read_count_rows(tmp_path / "counts.csv")) == [tmp_path / "a.stl"]


class TestCounts:
    def test_poses_that_the_part_does_not_have(self):
        part = part_from_mesh(*shapes.box(0.01, 0.02, 0.03))
        for counts, words in (({6: 1}, "poses 0 to 5"), ({0: -1}, "at least 0")):
            with pytest.raises(PoseStatsError, match=words):
                count_part(part, counts)

    def test_one_part_counted_twice(self):
        part = part_from_mesh(*shapes.box(0.01, 0.02, 0.03))
        merged = merge_counts([count_part(part, {0: 3, 5: 1}), count_part(part, {0: 4})])
        assert len(merged) == 1 and merged[0].count.tolist() == [7, 0, 0, 0, 0, 1]
        assert sorted(merged[0].by_group.tolist()) == [0, 1, 7]


class TestPlatesFile:
    def test_round_trip(self, tmp_path):
        file = tmp_path / "deep" / "plates.yaml"
        untested = replace(GLASS, name="4", p_value=math.nan)
        for profile in (untested, GLASS, replace(GLASS, restitution=0.45)):
            write_profile(file, profile)
        found = read_profiles(file)
        assert found["glass"] == replace(GLASS, restitution=0.45)
        assert math.isnan(found["4"].p_value)
        assert replace(found["4"], p_value=0.0) == replace(untested, p_value=0.0)
        assert [path.name for path in file.parent.iterdir()] == ["plates.yaml"]

    def test_other_plates_and_what_they_hold_stay(self, tmp_path):
        file = tmp_path / "plates.yaml"
        file.write_text("plates:\n  steel: {restitution: 0.2, note: by hand}\n")
        write_profile(file, GLASS)
        kept = yaml.safe_load(file.read_text())["plates"]
        assert kept["steel"] == {"restitution": 0.2, "note": "by hand"}
        assert kept["glass"]["counted"] == 900

    @pytest.mark.parametrize("text", ["", "plates:\n", "plates: {}\n"])
    def test_a_file_without_plates(self, tmp_path, text):
        file = tmp_path / "plates.yaml"
        file.write_text(text)
        assert read_profiles(file) == {}
        write_profile(file, GLASS)
        assert read_profiles(file) == {"glass": GLASS}

    @pytest.mark.parametrize("text", ["parameters: {}\n", "plates: [1]\n", "{", "- a\n", "\x00"])
    def test_a_file_of_something_else_stays_as_it_is(self, tmp_path, text):
        file = tmp_path / "plates.yaml"
        file.write_text(text)
        with pytest.raises(PoseStatsError, match="YAML"):
            write_profile(file, GLASS)
        assert file.read_text() == text

    @pytest.mark.parametrize(("key", "value"), [
        ("restitution", 1.5), ("drop_height", -1), ("plate_error", "much"), ("plate_error", 2),
        ("drop_height", None), ("round_sides", 3), ("round_sides", "many"),
    ])
    def test_plates_that_cannot_be(self, tmp_path, key, value):
        file = tmp_path / "plates.yaml"
        file.write_text(yaml.safe_dump({"plates": {"glass": {**GLASS.as_dict(), key: value}}}))
        with pytest.raises(PoseStatsError, match="for glass in"):
            read_profiles(file)

    def test_numbers_as_people_write_them(self, tmp_path):
        file = tmp_path / "plates.yaml"
        write_profile(file, GLASS)
        file.write_text(file.read_text().replace("drop_height: 0.05", "drop_height: 5e-2"))
        assert read_profiles(file)["glass"] == GLASS

    def test_a_plate_of_an_earlier_version_tells_no_round_sides(self, tmp_path):
        file = tmp_path / "plates.yaml"
        told = {key: value for key, value in GLASS.as_dict().items() if "round" not in key}
        file.write_text(yaml.safe_dump({"plates": {"glass": told}}))
        found = read_profiles(file)["glass"]
        assert found == GLASS and not found.tells_round_sides
        assert (found.round_sides, found.round_sides_low, found.round_sides_high) == (192, 48, 384)

    def test_round_sides_come_back(self, tmp_path):
        rolling = replace(GLASS, round_sides=96, round_sides_low=48, round_sides_high=96)
        write_profile(tmp_path / "plates.yaml", rolling)
        assert read_profiles(tmp_path / "plates.yaml")["glass"] == rolling
        assert rolling.tells_round_sides

    def test_a_link_stays_a_link(self, tmp_path):
        target, link = tmp_path / "real.yaml", tmp_path / "plates.yaml"
        target.write_text("")
        link.symlink_to(target)
        write_profile(link, GLASS)
        assert link.is_symlink() and read_profiles(Path(target)) == {"glass": GLASS}

    @pytest.mark.parametrize("name", ["", "  ", "a\nb", "x" * 101])
    def test_names(self, name):
        with pytest.raises(PoseStatsError, match="plate's name"):
            replace(GLASS, name=name)
