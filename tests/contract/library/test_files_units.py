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

"""Units: their names, what a file declares, guesses, and doubts about them."""

import zipfile

import numpy as np
import pytest
import trimesh

from lab.bodies import shapes
from ros_pose_stats import estimate, load_part, part_from_mesh
from tests.running import refusal_of


def block_of(length, folder, suffix="stl", width=0.5, height=0.4):
    """File of a block, width and height in lengths; 3MF files declare millimetres."""
    path = folder / f"block.{suffix}"
    trimesh.creation.box((length, width * length, height * length)).export(path)
    return path


def length_of(part):
    return float(np.ptp(part.vertices, axis=0).max())


def told(part):
    (warning,) = part.warnings
    return warning.code, warning.text


@pytest.mark.parametrize(
    ("metres", "names"),
    [
        (1.0, ("m", "M", "metre", "meters", "Metres", 1)),
        (1e-3, ("mm", "MM", " Mm ", "millimetre", "Millimetres", "MILLIMETERS", 1e-3)),
        (1e-2, ("cm", "CM", "centimetres", "centimeter")),
        (0.0254, ("inch", "Inch", "INCHES", "in")),
        (0.3048, (0.3048,)),
    ],
)
def test_units_in_any_usual_spelling_or_as_metres(metres, names):
    for name in names:
        assert (
            length_of(part_from_mesh(*shapes.box(1.0, 0.5, 0.4), unit=name)) == metres
        )


@pytest.mark.parametrize(
    "unit",
    [
        "km",
        "",
        "mms",
        0,
        -1.0,
        float("nan"),
        float("inf"),
        True,
        [1],
        10**400,
        np.array([1.0]),
        1j,
    ],
)
def test_what_is_no_unit_is_refused(unit, tmp_path):
    for make in (
        lambda: part_from_mesh(*shapes.box(1.0, 1.0, 1.0), unit=unit),
        lambda: load_part(block_of(80.0, tmp_path, "3mf"), unit, unless_declared=True),
    ):
        assert "expected a mesh unit of m, mm, cm, inch" in refusal_of(make)


def test_no_unit_is_asked_for_where_a_vertex_is_none(tmp_path):
    file = tmp_path / "nan.obj"
    file.write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"
    )
    assert "finite vertices" in refusal_of(load_part, file, "auto")


@pytest.mark.parametrize(
    ("length", "unit", "suspect"),
    [
        (2100.0, "mm", True),
        (1900.0, "mm", False),
        (0.21, "mm", False),
        (0.19, "mm", True),
        (2.1, "m", True),
    ],
)
def test_a_size_that_is_not_fed_is_doubted(tmp_path, length, unit, suspect):
    part = load_part(block_of(length, tmp_path), unit)
    assert [warning.code for warning in part.warnings] == ["UNIT_SUSPECT"] * suspect


def test_the_doubt_names_the_size_in_other_units():
    code, sentence = told(part_from_mesh(*shapes.box(80.0, 40.0, 32.0)))
    assert code == "UNIT_SUSPECT"
    assert "80 m long" in sentence and "80 mm in mm, " in sentence


@pytest.mark.parametrize(
    ("length", "unit", "others"),
    [
        (80.0, "mm", "80 m in m, 800 mm in cm, 2.03 m in inch"),
        (0.61, "mm", "610 mm in m, 6.1 mm in cm, 15.5 mm in inch"),
        (0.6, "m", "0.6 mm in mm, 6 mm in cm, 15.2 mm in inch"),
        (6e-4, "m", "0.6 µm in mm, 6 µm in cm, 0.0152 mm in inch"),
    ],
)
@pytest.mark.parametrize("asked", ["auto", None])
def test_a_file_without_a_unit_is_in_metres_up_to_a_length_else_in_millimetres(
    tmp_path, length, unit, others, asked
):
    path = block_of(length, tmp_path, "obj")
    part = load_part(path, asked)
    named = load_part(path, unit)
    assert part.digest == named.digest
    assert (part.unit, part.unit_guessed) == (named.unit, True)
    assert not named.unit_guessed
    code, sentence = told(part)
    assert code == "UNIT_GUESSED" and f"taken to be in {unit}, " in sentence
    assert sentence.endswith(
        f" long (else {others}). Give the unit to be sure: --unit {unit}."
    )


@pytest.mark.parametrize("suffix", ["stl", "ply", "obj"])
def test_a_length_on_the_border_is_in_metres_however_it_is_rounded(tmp_path, suffix):
    """In float32, 0.6 is a little more than 0.6."""
    assert load_part(block_of(0.6, tmp_path, suffix)).unit == 1.0


def test_an_unlikely_size_is_doubted_beside_the_guess(tmp_path):
    codes = [warning.code for warning in load_part(block_of(2e4, tmp_path)).warnings]
    assert codes == ["UNIT_GUESSED", "UNIT_SUSPECT"]


def test_a_guess_travels_with_the_answer(tmp_path):
    path = block_of(80.0, tmp_path)
    for unit, length, is_guessed in ((None, 1e-3, True), ("cm", 1e-2, False)):
        values = estimate(load_part(path, unit), "csae").as_dict()
        assert (values["unit"], values["unit_guessed"]) == (length, is_guessed)
        assert values["units"]["unit"] == "m"
    values = estimate(part_from_mesh(*shapes.box(80.0, 50.0, 40.0), unit="mm"), "csae")
    assert (values.unit, values.unit_guessed) == (1e-3, False)


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("inch", 0.0254), pytest.param(None, 1e-3, marks=pytest.mark.long)],
)
def test_a_3mf_declares_its_unit(tmp_path, unit, metres):
    target = tmp_path / "target.3mf"
    with (
        zipfile.ZipFile(block_of(30.0, tmp_path, "3mf")) as old,
        zipfile.ZipFile(target, "w") as new,
    ):
        for name in old.namelist():
            attribute = b"" if unit is None else f'unit="{unit}"'.encode()
            new.writestr(name, old.read(name).replace(b'unit="millimeter"', attribute))
    assert length_of(load_part(target, "auto" if unit else None)) == pytest.approx(
        30.0 * metres
    )


def test_a_given_unit_wins_over_a_declared_one_and_the_contradiction_is_told(tmp_path):
    path = block_of(80.0, tmp_path, "3mf")
    part = load_part(path, "cm")
    assert length_of(part) == pytest.approx(0.8)
    code, sentence = told(part)
    assert (
        code == "UNIT_OVERRIDDEN"
        and "own unit is mm, but it was taken to be in cm" in sentence
    )


@pytest.mark.long
def test_a_declared_unit_goes_first_where_another_is_given_for_several_files(tmp_path):
    path = block_of(80.0, tmp_path, "3mf")
    assert "in units of 0.5 m" in load_part(path, 0.5).warnings[0].text
    assert load_part(path, 1.0000000001e-3).warnings == ()
    part = load_part(path, "cm", unless_declared=True)
    assert (length_of(part), part.warnings) == (pytest.approx(0.08), ())
    silent = load_part(block_of(8.0, tmp_path), "cm", unless_declared=True)
    assert (length_of(silent), silent.warnings) == (pytest.approx(0.08), ())
