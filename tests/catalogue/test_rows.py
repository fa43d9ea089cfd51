"""The row of a part against closed forms, and the reasons of parts that have none."""

import math

import numpy as np
import pytest

from ros_pose_stats import estimate, load_part, shapes, simulate
from ros_pose_stats.catalogue import rows
from ros_pose_stats.catalogue.request import CatalogueRequest
from ros_pose_stats.catalogue.rows import content_of, describe_part, entropy, footprint
from ros_pose_stats.records import DropScene
from ros_pose_stats.shapes.random_parts import random_part
from tests.bodies import REGULAR_SOLIDS, write_stl

MM = CatalogueRequest(unit="mm")


def described(folder, surface, request=MM, drop=False, **more):
    file = write_stl(folder / "part.stl", surface)
    return describe_part(str(file), None, request, drop, **more)


@pytest.mark.parametrize(("shares", "bits"), [
    ([1.0], 0.0), ([0.5, 0.5], 1.0), ([0.125] * 8, 3.0), ([0.5, 0.25, 0.25, 0.0], 1.5),
    ([0.5, math.nan], math.nan)])
def test_entropy(shares, bits):
    assert entropy(shares) == pytest.approx(bits, nan_ok=True)


class TestFootprint:
    def test_of_a_hexagon(self):
        turn = np.arange(6) * math.pi / 3 + 0.3
        corners = np.column_stack((np.cos(turn), np.sin(turn)))
        assert footprint(corners) == pytest.approx((2.0, math.sqrt(3.0)))

    @pytest.mark.parametrize("seed", range(5))
    def test_no_turned_rectangle_is_smaller(self, seed):
        """Against all directions in steps of a hundredth of a degree."""
        turn = np.sort(np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, 9))
        corners = np.column_stack((3.0 * np.cos(turn), np.sin(turn)))
        length, width = footprint(corners)
        turns = np.radians(np.arange(0.0, 90.0, 0.01))
        x = corners @ np.array([np.cos(turns), np.sin(turns)])
        y = corners @ np.array([-np.sin(turns), np.cos(turns)])
        least = (np.ptp(x, axis=0) * np.ptp(y, axis=0)).min()
        assert length * width <= least
        assert length * width == pytest.approx(least, rel=2e-3)
        assert length >= width

    def test_a_repeated_corner_is_no_direction(self):
        corners = np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 0.0), (3.0, 1.0), (0.0, 1.0)])
        assert footprint(corners) == pytest.approx((3.0, 1.0))


