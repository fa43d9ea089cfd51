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

"""STEP files: units, divisions of circles, assemblies, and damaged ones, which end
nobody else.

Each reading starts a process, so few files are read in a quick run.
"""

import contextlib
import importlib.util
import io
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import trimesh

from lab.bodies.step_text import Disc, StepText, step_assembly, step_part
from ros_pose_stats import (
    PoseStatsError,
    auto,
    compare,
    estimate,
    hybrid,
    load_part,
    sensitivity,
    shift_center,
    simulate,
    simulate_flips,
    suggest,
)
from ros_pose_stats.tools.cli import main
from tests.answers import acting_codes
from tests.running import (
    ROOT,
    about,
    answer,
    answer_json,
    call,
    children,
    is_gone,
    refusal,
    refusal_of,
)

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("cascadio") is None,
    reason="the extra `step` is not installed",
)
WHOLE_DISC = Disc(5.0, 2.0)
WHOLE = step_part(WHOLE_DISC)
HOLED = Disc(5.0, 2.0, [(1.5, 0.0, 1.0)])
OPEN = step_part(HOLED, lost=[1])
"""The wall of the bore is lost, and nobody can say what was between its rims."""


def written(path, text):
    path.write_text(text, encoding="ascii")
    return path


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "unit", "metres"), [("a.STEP", "cm", 1e-2), ("a.Stp", "m", 1.0)]
)
def test_the_unit_is_that_of_the_file(tmp_path, name, unit, metres):
    path = written(tmp_path / name, step_part(Disc(0.4, 0.2), unit=unit))
    part = load_part(path)
    assert np.ptp(part.vertices, axis=0) == pytest.approx(
        np.multiply([0.8, 0.8, 0.2], metres), rel=1e-6
    )
    assert part.part_id == "a"


def test_a_file_without_a_unit_is_in_millimetres_and_a_command_prints_json_alone(
    tmp_path, capfd
):
    silent = WHOLE.replace(
        "GLOBAL_UNIT_ASSIGNED_CONTEXT", "GLOBAL_UNIT_FORGOTTEN_CONTEXT"
    )
    path = written(tmp_path / "disc.step", silent)
    assert answer_json("estimate", path, "--method", "meae")["radius"] == pytest.approx(
        1e-3 * np.hypot(5.0, 1.0), rel=1e-6
    )
    assert capfd.readouterr() == ("", "")


@pytest.mark.long
def test_a_unit_that_is_given_wins(tmp_path):
    part = load_part(written(tmp_path / "a.step", WHOLE), "cm")
    assert np.ptp(part.vertices[:, 2]) == pytest.approx(0.02, rel=1e-6)


@pytest.mark.long
def test_every_circle_has_96_sides_whatever_its_radius(tmp_path):
    holes = [(20.0, 0.0, 12.0), (-20.0, 0.0, 0.02)]
    part = load_part(
        written(tmp_path / "plate.step", step_part(Disc(40.0, 2.0, holes)))
    )
    assert part.warnings == ()
    assert part.rounding == pytest.approx(
        40e-3 * 2.0**-24, rel=1e-6
    )  # coordinates are float32
    corners = part.surface_vertices * 1e3
    for center, radius in ((0.0, 40.0), (20.0, 12.0), (-20.0, 0.02)):
        circle = corners[np.abs(corners[:, 2]) < 1e-6] - (center, 0.0, 0.0)
        on_circle = np.abs(np.hypot(circle[:, 0], circle[:, 1]) / radius - 1.0) < 1e-3
        directions = np.sort(
            np.degrees(np.arctan2(circle[on_circle, 1], circle[on_circle, 0]))
        )
        assert len(directions) == 96
        assert np.diff(directions) == pytest.approx(360.0 / 96, abs=0.02)
    # A regular polygon of 96 sides is that much smaller than its circle.
    share = 96 / (2.0 * np.pi) * np.sin(2.0 * np.pi / 96)
    areas = np.array((40.0**2, -(12.0**2), -(0.02**2)))
    surface = trimesh.Trimesh(part.surface_vertices, part.surface_triangles)
    assert surface.volume * 1e9 == pytest.approx(
        2.0 * np.pi * areas.sum() * share, rel=1e-5
    )
    assert part.center_of_mass[0] * 1e3 == pytest.approx(
        areas @ (0.0, 20.0, -20.0) / areas.sum(), rel=1e-4
    )


