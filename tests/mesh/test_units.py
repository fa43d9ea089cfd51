"""Units: their names, doubts about them, and guesses."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from ros_pose_stats import load_part, part_from_mesh
from ros_pose_stats.errors import RequestError
from ros_pose_stats.mesh.files import read_mesh
from ros_pose_stats.mesh.units import METRES_PER_UNIT, likely_unit, metres_per_unit


def block_of(length, folder, suffix="stl"):
    path = folder / f"block.{suffix}"
    trimesh.creation.box((length, 0.5 * length, 0.4 * length)).export(path)
    return path


def told(part):
    """Code and sentence of the only warning."""
    (warning,) = part.warnings
    code, _, sentence = warning.partition(": ")
    return code, sentence


@pytest.mark.parametrize("unit", ["km", "", "mms", "auto", 0, -1.0, float("nan"), float("inf"),
                                  True, [1]])
def test_unknown_units_are_refused(unit):
    with pytest.raises(RequestError, match="expected a mesh unit of m, mm, cm, inch"):
        metres_per_unit(unit)


@pytest.mark.parametrize(("metres", "names"), [
    (1.0, ("m", "M", "metre", "meters", "Metres")),
    (1e-3, ("mm", "MM", " Mm ", "millimetre", "Millimetres", "MILLIMETERS")),
    (1e-2, ("cm", "CM", "centimetres", "centimeter")),
    (0.0254, ("inch", "Inch", "INCHES", "in"))])
def test_units_in_any_usual_spelling(metres, names):
    assert {metres_per_unit(name) for name in names} == {metres}
    assert metres_per_unit(0.3048) == 0.3048


@pytest.mark.parametrize(("extent", "suspect"), [
    (2.1, True), (1.9, False), (0.21e-3, False), (0.19e-3, True)])
def test_a_unit_that_was_named_is_doubted_beyond_what_is_fed(extent, suspect, tmp_path):
    mesh = trimesh.creation.box()
    for part in (part_from_mesh(mesh.vertices, mesh.faces, unit=extent),
                 load_part(block_of(extent * 1e3, tmp_path), "mm")):
        assert [line.split(":")[0] for line in part.warnings] == ["UNIT_SUSPECT"] * suspect


@pytest.mark.parametrize(("extent", "suspect"), [
    (1.1, True), (0.9, False), (0.6e-3, False), (0.4e-3, True)])
def test_a_unit_that_nobody_named_is_doubted_sooner(extent, suspect, tmp_path):
    part = load_part(block_of(extent, tmp_path))
    assert [line.split(":")[0] for line in part.warnings] == ["UNIT_SUSPECT"] * suspect
    assert load_part(tmp_path / "block.stl", "m").warnings == ()


def test_the_doubt_names_the_size_and_the_likely_unit(tmp_path):
    assert told(load_part(block_of(80.0, tmp_path))) == (
        "UNIT_SUSPECT", "the part is 80 m long, since its file names no unit and metres are "
        "assumed; in mm it would be 80 mm long: check the unit.")
    assert told(load_part(block_of(0.08, tmp_path), "mm")) == (
        "UNIT_SUSPECT", "the part is 0.08 mm long, unusual for a fed part; in m it would be "
        "80 mm long: check the unit.")
    assert told(load_part(block_of(1e5, tmp_path))) == (
        "UNIT_SUSPECT", "the part is 1e+05 m long, since its file names no unit and metres are "
        "assumed; check the unit.")


@pytest.mark.parametrize(("extent", "unit"), [
    (80.0, "mm"), (2.0, "mm"), (500.0, "mm"), (900.0, "mm"), (0.08, "m"), (0.002, "m"),
    (1.0, "inch"), (6e-4, "m"), (2e4, None), (1e-5, None)])
def test_the_likely_unit(extent, unit):
    assert likely_unit(extent) == unit


class TestAuto:
    def test_a_guess_is_told(self, tmp_path):
        path = block_of(80.0, tmp_path)
        part = load_part(path, "auto")
        assert np.ptp(part.vertices, axis=0) == pytest.approx([0.08, 0.04, 0.032])
        assert told(part) == (
            "UNIT_GUESSED", "the file names no unit; as its mesh is 80 units long, it was taken "
            "to be in mm, 80 mm long. Give the unit to be sure.")
        assert part.digest == load_part(path, "mm").digest
        moved = load_part(path, "AUTO", (1.0, 0.0, 0.0), center_in_unit=True)
        assert moved.center_of_mass == pytest.approx([1e-3, 0.0, 0.0])

    def test_a_file_that_declares_its_unit_is_believed(self, tmp_path):
        mesh = read_mesh(block_of(8000.0, tmp_path, "3mf"), "auto")
        assert (mesh.unit, mesh.unit_source) == (1e-3, "declared")

    def test_what_no_unit_makes_a_part_is_refused(self, tmp_path):
        with pytest.raises(RequestError, match="one 2e\\+04 units long; give its unit"):
            load_part(block_of(2e4, tmp_path), "auto")


class TestADeclaredUnit:
    """3MF files, as trimesh writes them, declare millimetres."""

    def test_a_given_unit_wins_and_the_contradiction_is_told(self, tmp_path):
        part = load_part(block_of(80.0, tmp_path, "3mf"), "cm")
        assert np.ptp(part.vertices, axis=0).max() == pytest.approx(0.8)
        assert told(part) == (
            "UNIT_OVERRIDDEN", "the file's own unit is mm, but it was taken to be in cm, as "
            "asked: all lengths are 10 times those that the file names.")
        assert load_part(tmp_path / "block.3mf", 0.5).warnings[0].startswith(
            "UNIT_OVERRIDDEN: the file's own unit is mm, but it was taken to be in units of 0.5 m")

    @pytest.mark.parametrize("unit", ["mm", 1e-3, 1.0000000001e-3, "auto", None])
    def test_one_that_agrees_is_no_contradiction(self, tmp_path, unit):
        assert load_part(block_of(80.0, tmp_path, "3mf"), unit).warnings == ()

    def test_it_goes_first_where_one_unit_is_given_for_several_files(self, tmp_path):
        declaring, silent = block_of(80.0, tmp_path, "3mf"), block_of(80.0, tmp_path)
        for unit in ("cm", "auto"):
            mesh = read_mesh(declaring, unit, unless_declared=True)
            assert (mesh.unit, mesh.unit_source) == (1e-3, "declared")
            assert load_part(declaring, unit, unless_declared=True).warnings == ()
        assert read_mesh(silent, "cm", unless_declared=True)[2:4] == (1e-2, "given")

    def test_a_unit_that_is_none_is_refused_all_the_same(self, tmp_path):
        with pytest.raises(RequestError, match="expected a mesh unit"):
            load_part(block_of(80.0, tmp_path, "3mf"), "km", unless_declared=True)


def test_every_unit_has_a_length():
    assert METRES_PER_UNIT == {"m": 1.0, "mm": 0.001, "cm": 0.01, "inch": 0.0254}