class TestRows:
    @pytest.mark.parametrize("solid", ["tetrahedron", "cube", "octahedron", "icosahedron"])
    def test_a_regular_solid_has_one_way_to_lie(self, tmp_path, solid):
        made = described(tmp_path, REGULAR_SOLIDS[solid])
        assert made.row["distinct_poses"] == 1
        assert made.row["stable_poses"] == len(made.row["poses"])
        assert made.row["best_share"] == pytest.approx(1.0)
        assert made.row["entropy_bits"] == pytest.approx(0.0, abs=1e-9)
        assert (made.row["passes"], made.row["passes_high"]) == pytest.approx((1.0, 1.0))

    def test_a_box_lies_in_three_ways(self, tmp_path):
        made = described(tmp_path, shapes.box(10.0, 20.0, 30.0))
        row = made.row
        assert (row["stable_poses"], row["distinct_poses"], row["triangles"]) == (6, 3, 12)
        assert [row[f"size_{axis}_m"] for axis in "xyz"] == pytest.approx([0.01, 0.02, 0.03])
        best = [row[name] for name in ("footprint_length_m", "footprint_width_m", "top_m")]
        assert best == pytest.approx([0.03, 0.02, 0.01])
        assert sum(pose["probability"] for pose in row["poses"]) == pytest.approx(1.0)
        shares = {pose["group"]: pose["group_share"] for pose in row["poses"]}
        assert row["entropy_bits"] == pytest.approx(
            -sum(p * math.log2(p) for p in shares.values()))
        assert row["passes"] == pytest.approx(1.0 / row["best_share"])
        assert 1.0 <= row["passes_low"] < row["passes"] < row["passes_high"]
        for pose in row["poses"]:
            sides = [pose[name] for name in ("footprint_length_m", "footprint_width_m", "top_m")]
            assert sorted(sides) == pytest.approx([0.01, 0.02, 0.03])
            assert pose["height_m"] == pytest.approx(0.5 * pose["top_m"])
        assert made.picture.startswith(b"\x89PNG") and len(made.picture) < 6000

    def test_the_options_reach_the_estimate(self, tmp_path):
        request = CatalogueRequest(DropScene(0.2, 0.03, 0.01, 64), "cm", 7850.0)
        row = described(tmp_path, random_part(3, 2), request).row
        part = load_part(tmp_path / "part.stl", "cm", density=7850.0)
        found = estimate(part, restitution=0.2, drop_height=0.03, cluster_tolerance=0.01,
                         round_sides=64)
        assert row["part_digest"] == part.digest
        assert {pose["pose"]: pose["probability"] for pose in row["poses"]} == {
            pose.index: pose.probability for pose in found.poses}
        assert row["warnings"] == list(found.warnings)

    def test_serious_warnings_come_first(self, tmp_path):
        request = CatalogueRequest(DropScene(0.995), "mm")
        row = described(tmp_path, shapes.cylinder(96, 5.0, 8.0), request).row
        codes = [one.partition(":")[0] for one in row["warnings"]]
        assert codes[0] == "OUTSIDE_FIT" and "ROUNDED" in codes

    def test_drops_keep_the_target_and_depend_on_the_part_alone(self, tmp_path):
        request = CatalogueRequest(unit="mm", target_error=0.01)
        surface = random_part(3, 4)
        first = described(tmp_path, surface, request)
        assert first.to_be_dropped and first.row["drops"] == 0
        dropped = described(tmp_path, surface, request, drop=True)
        again = described(tmp_path, surface, request, drop=True, threads=2)
        assert dropped.row["drops"] > 0 and not dropped.to_be_dropped
        assert dropped.row["expected_error"] <= 0.01
        assert again.row == dropped.row
        counted = simulate(load_part(tmp_path / "part.stl", "mm"), 4000, seed=1)
        truth = {pose.index: pose.probability for pose in counted.poses}
        off = [pose["probability"] - truth[pose["pose"]] for pose in dropped.row["poses"]]
        assert math.sqrt(np.mean(np.square(off))) < 0.01 * 3.0 + 3.0 * counted.expected_error

    def test_a_sure_estimate_is_not_to_be_dropped(self, tmp_path):
        request = CatalogueRequest(unit="mm", target_error=0.2)
        assert not described(tmp_path, random_part(3, 4), request).to_be_dropped


class TestRefusals:
    @pytest.mark.parametrize(("name", "content", "why"), [
        ("a.stl", b"", "empty"), ("a.stl", b"solid\nendsolid\n", "triangles"),
        ("a.step", b"ISO-10303-21;\nEND-ISO-10303-21;\n", "STEP"), ("a.txt", b"x", ".step"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "thick")])
    def test_a_file_without_a_part(self, tmp_path, name, content, why):
        file = tmp_path / name
        file.write_bytes(content)
        made = describe_part(str(file), None, MM, False)
        assert made.row.keys() == {"file", "refusal"}
        assert why in made.row["refusal"] and "\n" not in made.row["refusal"]
        assert made.picture is None
        sent = describe_part(str(file), content_of(str(file)), MM, False)
        assert sent.row == made.row

    def test_a_file_that_is_gone(self, tmp_path):
        assert "No such file" in describe_part(str(tmp_path / "a.stl"), None, MM, False).row[
            "refusal"]

    def test_an_accident_inside_the_program_costs_one_row(self, tmp_path, monkeypatch):
        def fail(*_, **__):
            raise ZeroDivisionError("by\nzero")

        monkeypatch.setattr(rows, "auto", fail)
        row = described(tmp_path, shapes.box(1.0, 2.0, 3.0)).row
        assert "ZeroDivisionError: by zero" in row["refusal"]