def test_several_solids_and_every_instance_of_an_assembly_are_in_their_places(tmp_path):
    two = load_part(
        written(
            tmp_path / "two.stp",
            step_part(
                Disc(0.5, 0.2), Disc(0.5, 0.4, center=(3.0, 0.0, 0.0)), unit="inch"
            ),
        ),
        body="all",
    )
    assert (two.part_id, acting_codes(two)) == ("two", [])
    assert two.center_of_mass / 0.0254 == pytest.approx([2.0, 0.0, (0.1 + 2 * 0.2) / 3])
    upright = ((1, 0, 0), (0, 0, 1))
    lying = ((0, 1, 0), (1, 0, 0))
    part = load_part(
        written(
            tmp_path / "assembly.step",
            step_assembly(
                Disc(5.0, 2.0),
                [((0, 0, 0), *upright), ((20, 0, 0), *lying), ((0, 40, 0), *upright)],
            ),
        ),
        body="all",
    )
    assert part.vertices.max(axis=0) * 1e3 == pytest.approx([22.0, 45.0, 5.0])
    assert part.vertices.min(axis=0) * 1e3 == pytest.approx([-5.0, -5.0, -5.0])
    assert part.center_of_mass * 1e3 == pytest.approx([7.0, 40.0 / 3, 2.0 / 3])


@pytest.mark.parametrize("count", [2, 3])
def test_points_beside_a_solid_are_left_out(tmp_path, count):
    """Drawings have construction points and lines: three of them are no triangle."""
    step = StepText()
    context = step.context("mm")
    items = f"{step.axes(0.0, 0.0, 0.0)},{step.solid(WHOLE_DISC)}"
    solid = step.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION('',({items}),{context})")
    step.product("part", solid)
    points = ",".join(
        step.triple("CARTESIAN_POINT", (50.0, 10.0 * k, k * k)) for k in range(count)
    )
    curves = step.add(f"GEOMETRIC_CURVE_SET('',({points}))")
    wires = step.add(
        f"GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION('',({curves}),{context})"
    )
    step.add(f"SHAPE_REPRESENTATION_RELATIONSHIP('','',{solid},{wires})")
    part = load_part(written(tmp_path / "points.step", step.text()))
    assert part.warnings == ()
    size = np.ptp(part.vertices, axis=0)
    assert size == pytest.approx([0.01, 0.01, 0.002], rel=1e-3)


def assert_refused(path, data):
    path.write_bytes(data)
    assert "damaged.step" in refusal_of(load_part, path)


