"""`estimate`: the table, the JSON object, the options and the refusals."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys

import numpy as np
import pytest

from ros_pose_stats import cli, estimate, load_part, shapes
from tests.bodies import METHODS, write_stl
from tests.commands.pose_tables import table_head, table_rows
from tests.running import ROOT, answer, command, complaints, strict_json

STATISTICS_KEYS = {
    "choice", "observed",
    "part_id", "part_digest", "radius", "method", "restitution", "drop_height",
    "cluster_tolerance", "round_sides", "drops", "unsettled", "seed", "expected_error",
    "largest_error", "scene", "plate_error", "seconds", "version", "warnings", "poses",
}
POSE_KEYS = {
    "index", "group", "down", "height", "top", "margin", "barrier", "spread", "probability",
    "probability_low", "probability_high", "standard_error", "count", "orientation", "members",
    "group_size", "group_probability", "rolls", "roll_axis", "yaw_symmetry",
}
CORNERS = tuple(itertools.product((-10.0, 10.0), (-15.0, 15.0), (-20.0, 20.0)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A box 20 x 30 x 40 in several states of repair."""
    path = tmp_path_factory.mktemp("parts")
    vertices, triangles = shapes.box(20.0, 30.0, 40.0)
    write_stl(path / "box.stl", (vertices, triangles))
    write_stl(path / "open.stl", (vertices, triangles[:-2]))
    write_stl(path / "flat.stl", (vertices * (1.0, 1.0, 0.0), triangles))
    write_stl(path / "cylinder.stl", shapes.cylinder(64, 9.0, 22.0))
    (path / "empty.stl").touch()
    (path / "notes.txt").write_text("not a mesh")
    return path


def share(row):
    """Percentage in front of the bar."""
    return float(row["probability"].partition("%")[0])


