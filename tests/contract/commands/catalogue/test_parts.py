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

"""Parts in a catalogue: units, names, one that ends its process, drops."""

import os
import re
from pathlib import Path

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import moved
from tests.answers import write_stl
from tests.running import ROOT, answer, answer_json, call

from .parts import rows_of, tables


def test_guessed_units_are_counted_in_one_line(tmp_path):
    """On terminal and page; the rows keep the warning with the other lengths."""
    parts = tmp_path / "parts"
    parts.mkdir()
    for name, scale in (("a", 1.0), ("b", 2.0), ("c", 0.001), ("huge", 300.0)):
        write_stl(parts / f"{name}.stl", shapes.box(*(scale * np.array((9, 10, 11)))))
    guesses = "3 units guessed as mm, 1 unit guessed as m"
    request = ("catalogue", parts, "--workers", 1, "-o", tmp_path / "out")
    lines = answer(*request).splitlines()
    assert "warnings about 1 of 4 parts: UNIT_SUSPECT 1" in lines
    assert f"{guesses}; --unit makes sure" in lines
    values = answer_json(*request)
    assert (values["guessed"], values["warnings"]) == (
        {"mm": 3, "m": 1},
        {"UNIT_SUSPECT": 1},
    )
    assert [(row["unit_m"], row["unit_guessed"]) for row in values["parts"]] == [
        (0.001, True),
        (0.001, True),
        (1.0, True),
        (0.001, True),
    ]
    assert all(row["warnings"][0]["code"] == "UNIT_GUESSED" for row in values["parts"])
    page = (tmp_path / "out" / "index.html").read_text()
    assert page.replace("\xa0", " ").count(guesses) == 1
    assert "UNIT_GUESSED" not in page


@pytest.fixture(scope="module")
def odd(tmp_path_factory):
    """A catalogue of bodies that stand apart, and of files that share names.

    Beside one of a name as long as can be, whose report has a shorter one.
    """
    folder = tmp_path_factory.mktemp("odd")
    (folder / "out" / "reports").mkdir(parents=True)
    vertices, triangles = shapes.box(1.0, 2.0, 3.0)
    pair = np.vstack((triangles, triangles + len(vertices)))
    for name, scale in (("equal.stl", 1.0), ("unlike.stl", 2.0)):
        beside = scale * vertices + np.array([20.0, 0.0, 0.0])
        write_stl(folder / name, (np.vstack((vertices, beside)), pair))
    write_stl(folder / f"{'n' * 251}.stl", shapes.box(10.0, 20.0, 30.0))
    for name, size in (("box.STL", 1.0), ("box.stl", 10.0)):
        write_stl(folder / name, shapes.box(size, size, 3.0 * size))
    turn = (0.6, -0.8, 0.0), (0.8, 0.6, 0.0), (0.0, 0.0, 1.0)
    write_stl(folder / "cube.STL", shapes.box(10.0, 10.0, 10.0))
    write_stl(folder / "cube.stl", moved(shapes.box(10.0, 10.0, 10.0), turn))
    outcome = call(
        "catalogue", folder, "--unit", "mm", "-o", folder / "out", "--workers", 1
    )
    assert outcome.returncode == 0, outcome.stderr
    return outcome.stdout, folder / "out"


def test_bodies_that_stand_apart_have_a_note_or_a_reason(odd):
    """Equal ones are one part; which of different ones is meant nobody says."""
    rows = {Path(row["file"]).name: row for row in rows_of(odd[1])}
    equal = rows["equal.stl"]
    unlike = rows["unlike.stl"]
    assert (equal["refusal"], equal["warnings"], equal["triangles"]) == ("", "", "12")
    assert equal["notes"].startswith("BODIES_APART: the mesh has 2 equal bodies")
    assert unlike["best_share"] == unlike["notes"] == ""
    assert "2 that stand apart and differ: 0: 2 x 4 x 6" in unlike["refusal"]
    assert "export each by itself" in unlike["refusal"]


def test_a_part_that_ends_its_process_is_refused_and_costs_no_other(
    tmp_path, monkeypatch
):
    """As one does that makes a library crash: here reading it is an abort."""
    for name in ("box.stl", "deadly.stl", "other.stl"):
        write_stl(tmp_path / name, shapes.box(10.0, 20.0, 30.0))
    (tmp_path / "sitecustomize.py").write_text(
        "import os\n"
        "usual = os.open\n"
        "def deadly(path, *how, **more):\n"
        "    if str(path).endswith('deadly.stl'):\n"
        "        os.abort()\n"
        "    return usual(path, *how, **more)\n"
        "os.open = deadly\n"
    )
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{ROOT}")
    outcome = call(
        "catalogue", tmp_path, "--unit", "mm", "--workers", 1, "-o", tmp_path / "out"
    )
    assert outcome.returncode == 0 and ": 3 parts, 1 refused" in outcome.stdout
    assert (
        "deadly.stl: the process that looked at it ended by SIGABRT" in outcome.stdout
    )


@pytest.mark.long
def test_drops_keep_the_target_whatever_the_workers(tmp_path):
    parts = tmp_path / "parts"
    parts.mkdir()
    for seed in range(2):
        write_stl(parts / f"rock_{seed}.stl", random_polyhedron(9, seed))
    write_stl(parts / "plate.stl", shapes.box(40.0, 30.0, 1.0))
    for workers in (1, 3):
        values = answer_json(
            "catalogue",
            parts,
            "--unit",
            "mm",
            "--target-error",
            0.02,
            "--workers",
            workers,
            "-o",
            tmp_path / str(workers),
        )
        drops = {Path(row["file"]).stem: row["drops"] for row in values["parts"]}
        assert drops["rock_0"] > 0 and drops["rock_1"] > 0
        assert all(row["expected_error"] <= 0.02 for row in values["parts"])
    assert tables(tmp_path / "1") == tables(tmp_path / "3")


def test_files_of_one_name_and_another_size_are_named_however_turned(odd):
    printed, folder = odd
    assert re.search(
        r"unit of \S*/box.stl: it is 30 mm long, \S*/box.STL 3 mm", printed
    )
    page = (folder / "index.html").read_text()
    assert printed.count("check the unit of") == page.count("box.stl: 30 mm long") == 1