@pytest.mark.long
def test_what_is_no_step_file_is_refused_in_one_line(tmp_path, capfd):
    for data in (
        WHOLE.encode()[: len(WHOLE) // 2],
        np.random.default_rng(3).bytes(100_000),
    ):
        assert_refused(tmp_path / "damaged.step", data)
    assert capfd.readouterr() == ("", "")


@pytest.mark.long
def test_whatever_is_lost_it_ends_nothing_but_its_file(tmp_path, capfd):
    path = tmp_path / "damaged.step"
    lines = WHOLE.splitlines()
    empty = "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"
    for text in (
        "hello",
        "\0" * 500,
        empty,
        *(WHOLE[: int(share * len(WHOLE))] for share in (0.0, 0.001, 0.1, 0.9, 0.99)),
    ):
        assert_refused(path, text.encode())
    for lost in range(8, len(lines) - 2, 4):
        with contextlib.suppress(PoseStatsError):
            assert (
                len(
                    load_part(
                        written(path, "\n".join(lines[:lost] + lines[lost + 1 :]))
                    ).triangles
                )
                > 0
            )
    assert capfd.readouterr() == ("", "")


@pytest.mark.long
def test_a_tessellation_ends_with_whoever_started_it(tmp_path):
    """By `kill -9`, and in the middle of its work, where it is stopped before; we are
    sooner.
    """
    path = written(tmp_path / "a.step", f"{WHOLE}\n{time.time_ns()}")
    with subprocess.Popen(
        [sys.executable, "-m", "ros_pose_stats", "estimate", path],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        preexec_fn=lambda: os.nice(5),
    ) as starter:
        while not (started := children(starter.pid)):
            assert starter.poll() is None
        (child,) = started
        while "cascadio" not in about(child, "maps"):
            assert starter.poll() is None
        os.kill(child, signal.SIGSTOP)
        starter.kill()
    while not is_gone(child):
        pass


def test_a_file_is_tessellated_once(tmp_path, monkeypatch):
    """Whatever its name; then without a process to read it in."""
    new_text = f"{WHOLE}\n{time.time_ns()}\n"
    digest = load_part(written(tmp_path / "a.step", new_text)).digest
    monkeypatch.setattr(sys, "executable", str(tmp_path / "none"))
    assert load_part(written(tmp_path / "b.stp", new_text)).digest == digest
    other = written(tmp_path / "c.step", f"{new_text}\n")
    assert "a process to read" in refusal_of(load_part, other)


@pytest.fixture(scope="module")
def open_file(tmp_path_factory):
    return written(tmp_path_factory.mktemp("open") / "open.step", OPEN)


@pytest.fixture(scope="module")
def accepted_hull(open_file):
    return load_part(open_file, accept_open=True)


def test_an_open_solid_is_refused_with_the_number_of_its_open_edges(open_file):
    line = refusal_of(load_part, open_file)
    assert "192 open edges" in line and "two may be the ends of one bore" in line
    assert "--accept-open" in line and "accept_open" in line
    assert refusal("estimate", open_file) == f"ros_pose_stats: {line}"
    # Above all where the volume decides the mass.
    assert refusal_of(load_part, open_file, density=7850.0) == line


@pytest.mark.parametrize(("disc", "lost"), [(WHOLE_DISC, 2), (HOLED, 3)])
def test_a_solid_without_a_face_is_refused_though_a_flat_one_would_close_it(
    tmp_path, disc, lost
):
    """The last face of each: nobody knows what was there, perhaps a dome."""
    path = written(tmp_path / "open.step", step_part(disc, lost=[lost]))
    line = refusal_of(load_part, path)
    assert "open edges" in line and "--accept-open" in line
    assert_no_error(estimate(load_part(path, accept_open=True), "split"))


def assert_no_error(answer):
    assert np.isnan([answer.expected_error, answer.largest_error]).all()
    for pose in answer.poses:
        assert np.isnan([pose.probability_low, pose.probability_high]).all()
        assert np.isnan(pose.standard_error)
    assert sum(pose.probability for pose in answer.poses) == pytest.approx(1.0)
    (warning,) = [warning for warning in answer.warnings if warning.code == "OPEN_MESH"]
    assert "No error is told" in warning.text


def test_the_hull_of_an_open_solid_is_answered_without_an_error(accepted_hull):
    whole_disc = np.pi * 5e-3**2 * 2e-3
    surface = trimesh.Trimesh(
        accepted_hull.surface_vertices, accepted_hull.surface_triangles
    )
    assert surface.volume == pytest.approx(whole_disc, rel=1e-3)
    for part in (accepted_hull, shift_center(accepted_hull, [1e-4, 0.0, 0.0])):
        assert_no_error(estimate(part, "eae"))
        assert_no_error(estimate(part, "split"))
        default = auto(part)
        assert_no_error(default)
        assert default.drops == 0 and "no error" in default.choice
    told_errors = []

    def keep_error(progress):
        told_errors.append(progress.expected_error)
        assert_no_error(progress.statistics())

    counted = simulate(accepted_hull, 300, seed=1, on_progress=keep_error)
    assert_no_error(counted)
    assert counted.drops == sum(pose.count for pose in counted.poses) == 300
    assert told_errors and np.isnan(told_errors).all()


@pytest.mark.parametrize(
    "ask",
    [
        lambda part: simulate(part, 100, target_error=0.1),
        lambda part: hybrid(part, 100),
        lambda part: auto(part, 0.1),
        lambda part: simulate_flips(part, 0.01, 10),
        lambda part: sensitivity(part, [0]),
        lambda part: suggest(part, [0], 1e-4),
        lambda part: compare([part, part]),
    ],
)
def test_what_is_an_error_by_itself_is_refused_for_the_hull(accepted_hull, ask):
    assert "a closed surface" in refusal_of(ask, accepted_hull)


def test_commands_take_the_hull_where_they_are_told_to(open_file, tmp_path):
    values = answer_json("estimate", open_file, "--accept-open")
    assert (values["expected_error"], values["largest_error"]) == (None, None)
    assert {pose["probability_low"] for pose in values["poses"]} == {None}
    values = answer_json("simulate", open_file, "--accept-open", "--drops", 100)
    assert (values["expected_error"], values["drops"]) == (None, 100)


@pytest.mark.parametrize(
    "command",
    [["estimate"], ["estimate", "--method", "all"], ["simulate", "--drops", 100]],
)
def test_tables_of_the_hull_have_no_error_and_say_why(open_file, command):
    table = answer(*command, open_file, "--accept-open")
    assert "No error is told" in table
    assert not re.search(r"nan\b|interval|expected error|METHODS_DISAGREE", table)


@pytest.mark.long
def test_the_page_of_the_hull_has_no_error(open_file, tmp_path):
    page = tmp_path / "page.html"
    answer("report", open_file, "--accept-open", "--drops", 100, "-o", page)
    text = page.read_text(encoding="utf-8")
    words = re.sub("<[^>]*>", " ", text.partition("<body")[2]).split()
    assert "nan" not in words and "--accept-open" in words
    assert "90 % confidence" not in text


@pytest.mark.long
def test_a_catalogue_has_the_refusal_in_its_row(open_file, tmp_path):
    call("catalogue", open_file, "-o", tmp_path)
    assert "192 open edges" in (tmp_path / "catalogue.csv").read_text(encoding="utf-8")


class Terminal(io.StringIO):
    """A terminal that makes a file once it is told that something is read."""

    def __init__(self, file):
        super().__init__()
        self.file = file

    def isatty(self):
        return True

    def write(self, words):
        if "reading slow.step, " in words:
            self.file.touch()
        return super().write(words)


@pytest.mark.long
def test_a_terminal_is_told_what_is_read_for_long(tmp_path, monkeypatch):
    """Until the file is read, which here waits for that."""
    path = written(tmp_path / "slow.step", f"{WHOLE}\n{time.time_ns()}\n")
    screen = Terminal(tmp_path / "line")
    waiting = f"until [ -e {screen.file} ]; do :; done\n"
    python = tmp_path / "python"
    python.write_text(f'#!/bin/sh\n{waiting}exec {sys.executable} "$@"\n')
    python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))
    with contextlib.redirect_stderr(screen):
        assert main(["estimate", str(path), "--method", "eae"]) == 0
    lines = screen.getvalue().split("\r")
    assert lines[1].startswith("reading slow.step, ")
    assert lines[-2].isspace() and lines[-1] == ""  # the line is gone


def test_without_the_package_a_sentence_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(
        PoseStatsError, match=r"cascadio, .*pip install 'ros_pose_stats\[step\]'"
    ):
        load_part(written(tmp_path / "a.step", step_part(Disc(5.0, 2.0))))