def printed(capsys, *arguments):
    """Standard output of a command run in this process."""
    assert cli.main(["estimate", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert complaints(err) == []
    return out


class TestTable:
    def test_poses_that_symmetry_makes_alike_share_a_row(self, folder, capsys):
        text = answer("estimate", folder / "box.stl", "--unit", "mm")
        assert text.startswith("box: released 539 mm above a frictionless plate, restitution 0.5\n"
                               "6 stable poses in 3 groups, 12 triangles, 20 x 30 x 40 mm\n")
        rows = table_rows(text)
        assert [(row["poses"], row["number"], row["group"]) for row in rows] == [
            ("0, 1", "2", "0"), ("2, 3", "2", "1"), ("4, 5", "2", "2")]
        poses = strict_json(printed(capsys, folder / "box.stl", "--unit", "mm", "--json"))["poses"]
        told = {str(pose["group"]): pose for pose in poses}
        for row in rows:
            pose = told[row["group"]]
            assert share(row) == pytest.approx(100.0 * pose["group_probability"], abs=0.005)
            bounds = [float(x) for x in row["90 % interval"].split(" - ")]
            assert bounds == pytest.approx([200.0 * pose["probability_low"],
                                            200.0 * pose["probability_high"]], abs=0.005)
        assert sum(map(share, rows)) == pytest.approx(100.0, abs=0.02)

    def test_each_pose_by_itself(self, folder, capsys):
        text = printed(capsys, folder / "box.stl", "--unit", "mm", "--each")
        rows = table_rows(text)
        assert table_head(text) == ["pose", "group", "probability", "90 % interval", "height",
                                    "barrier", "margin", "down"]
        assert [row["pose"] for row in rows] == list("012345")
        assert [row["group"] for row in rows] == list("001122")
        assert sum(map(share, rows)) == pytest.approx(100.0, abs=0.05)

    def test_a_part_without_symmetry_has_a_row_a_pose_either_way(self, tmp_path, capsys):
        corners = np.array([(0.0, 0, 0), (31, 0, 0), (3, 27, 0), (5, 7, 22)])
        file = write_stl(tmp_path / "corner.stl", shapes.hull_mesh(corners))
        text = printed(capsys, file, "--unit", "mm")
        assert table_head(text)[:3] == ["pose", "group", "probability"]
        assert "group," not in text.splitlines()[1]
        each = printed(capsys, file, "--unit", "mm", "--each")
        assert text.splitlines()[:-1] == each.splitlines()[:-1]

    def test_long_rows_of_poses_are_told_by_their_ends(self, folder, capsys):
        text = printed(capsys, folder / "cylinder.stl", "--unit", "mm",
                       "--cluster-tolerance", "0", "--round-sides", "0")
        assert sorted(row["poses"] for row in table_rows(text)) == ["0-63", "64, 65"]

    def test_what_rolls_is_marked_and_said_once(self, folder, capsys):
        text = printed(capsys, folder / "cylinder.stl", "--unit", "mm", "--each")
        assert [row["margin"].endswith("*") for row in table_rows(text)] == [True, False, False]
        assert text.count("the margin holds across its axis only") == 1
        assert "*" not in printed(capsys, folder / "box.stl", "--unit", "mm")

    def test_all_methods_side_by_side(self, folder, capsys):
        for more, count in ((), 3), (("--each",), 6):
            text = printed(capsys, folder / "box.stl", "--unit", "mm", "--method", "all", *more)
            assert text.startswith("box: released 539 mm above a frictionless plate")
            first = ["poses", "number", "group"] if count == 3 else ["pose", "group"]
            assert table_head(text) == [*first, *METHODS, "height", "barrier", "margin", "down"]
            rows = table_rows(text)
            assert len(rows) == count
            for method in METHODS:
                assert sum(float(row[method]) for row in rows) == pytest.approx(100.0, abs=0.05)

    def test_plain_where_the_terminal_is_not_utf8(self, folder):
        done = subprocess.run(
            [sys.executable, "-m", "ros_pose_stats", "estimate", folder / "box.stl"],
            capture_output=True, cwd=ROOT,
            env=os.environ | {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"})
        assert done.returncode == 0, done.stderr
        assert b"###" in done.stdout

    def test_warnings_are_shown(self, folder, capsys):
        assert "UNIT_SUSPECT: " in printed(capsys, folder / "box.stl")
        assert "CLUSTERED: " in printed(capsys, folder / "cylinder.stl", "--unit", "mm")
        assert "LOW_DROP: " in printed(capsys, folder / "box.stl", "--unit", "mm",
                                       "--drop-height", "0.03", "--method", "meae")


class TestJson:
    def test_one_object_with_the_keys_of_the_contract(self, folder):
        found = strict_json(answer("estimate", folder / "box.stl", "--unit", "mm", "--json"))
        assert found.keys() == STATISTICS_KEYS
        assert all(pose.keys() == POSE_KEYS for pose in found["poses"])
        assert found["part_id"] == "box"
        assert found["method"] == "split"
        assert found["radius"] == pytest.approx(np.linalg.norm((10, 15, 20)) * 1e-3, rel=1e-6)
        assert found["drop_height"] == pytest.approx(20.0 * found["radius"])
        assert 0.0 < found["expected_error"] < 0.2
        assert found["plate_error"] == 0.05
        assert found["seconds"] > 0.0

    def test_values_are_those_of_the_library(self, folder, capsys):
        found = strict_json(printed(capsys, folder / "cylinder.stl", "--unit", "mm", "--json",
                                    "--method", "eae", "--restitution", "0.3",
                                    "--cluster-tolerance", "0.01"))
        expected = estimate(load_part(folder / "cylinder.stl", unit="mm"), "eae",
                            restitution=0.3, cluster_tolerance=0.01)
        assert found["part_digest"] == expected.part_digest
        assert found["restitution"] == 0.3
        assert found["cluster_tolerance"] == 0.01
        for pose, other in zip(found["poses"], expected.poses, strict=True):
            for name in ("index", "group", "height", "top", "margin", "barrier", "spread",
                         "probability", "count"):
                assert pose[name] == getattr(other, name)
            assert pose["down"] == other.down.tolist()
            assert pose["orientation"] == other.orientation.tolist()
            assert tuple(pose["members"]) == other.members
            assert pose["standard_error"] == other.standard_error
            assert (pose["probability_low"], pose["probability_high"]) == (
                other.probability_low, other.probability_high)

    def test_all_methods_are_a_list(self, folder, capsys):
        found = strict_json(printed(capsys, folder / "box.stl", "--json", "--method", "all"))
        assert [each["method"] for each in found] == list(METHODS)
        assert all(each.keys() == STATISTICS_KEYS for each in found)

    def test_an_infinite_barrier_is_null(self, tmp_path, capsys):
        ball = write_stl(tmp_path / "ball.stl",
                         shapes.hull_mesh(shapes.sphere_points(500, seed=3)))
        found = strict_json(printed(capsys, ball, "--json", "--cluster-tolerance", "0.2"))
        assert [pose["barrier"] for pose in found["poses"]] == [None]


class TestOptions:
    @pytest.mark.parametrize(("unit", "metres"), [("m", 1.0), ("mm", 1e-3), ("cm", 1e-2),
                                                  ("inch", 0.0254)])
    def test_unit(self, folder, capsys, unit, metres):
        found = strict_json(printed(capsys, folder / "box.stl", "--json", "--unit", unit))
        assert found["radius"] == pytest.approx(np.linalg.norm((10, 15, 20)) * metres, rel=1e-6)

    def test_centre_of_mass_is_in_the_meshs_unit(self, folder, capsys):
        found = strict_json(printed(capsys, folder / "box.stl", "--json", "--unit", "mm",
                                    "--com", "1", "-2.5", "-3"))
        farthest = max(np.linalg.norm(np.array(corner) - (1, -2.5, -3)) for corner in CORNERS)
        assert found["radius"] == pytest.approx(farthest * 1e-3, rel=1e-6)
        assert min(pose["height"] for pose in found["poses"]) == pytest.approx(9e-3, rel=1e-6)

    def test_negative_numbers_in_scientific_notation(self, folder, capsys):
        found = strict_json(printed(capsys, folder / "box.stl", "--json", "--unit", "mm",
                                    "--com", "-1e0", "-2.5e-1", "0"))
        assert min(pose["height"] for pose in found["poses"]) == pytest.approx(9e-3, rel=1e-6)

    def test_cluster_tolerance(self, folder, capsys):
        def poses(*options):
            return strict_json(printed(capsys, folder / "cylinder.stl", "--json",
                                       *options))["poses"]

        assert len(poses()) == 3
        assert len(poses("--cluster-tolerance", "0", "--round-sides", "0")) == 66


REFUSED = {
    "missing file": (["missing.stl"], "No such file"),
    "empty file": (["empty.stl"], "export it again"),
    "no mesh file": (["notes.txt"], ".stl"),
    "flat": (["flat.stl"], "thick"),
    "unknown unit": (["box.stl", "--unit", "furlong"], "'mm'"),
    "unknown method": (["box.stl", "--method", "guess"], "'combined'"),
    "restitution that is no number": (["box.stl", "--restitution", "nan"], "below 1"),
    "restitution of 1": (["box.stl", "--restitution", "1"], "below 1"),
    "restitution as a word": (["box.stl", "--restitution", "high"], "--help"),
    "drop height below the plate": (["box.stl", "--drop-height", "-1"], "above 0 m"),
    "cluster tolerance below 0": (["box.stl", "--cluster-tolerance", "-1"], "from 0"),
    "cluster tolerance that is no number": (["box.stl", "--cluster-tolerance", "nan"], "from 0"),
    "centre of mass outside": (["box.stl", "--com", "0", "0", "21"], "inside"),
    "open mesh, centre of mass outside": (["open.stl", "--com", "0", "0", "21"], "inside"),
    "two coordinates": (["box.stl", "--com", "0", "0"], "3 arguments"),
    "unknown option": (["box.stl", "--colour"], "--help"),
    "no part": ([], "PART"),
}


class TestRefusals:
    @pytest.mark.parametrize(("arguments", "advice"), REFUSED.values(), ids=REFUSED)
    def test_one_line_and_status_2(self, folder, monkeypatch, capsys, arguments, advice):
        monkeypatch.chdir(folder)
        try:
            status = cli.main(["estimate", *arguments])
        except SystemExit as exit_:
            status = exit_.code
        out, err = capsys.readouterr()
        assert status == 2
        assert out == ""
        assert err.count("\n") == 1
        assert err.endswith("\n")
        assert advice in err

    @pytest.mark.parametrize("name", ["missing file", "restitution that is no number",
                                      "open mesh, centre of mass outside"])
    def test_in_a_process_of_its_own(self, folder, name):
        (file, *options), advice = REFUSED[name]
        done = command("estimate", folder / file, *options)
        assert done.returncode == 2
        assert done.stdout == ""
        assert len(complaints(done.stderr)) == 1
        assert advice in done.stderr
        assert "Traceback" not in done.stderr

    def test_a_refused_centre_of_mass_is_advised_in_the_unit_of_the_option(self, folder, capsys):
        assert cli.main(["estimate", str(folder / "box.stl"), "--unit", "mm",
                         "--com", "0", "0", "21"]) == 2
        assert "give it in metres" not in capsys.readouterr().err


def test_an_open_mesh_is_answered_with_a_warning(folder, capsys):
    found = strict_json(printed(capsys, folder / "open.stl", "--json", "--unit", "mm"))
    assert len(found["poses"]) == 6
    assert [line.split(":")[0] for line in found["warnings"]] == ["HOLES_CLOSED"]


def test_a_reader_that_leaves_early_is_no_failure_to_report(folder):
    process = subprocess.Popen(
        [sys.executable, "-m", "ros_pose_stats", "estimate", folder / "box.stl", "--method",
         "all", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=ROOT)
    process.stdout.close()
    error = process.stderr.read()
    process.stderr.close()
    process.wait()
    assert complaints(error.decode()) == []
