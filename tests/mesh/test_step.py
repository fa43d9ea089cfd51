"""STEP files: units, assemblies, divisions of circles, damaged files and a missing package."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import select
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from ros_pose_stats import cli, load_part
from ros_pose_stats.errors import MeshFileError
from ros_pose_stats.mesh import step
from ros_pose_stats.mesh.files import read_mesh
from ros_pose_stats.mesh.step import declared_step_unit, tessellate_step
from tests.mesh.step_text import Disc, step_assembly, step_part

installed = pytest.mark.skipif(importlib.util.find_spec("cascadio") is None,
                               reason="the extra `step` is not installed")
UPRIGHT = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def written(path, text):
    path.write_text(text, encoding="ascii")
    return path


def on_circle(vertices, x, y, radius):
    """Directions of the vertices at z = 0 on a circle about (x, y), each once, in degrees."""
    around = np.unique(vertices, axis=0)
    around = around[np.abs(around[:, 2]) < 1e-9] - (x, y, 0.0)
    on = np.abs(np.hypot(around[:, 0], around[:, 1]) / radius - 1.0) < 1e-3
    return np.sort(np.degrees(np.arctan2(around[on, 1], around[on, 0])))


@installed
class TestRead:
    @pytest.mark.parametrize(("name", "unit", "metres"), [
        ("a.step", "mm", 1e-3), ("a.STEP", "cm", 1e-2), ("a.stp", "inch", 0.0254),
        ("a.Stp", "m", 1.0)])
    def test_the_unit_is_that_of_the_file_unless_one_is_given(self, tmp_path, name, unit, metres):
        path = written(tmp_path / name, step_part(Disc(0.4, 0.2), unit=unit))
        mesh = read_mesh(path)
        assert mesh.unit == metres
        assert np.ptp(mesh.vertices, axis=0) == pytest.approx([0.8, 0.8, 0.2], rel=1e-6)
        part = load_part(path)
        assert np.ptp(part.vertices, axis=0) == pytest.approx(
            np.multiply([0.8, 0.8, 0.2], metres), rel=1e-6)
        assert part.part_id == "a"
        assert np.ptp(load_part(path, "cm").vertices[:, 2]) == pytest.approx(2e-3, rel=1e-6)
        # The centre of mass is given in the unit of the file too.
        moved = load_part(path, center_of_mass=(0.1, 0.0, 0.1), center_in_unit=True)
        assert moved.center_of_mass == pytest.approx(np.multiply([0.1, 0.0, 0.1], metres))

    @pytest.mark.parametrize("hole", [0.02, 0.5, 12.0])
    def test_every_circle_has_96_sides_whatever_its_radius(self, tmp_path, hole):
        path = written(tmp_path / "plate.step", step_part(Disc(40.0, 2.0, [(20.0, 0.0, hole)])))
        vertices = read_mesh(path).vertices
        for center, radius in ((0.0, 40.0), (20.0, hole)):
            directions = on_circle(vertices, center, 0.0, radius)
            assert len(directions) == 96
            assert np.diff(directions) == pytest.approx(360.0 / 96, abs=0.02)
        part = load_part(path)
        assert part.warnings == ()
        # A regular polygon of 96 sides is that much smaller than its circle.
        share = 96 / (2.0 * np.pi) * np.sin(2.0 * np.pi / 96)
        surface = trimesh.Trimesh(part.surface_vertices, part.surface_triangles)
        assert surface.is_watertight
        assert surface.volume * 1e9 == pytest.approx(
            2.0 * np.pi * (40.0**2 - hole**2) * share, rel=1e-5)
        assert part.center_of_mass[0] * 1e3 == pytest.approx(
            -20.0 * hole**2 / (40.0**2 - hole**2), rel=1e-4, abs=1e-5)

    def test_the_same_file_gives_the_same_digest_and_float32_shows(self, tmp_path):
        path = written(tmp_path / "plate.step", step_part(Disc(7.3, 1.1, [(1.7, 0.3, 0.9)])))
        part = load_part(path)
        assert load_part(path).digest == part.digest
        assert part.rounding == pytest.approx(7.3e-3 * 2.0**-24, rel=1e-6)

    def test_several_solids_are_one_part(self, tmp_path):
        path = written(tmp_path / "two.step", step_part(
            Disc(5.0, 2.0), Disc(5.0, 4.0, center=(30.0, 0.0, 0.0))))
        part = load_part(path)
        assert part.warnings == ()
        assert part.center_of_mass * 1e3 == pytest.approx([20.0, 0.0, (1.0 + 2 * 2.0) / 3])

    def test_every_instance_of_an_assembly_is_there_and_in_its_place(self, tmp_path):
        lying = ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
        path = written(tmp_path / "assembly.step", step_assembly(Disc(5.0, 2.0), [
            ((0.0, 0.0, 0.0), *UPRIGHT), ((20.0, 0.0, 0.0), *lying),
            ((0.0, 40.0, 0.0), *UPRIGHT)]))
        part = load_part(path)
        assert part.vertices.max(axis=0) * 1e3 == pytest.approx([22.0, 45.0, 5.0])
        assert part.vertices.min(axis=0) * 1e3 == pytest.approx([-5.0, -5.0, -5.0])
        assert part.center_of_mass * 1e3 == pytest.approx([7.0, 40.0 / 3, 2.0 / 3])

    def test_a_command_prints_json_and_nothing_else(self, tmp_path, capfd):
        path = written(tmp_path / "disc.step", step_part(Disc(5.0, 2.0, [(1.0, 0.0, 1.0)])))
        assert cli.main(["estimate", str(path), "--method", "meae", "--json"]) == 0
        printed = capfd.readouterr()
        assert json.loads(printed.out)["part_id"] == "disc"
        assert printed.err == ""


@installed
class TestDamaged:
    @pytest.mark.parametrize("share", [0.0, 0.001, 0.1, 0.5, 0.9, 0.99])
    def test_a_file_cut_off_is_refused_in_one_line(self, tmp_path, capfd, share):
        text = step_part(Disc(5.0, 2.0))
        self.refused(tmp_path, text[:int(share * len(text))].encode(), capfd)

    @pytest.mark.parametrize("data", [
        b"hello", b"\0" * 500, np.random.default_rng(3).bytes(100_000),
        b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"])
    def test_what_is_no_step_file_is_refused_in_one_line(self, tmp_path, capfd, data):
        self.refused(tmp_path, data, capfd)

    def test_whatever_a_lost_line_does_it_ends_nothing_but_its_file(self, tmp_path):
        lines = step_part(Disc(5.0, 2.0)).splitlines()
        for lost in range(8, len(lines) - 2, 4):
            text = "\n".join(lines[:lost] + lines[lost + 1:])
            with contextlib.suppress(MeshFileError):
                assert len(read_mesh(written(tmp_path / "lost.step", text)).triangles) > 0

    @staticmethod
    def refused(folder, data, capfd):
        path = folder / "damaged.step"
        path.write_bytes(data)
        with pytest.raises(MeshFileError) as refusal:
            read_mesh(path)
        assert "damaged.step" in str(refusal.value)
        assert "\n" not in str(refusal.value)
        assert capfd.readouterr() == ("", "")


@installed
@pytest.mark.parametrize(("program", "message"), [
    ("import os, signal; print('noise'); os.kill(os.getpid(), signal.SIGSEGV)", "readable STEP"),
    ("import time; time.sleep(60)", "tessellated within 0.5 s, got a.step of 1e-06 MB")])
def test_a_crash_and_a_hang_become_refusals(tmp_path, monkeypatch, capfd, program, message):
    monkeypatch.setattr(step, "_PROGRAM", written(tmp_path / "program.py", program))
    with pytest.raises(MeshFileError, match=message):
        tessellate_step(Path("a.step"), b"x", most_seconds=0.5)
    assert capfd.readouterr() == ("", "")


STARTER = """
import subprocess
from pathlib import Path
from ros_pose_stats.mesh import step

