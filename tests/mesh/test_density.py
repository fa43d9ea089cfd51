"""Density in place of a mass."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from ros_pose_stats import cli, load_part, part_from_mesh
from ros_pose_stats.errors import MassPropertiesError

BLOCK = trimesh.creation.box((20.0, 30.0, 40.0))


def part_of(mesh, **given):
    return part_from_mesh(mesh.vertices, mesh.faces, unit="mm", **given)


def test_the_mass_is_that_of_the_volume():
    part = part_of(BLOCK, density=7850.0)
    assert part.mass == pytest.approx(7850.0 * 24e-6)
    same = part_of(BLOCK, mass=part.mass)
    assert part.digest == same.digest
    assert np.array_equal(part.inertia, same.inertia)
    hollow = trimesh.util.concatenate([BLOCK, trimesh.creation.box((10.0, 10.0, 10.0))])
    hollow.faces[12:] = hollow.faces[12:, ::-1]
    assert part_of(hollow, density=1000).mass == pytest.approx(0.023)
    moved = part_of(BLOCK, density=1000, center_of_mass=(0.0, 0.0, 0.01),
                    inertia=np.diag([1e-5, 1e-5, 1e-5]))
    assert moved.mass == pytest.approx(0.024)


def test_a_mesh_with_a_small_hole_has_a_volume_and_one_of_loose_triangles_has_none():
    whole = part_of(BLOCK, density=1000)
    holed = part_from_mesh(BLOCK.vertices, BLOCK.faces[1:], unit="mm", density=1000)
    assert holed.mass == pytest.approx(whole.mass)
    loose = np.random.default_rng(3).uniform(size=(90, 3))
    with pytest.raises(MassPropertiesError, match=r"volume is not known.*give the mass instead"):
        part_from_mesh(loose, np.arange(90).reshape(-1, 3), density=1000)


@pytest.mark.parametrize(("given", "message"), [
    ({"density": 7.85}, "from 20 to 25000 kg/m³, got 7.85 kg/m³; 1 g/cm³ is 1000"),
    ({"density": 0.0}, "from 20 to 25000"), ({"density": -1000.0}, "from 20 to 25000"),
    ({"density": float("nan")}, "got nan"), ({"density": 1e6}, "from 20 to 25000"),
    ({"density": "steel"}, "a density in kg/m³, got 'steel'"),
    ({"density": 1000.0, "mass": 1.0}, "a mass or a density, got both")])
def test_refusals(given, message):
    with pytest.raises(MassPropertiesError, match=message):
        part_of(BLOCK, **given)


class TestCommands:
    def test_both_options_and_any_spelling_of_a_unit(self, tmp_path, capsys):
        path = tmp_path / "block.stl"
        BLOCK.export(path)
        for given in (("--mass", "0.024"), ("--density", "1000")):
            words = ["estimate", str(path), "--unit", "Millimetres", "--json", *given]
            assert cli.main(words) == 0
            printed = capsys.readouterr().out
            mass = load_part(path, "mm", **{given[0].strip("-"): float(given[1])})
            assert f'"part_digest": "{mass.digest}"' in printed

    @pytest.mark.parametrize(("words", "message"), [
        (("--mass", "1", "--density", "1000"), "not allowed with argument"),
        (("--unit", "furlong"), "invalid choice: 'furlong'"),
        (("--density", "7.85"), "got 7.85 kg/m³"), (("--mass", "-1"), "above 0 kg")])
    def test_refusals_are_one_line(self, tmp_path, capsys, words, message):
        path = tmp_path / "block.stl"
        BLOCK.export(path)
        try:
            status = cli.main(["estimate", str(path), *words])
        except SystemExit as end:
            status = end.code
        printed = capsys.readouterr()
        assert status == 2
        assert message in printed.err
        assert printed.err.count("\n") == 1
        assert printed.out == ""
