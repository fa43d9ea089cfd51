"""Units: their names, what a file declares, guesses, and doubts about them."""

import zipfile

import numpy as np
import pytest
import trimesh

from lab.bodies import shapes
from ros_pose_stats import load_part, part_from_mesh
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
    code, _, sentence = warning.partition(": ")
    return code, sentence


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
        # Doubted sooner where nobody named a unit.
        (1.1, None, True),
        (0.9, None, False),
        (0.6e-3, None, False),
        (0.4e-3, None, True),
        (1.1, "m", False),
    ],
)
def test_a_size_that_is_not_fed_is_doubted(tmp_path, length, unit, suspect):
    part = load_part(block_of(length, tmp_path), unit)
    assert [line.split(":")[0] for line in part.warnings] == ["UNIT_SUSPECT"] * suspect


def test_the_doubt_names_the_size_and_the_likely_unit(tmp_path):
    code, sentence = told(load_part(block_of(80.0, tmp_path)))
    assert code == "UNIT_SUSPECT"
    assert "80 m long" in sentence and "likely in mm: 80 mm;" in sentence
    sentence = told(load_part(block_of(0.08, tmp_path), "mm"))[1]
    assert "0.08 mm long" in sentence and "likely in m: 80 mm;" in sentence
    assert "likely" not in told(load_part(block_of(1e5, tmp_path)))[1]


@pytest.mark.parametrize(
    ("extents", "unit", "others"),
    [
        ((80.0, 40.0, 32.0), "mm", " (else in cm: 800 mm)"),
        ((900.0, 450.0, 360.0), "mm", ""),
        ((2.0, 1.0, 0.8), "mm", " (else in cm: 20 mm, inch: 50.8 mm)"),
        ((6e-4, 3e-4, 2e-4), "m", ""),
        # Round in inches, and long ones in metres.
        ((5.0, 2.5, 1.375), "inch", " (else in mm: 5 mm, cm: 50 mm)"),
        ((203.2, 304.8, 12.7), "mm", ""),
        ((0.52, 0.26, 0.2), "m", " (else in cm: 5.2 mm, inch: 13.2 mm, mm: 0.52 mm)"),
    ],
)
def test_a_guess_is_that_of_a_part_for_a_feeder_with_round_lengths(
    tmp_path, extents, unit, others
):
    length, width, height = extents
    path = block_of(length, tmp_path, width=width / length, height=height / length)
    part = load_part(path, "auto")
    assert part.digest == load_part(path, unit).digest
    code, sentence = told(part)
    assert code == "UNIT_GUESSED" and f"taken to be in {unit}, " in sentence
    assert sentence.endswith(f" long{others}. Give the unit to be sure: --unit {unit}.")


def test_what_no_unit_makes_a_part_is_not_guessed(tmp_path):
    for extent in (2e4, 1e-5):
        assert "units long; give its unit" in refusal_of(
            load_part, block_of(extent, tmp_path), "auto"
        )


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
    assert "in units of 0.5 m" in load_part(path, 0.5).warnings[0]
    assert load_part(path, 1.0000000001e-3).warnings == ()
    part = load_part(path, "cm", unless_declared=True)
    assert (length_of(part), part.warnings) == (pytest.approx(0.08), ())
    silent = load_part(block_of(8.0, tmp_path), "cm", unless_declared=True)
    assert (length_of(silent), silent.warnings) == (pytest.approx(0.08), ())