def run(command, **_):
    running = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    print("started", flush=True)
    running.wait()

step.subprocess.run = run
step.tessellate_step(Path("a.step"), b"")
"""


@installed
def test_a_tessellation_ends_with_whoever_started_it():
    """By `kill -9`, and in the middle of its work: here it waits for more input."""
    held, writes = os.pipe()
    starter = subprocess.Popen([sys.executable, "-c", STARTER], stdin=held,
                               stdout=subprocess.PIPE)
    os.close(held)
    try:
        assert starter.stdout.readline() == b"started\n"
        starter.kill()
        starter.wait()
        # It has this pipe open, too, as long as it is there.
        assert select.select([starter.stdout], [], [], 30.0)[0], "it stays"
        assert starter.stdout.read() == b""
    finally:
        os.close(writes)
        starter.stdout.close()


def test_without_the_package_a_sentence_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    path = written(tmp_path / "a.step", step_part(Disc(5.0, 2.0)))
    with pytest.raises(MeshFileError, match="pip install cascadio") as refusal:
        read_mesh(path)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(("unit", "metres"), [
    ("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("inch", 0.0254)])
def test_declared_units(unit, metres):
    assert declared_step_unit(step_part(Disc(1.0, 1.0), unit=unit).encode()) == metres


@pytest.mark.parametrize("text", [
    "", "GLOBAL_UNIT_ASSIGNED_CONTEXT((#7,#8))", "GLOBAL_UNIT_ASSIGNED_CONTEXT((#1));"
    "#1=(CONVERSION_BASED_UNIT('A',#2)LENGTH_UNIT());#2=X(LENGTH_MEASURE(2.),#1);"])
def test_a_file_without_a_unit_is_in_millimetres(text):
    assert declared_step_unit(text.encode()) == 1e-3
