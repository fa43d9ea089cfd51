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

"""`estimate`: the table, the JSON object, the options and the refusals."""

import numpy as np
import pytest

from lab.bodies import shapes
from ros_pose_stats import auto, estimate, find_lookalikes, hybrid, load_part
from tests.answers import METHODS, write_stl
from tests.running import answer, answer_json, refusal

from .tables import share, table_head, table_rows


@pytest.fixture(scope="module")
def cylinder(parts):
    return parts / "cylinder.stl", "--unit", "mm"


class TestTable:
    def test_poses_that_symmetry_makes_alike_share_a_row(self, box):
        text = answer("estimate", *box, "--method", "split")
        assert text.startswith(
            "box: released 539 mm above a frictionless plate, restitution 0.5\n"
            "6 stable poses in 3 groups, 12 triangles, 20 x 30 x 40 mm\n"
        )
        rows = table_rows(text)
        assert [(row["poses"], row["number"], row["group"]) for row in rows] == [
            ("0, 1", "2", "0"),
            ("2, 3", "2", "1"),
            ("4, 5", "2", "2"),
        ]
        poses = answer_json("estimate", *box, "--method", "split")["poses"]
        by_group = {str(pose["group"]): pose for pose in poses}
        for row in rows:
            pose = by_group[row["group"]]
            assert share(row) == pytest.approx(
                100.0 * pose["group_probability"], abs=0.0051
            )
            bounds = [float(x) for x in row["90 % interval"].split(" - ")]
            assert bounds == pytest.approx(
                [200.0 * pose["probability_low"], 200.0 * pose["probability_high"]],
                abs=0.0051,
            )
        assert text.splitlines()[-1].startswith("computed in ")

    def test_each_pose_by_itself(self, box):
        text = answer("estimate", *box, "--method", "split", "--each")
        assert table_head(text) == [
            "pose",
            "group",
            "probability",
            "90 % interval",
            "height",
            "barrier",
            "topple",
            "down",
        ]
        rows = table_rows(text)
        assert [row["pose"] for row in rows] == list("012345")
        assert [row["group"] for row in rows] == list("001122")
        assert sum(map(share, rows)) == pytest.approx(100.0, abs=0.05)

    def test_a_part_without_symmetry_has_a_row_a_pose_either_way(self, tmp_path):
        corners = np.array([(0.0, 0, 0), (31, 0, 0), (3, 27, 0), (5, 7, 22)])
        file = write_stl(tmp_path / "corner.stl", shapes.hull_mesh(corners))
        text, every_pose = (
            answer("estimate", file, "--unit", "mm", *options)
            for options in ((), ("--each",))
        )
        assert table_head(text)[:3] == ["pose", "group", "probability"]
        assert text.splitlines()[:-1] == every_pose.splitlines()[:-1]

    @pytest.mark.parametrize("method", ["split", "all"])
    def test_rare_poses_are_folded_into_a_line(self, tmp_path, method):
        """A plate hardly ever stands on its shortest edges; JSON lists them too."""
        file = write_stl(tmp_path / "plate.stl", shapes.box(40.0, 30.0, 3.0))
        words = ("estimate", file, "--unit", "mm", "--method")
        text = answer(*words, method)
        poses = answer_json(*words, "split")["poses"]
        rare = [pose for pose in poses if pose["group_probability"] < 1e-3]
        assert len(poses) == 6 and len(rare) >= 2
        listed = sum(int(row["number"]) for row in table_rows(text))
        assert listed == len(poses) - len(rare)
        together = 100.0 * sum(pose["probability"] for pose in rare)
        assert f"{len(rare)} more poses below 0.1 %, {together:.2f}% together" in text

    def test_long_rows_of_poses_are_written_by_their_ends(self, cylinder):
        text = answer(
            "estimate", *cylinder, "--cluster-tolerance", "0", "--round-sides", "0"
        )
        assert sorted(row["poses"] for row in table_rows(text)) == ["0-63", "64, 65"]

    def test_what_rolls_is_marked_and_explained_once(self, box, cylinder):
        text = answer("estimate", *cylinder, "--each")
        assert [row["topple"].endswith("*") for row in table_rows(text)] == [
            True,
            False,
            False,
        ]
        assert text.count("the tilt to topple holds across its axis only") == 1
        assert "*" not in answer("estimate", *box)

    def test_poses_that_a_camera_takes_for_each_other_are_named(self, bar):
        """All four long sides of the bar; both ends are smaller."""
        text = answer("estimate", *bar)
        alike = {row["poses"]: row["alike"] for row in table_rows(text)}
        assert alike == {"0, 1": "2, 3", "2, 3": "0, 1", "4, 5": "-"}
        assert text.count("alike: poses of the same silhouette from above") == 1
        every_pose = table_rows(answer("estimate", *bar, "--each"))
        for row in every_pose:
            assert row["alike"] == {"0": "2, 3", "1": "0, 1", "2": "-"}[row["group"]]
        text = answer("estimate", *bar, "--pixel", "0.01mm")
        assert "alike" not in text and len(table_rows(text)) == 3

    @pytest.mark.parametrize(("extra", "count"), [((), 3), (("--each",), 6)])
    def test_all_methods_side_by_side(self, box, extra, count):
        text = answer("estimate", *box, "--method", "all", *extra)
        assert set(METHODS) < set(table_head(text))
        rows = table_rows(text)
        assert len(rows) == count
        for method in METHODS:
            assert sum(float(row[method]) for row in rows) == pytest.approx(
                100.0, abs=0.05
            )

    @pytest.mark.parametrize(
        ("name", "options", "code", "acts"),
        [
            ("box", (), "UNIT_GUESSED", True),
            ("open", ("--unit", "mm"), "HOLES_CLOSED", False),
            ("cylinder", ("--unit", "mm"), "CLUSTERED", False),
            (
                "box",
                ("--unit", "mm", "--drop-height", "0.03", "--method", "meae"),
                "LOW_DROP",
                True,
            ),
        ],
    )
    def test_warnings_are_in_table_and_object(self, parts, name, options, code, acts):
        request = "estimate", parts / f"{name}.stl", *options
        (warning,) = (
            warning
            for warning in answer_json(*request)["warnings"]
            if warning["code"] == code
        )
        assert warning.keys() == {"code", "text", "acts"} and warning["acts"] is acts
        begin = "\n" if acts else "\nnote "
        assert f"{begin}{code}: {warning['text']}\n" in answer(*request)

    def test_what_to_act_on_comes_first(self, parts):
        """The table ends with them."""
        request = "estimate", parts / "cylinder.stl"
        warnings = answer_json(*request)["warnings"]
        assert {warning["acts"] for warning in warnings} == {True, False}
        lines = answer(*request).splitlines()[-len(warnings) - 1 : -1]
        is_note = [line.startswith("note ") for line in lines]
        assert is_note == sorted(is_note)


class TestJson:
    def test_the_values_of_the_contract(self, box, cylinder):
        values = answer_json("estimate", *box, "--method", "split")
        assert (values["part_id"], values["method"], values["drops"]) == (
            "box",
            "split",
            0,
        )
        assert values["radius"] == pytest.approx(
            np.linalg.norm((10, 15, 20)) * 1e-3, rel=1e-6
        )
        assert values["drop_height"] == pytest.approx(20.0 * values["radius"])
        assert 0.0 < values["expected_error"] < 0.2 and values["plate_error"] == 0.05
        assert values["units"].keys() <= {*values, *values["poses"][0]}
        assert not any(
            0.0 < abs(x) < 1e-12 or repr(x) == "-0.0"
            for pose in answer_json("estimate", *cylinder)["poses"]
            for name in ("down", "orientation", "position")
            for x in pose[name]
        )

    @pytest.mark.parametrize(
        ("words", "function", "options"),
        [
            (
                ("--method", "eae", "--restitution", 0.3, "--cluster-tolerance", 0.01),
                estimate,
                {"method": "eae", "restitution": 0.3, "cluster_tolerance": 0.01},
            ),
            (
                ("--method", "hybrid", "--drops", 120, "--seed", 9, "--workers", 2),
                hybrid,
                {"drops": 120, "seed": 9},
            ),
            (
                ("--target-error", 0.02, "--seed", 9),
                auto,
                {"target_error": 0.02, "seed": 9},
            ),
            ((), auto, {}),
        ],
    )
    def test_it_is_the_librarys_answer(self, cylinder, words, function, options):
        values = answer_json("estimate", *cylinder, *words)
        part = load_part(cylinder[0], unit="mm")
        expected = find_lookalikes(function(part, **options), part).as_dict()
        assert {**values, "seconds": None} == {**expected, "seconds": None}

    def test_auto_says_why_where_a_target_was_asked_for(self, box):
        values = answer_json("estimate", *box, "--target-error", 0.02, "--seed", 9)
        assert values["choice"] in answer(
            "estimate", *box, "--target-error", 0.02, "--seed", 9
        )
        assert answer_json("estimate", *box)["choice"] not in answer("estimate", *box)

    def test_all_methods_are_a_list(self, box):
        values = answer_json("estimate", *box, "--method", "all")
        assert [answer["method"] for answer in values] == list(METHODS)

    def test_an_infinite_barrier_is_null(self, tmp_path):
        ball = write_stl(
            tmp_path / "ball.stl", shapes.hull_mesh(shapes.sphere_points(500, seed=3))
        )
        values = answer_json("estimate", ball, "--cluster-tolerance", "0.2")
        assert [pose["barrier"] for pose in values["poses"]] == [None]


class TestOptions:
    @pytest.mark.parametrize(
        ("unit", "metres"), [("m", 1.0), ("cm", 1e-2), ("inch", 0.0254)]
    )
    def test_unit(self, parts, unit, metres):
        values = answer_json("estimate", parts / "box.stl", "--unit", unit)
        assert values["radius"] == pytest.approx(
            np.linalg.norm((10, 15, 20)) * metres, rel=1e-6
        )

    @pytest.mark.parametrize(
        "center",
        [
            ("1mm", "-2.5mm", "-0.3cm"),
            ("1e-3", "-.0025", "-3 mm"),
            ("1mm, -2.5mm -0.003m",),
            ("1 mm", "-2.5mm", "-3mm"),
        ],
    )
    def test_centre_of_mass_takes_a_suffix_or_is_in_metres(self, box, center):
        values = answer_json("estimate", *box, "--com", *center)
        assert values["radius"] == pytest.approx(
            np.linalg.norm((11, 17.5, 23)) * 1e-3, rel=1e-6
        )
        assert min(pose["height"] for pose in values["poses"]) == pytest.approx(
            9e-3, rel=1e-6
        )

    def test_a_body_is_chosen_where_several_stand_apart(self, tmp_path):
        file = tmp_path / "plate.stl"
        words = "estimate", file, "--unit", "mm", "--method", "split"
        vertices, triangles = shapes.box(1.0, 2.0, 3.0)
        beside = np.array([20.0, 0.0, 0.0])
        pair = np.vstack((triangles, triangles + len(vertices)))
        write_stl(file, (np.vstack((vertices, 2.0 * vertices + beside)), pair))
        message = refusal(*words)
        assert "2 that stand apart and differ: 0: 2 x 4 x 6, 1: 1 x 2 x 3 mm" in message
        assert "--body N" in message
        for body, count in (("0", 12), ("1", 12), ("all", 24)):
            assert f", {count} triangles, " in answer(*words, "--body", body)
        assert "a body from 0 to 1, got 2" in refusal(*words, "--body", "2")
        write_stl(file, (np.vstack((vertices, vertices + beside)), pair))
        note = answer_json(*words)["warnings"][0]
        assert note["code"] == "BODIES_APART"
        assert note["text"].startswith("the mesh has 2 equal bodies")

    def test_the_unit_is_a_guess_where_nobody_names_it(self, box):
        guessed = answer_json("estimate", box[0], "--drop-height", "200mm")
        with_height = answer_json("estimate", *box, "--drop-height", 0.2)
        known_unit = with_height.pop("warnings")
        (warning,) = (
            warning for warning in guessed.pop("warnings") if warning not in known_unit
        )
        assert warning["code"] == "UNIT_GUESSED" and "mm" in warning["text"]
        assert (guessed.pop("unit_guessed"), with_height.pop("unit_guessed")) == (
            True,
            False,
        )
        assert {**guessed, **with_height} == {
            **with_height,
            "seconds": with_height["seconds"],
        }

    @pytest.mark.parametrize(
        "words",
        [
            ("estimate", "--drop-height", 20, "--seed", 1),
            ("simulate", "--drops", 20, "--drop-height", 540),
            ("flips", "--flips", 5, "--kick", 3),
        ],
        ids=lambda words: words[0],
    )
    def test_a_height_that_no_feeder_has_is_pointed_out(self, box, words):
        warnings = answer_json(words[0], *box, *words[1:])["warnings"]
        assert "HEIGHT_SUSPECT" in [warning["code"] for warning in warnings]

    def test_cluster_tolerance_and_round_sides(self, cylinder):
        options = "--cluster-tolerance", "0", "--round-sides", "0"
        assert len(answer_json("estimate", *cylinder)["poses"]) == 3
        assert len(answer_json("estimate", *cylinder, *options)["poses"]) == 66


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
    "cluster tolerance": (["box.stl", "--cluster-tolerance", "nan"], "from 0"),
    "centre of mass outside": (["open.stl", "--com", "0", "0", "21mm"], "inside"),
    "a length in no unit": (["box.stl", "--drop-height", "3 furlong"], "a length"),
    "two coordinates": (["box.stl", "--com", "0", "0"], "3 arguments"),
    "drops without a simulation": (
        ["box.stl", "--method", "split", "--drops", "5"],
        "--drops",
    ),
    "seed without a simulation": (
        ["box.stl", "--method", "all", "--seed", "5"],
        "--seed",
    ),
    "target of an estimator": (
        ["box.stl", "--method", "split", "--target-error", "0.1"],
        "--target-error",
    ),
    "target error": (["box.stl", "--target-error", "2"], "target error"),
    "no drops": (["box.stl", "--method", "hybrid", "--drops", "0"], "drops"),
    "no pixel": (["box.stl", "--pixel", "0mm"], "a length above 0"),
    "a pixel for all methods": (
        ["box.stl", "--method", "all", "--pixel", "1mm"],
        "--pixel with one method",
    ),
    "negative seed": (["box.stl", "--method", "hybrid", "--seed", "-1"], "seed"),
}


@pytest.mark.parametrize(("arguments", "advice"), REFUSED.values(), ids=REFUSED)
def test_refused_in_one_line_with_advice(parts, monkeypatch, arguments, advice):
    monkeypatch.chdir(parts)
    assert advice in refusal("estimate", *arguments)
