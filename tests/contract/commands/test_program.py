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

"""The command as a whole: version, exit statuses, numbers as people type them, broken
pipes.
"""

import contextlib
import io
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import ros_pose_stats
from ros_pose_stats.tools.cli import main
from tests.contract.bags.recorders import write_recorded
from tests.running import ROOT, answer, answer_json, call, complaints, refusal

PART = "part.stl"


def test_the_console_script_refuses_in_one_line(parts):
    script = shutil.which("ros_pose_stats", path=Path(sys.executable).parent)
    if script is None:
        pytest.skip("the package is not installed beside this interpreter")
    outcome = subprocess.run(
        [script, "estimate", parts / "missing.stl"], capture_output=True, text=True
    )
    assert (outcome.returncode, outcome.stdout) == (2, "")
    (line,) = complaints(outcome.stderr)
    assert "missing.stl" in line and "No such file" in line


@pytest.mark.parametrize(
    "words", [[], ["--help"], ["estimate", "--help"], ["fit", "-h"]]
)
def test_help(words):
    assert answer(*words).startswith(
        f"usage: ros_pose_stats {words[0] if words[1:] else ''}"
    )


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["estimat", PART], "estimate"),
        (["estimate", PART, "--drop-heigt", "1"], "--drop-height"),
        (["estimate", PART, "--method", "splt"], "split"),
        (["--vrsion"], "--version"),
    ],
)
def test_a_misspelt_word_is_answered_with_the_one_that_was_meant(words, meant):
    line = refusal(*words)
    assert f"did you mean {meant}?" in line and "choose from" not in line


@pytest.mark.parametrize(
    "words",
    [
        ["frobnicate"],
        ["--colour"],
        ["estimate"],
        ["estimate", PART, "--colour"],
        ["estimate", PART, "--ros-args", "-p", "a:=1"],
        ["node", "-p", "restitution:=0.3"],
        ["estimate", PART, "--unit=--"],
        ["report", PART, "-o--"],
    ],
)
def test_what_is_no_command_is_refused_with_what_to_do(words):
    line = refusal(*words)
    assert "--help" in line or "--ros-args" in line


@pytest.fixture(scope="module")
def loaded(parts):
    """By command what it loads, or asks for in vain, in a process that cannot import
    ROS.

    Each begins in a copy of the process in which help was asked for alone.
    """
    code = f"""
import os, sys
asked = []
class NoRos:
    def find_spec(self, name, path=None, target=None):
        package = name.partition(".")[0]
        if package in ("rclpy", "std_msgs", "ros_pose_stats_msgs", "rosbags"):
            asked.append(name)
            raise ImportError(name)
sys.meta_path.insert(0, NoRos())
from ros_pose_stats.tools import cli
for words in (["--version"], ["--help"], ["estimate", "-h"], ["node", "-h"]):
    try:
        cli.main(words)
    except SystemExit:
        pass
print("loaded: help", *sys.modules, flush=True)
part = [{str(parts / "box.stl")!r}, "--unit", "mm", "--json"]
for words in (["bag", {str(write_recorded(parts / "bag"))!r}, "--json"],
              ["estimate", *part], ["simulate", *part, "--drops", "20"]):
    if os.fork() == 0:
        status = cli.main(words)
        print("loaded:", words[0], *sys.modules, *asked, flush=True)
        os._exit(status)
    assert os.wait()[1] == 0
"""
    outcome = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT
    )
    assert (outcome.returncode, complaints(outcome.stderr)) == (0, [])
    loaded_modules = [
        line.split()
        for line in outcome.stdout.splitlines()
        if line.startswith("loaded: ")
    ]
    return {command: set(modules) for _, command, *modules in loaded_modules}


@pytest.mark.parametrize(
    ("command", "needed", "others"),
    [
        ("help", "ros_pose_stats.tools.cli", "numpy numba scipy trimesh rclpy mcap"),
        ("bag", "mcap", "numba matplotlib rclpy"),
        (
            "estimate",
            "numba",
            "trimesh networkx scipy.stats matplotlib mcap rclpy dask distributed "
            "http.server ros_pose_stats.tools.watching",
        ),
    ],
)
def test_a_command_needs_no_ros_and_loads_nothing_that_it_does_not_use(
    loaded, command, needed, others
):
    assert needed in loaded[command] and "ros_pose_stats_msgs" not in loaded[command]
    assert not set(others.split()) & loaded[command]


def test_a_reader_that_leaves_early_is_no_failure_to_report(parts):
    running = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "ros_pose_stats",
            "estimate",
            parts / "box.stl",
            "--method",
            "all",
            "--json",
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    running.stdout.close()
    with running.stderr:
        assert complaints(running.stderr.read()) == []
    assert running.wait() == 0


def test_what_cannot_be_written_is_a_failure_in_one_line(box, capsys):
    with Path("/dev/full").open("w") as full, contextlib.redirect_stdout(full):
        assert main([str(word) for word in ("estimate", *box)]) == 1
    (line,) = complaints(capsys.readouterr().err)
    assert "cannot write: No space left on device" in line


def test_a_part_of_any_name_is_printed_and_drawn(box, tmp_path):
    """Not UTF-8, an escape sequence, and what a picture would take for a formula."""
    name = "na\udcffme e\x1b[31mred\nline $\\foo$"
    part = shutil.copy(box[0], tmp_path / f"{name}.stl")
    page = tmp_path / "a.png"
    page.symlink_to(page)
    head, *_ = answer(
        "feeding",
        part,
        *box[1:],
        "--wanted",
        0,
        "--rate",
        60,
        "--plate",
        0.3,
        0.2,
        "--kicks",
        0.005,
        0.01,
        "--flips",
        9,
        "--png",
        page,
    ).splitlines()
    assert head.isprintable() and page.stat().st_size > 0
    lines = answer("compare", part, *box, "--drops", 200, "-o", tmp_path / "a.html")
    assert all(line.isprintable() for line in lines.splitlines())


def test_a_terminal_that_knows_few_letters_is_no_failure(box, tmp_path):
    part = shutil.copy(box[0], tmp_path / "Gehäuse.stl")
    with contextlib.redirect_stdout(
        io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    ) as stream:
        assert main(["estimate", str(part), "--unit", "mm"]) == 0
    assert (
        rb"Geh\xe4use" in stream.buffer.getvalue()
        and b"###" in stream.buffer.getvalue()
    )


@pytest.mark.parametrize(
    "closed", [contextlib.redirect_stdout, contextlib.redirect_stderr]
)
def test_a_closed_output_is_no_failure(box, closed):
    with closed(None):
        assert main([str(word) for word in ("estimate", *box)]) == 0


@pytest.mark.parametrize(
    ("words", "refusal_words"),
    [
        (["sensitivity", "--wanted", 0, "--checks", -1], "a number of checks from 0"),
        (
            [
                "feeding",
                "--wanted",
                0,
                "--rate",
                60,
                "--plate",
                0.3,
                0.2,
                "--kicks",
                "--counts",
                "flips.csv",
            ],
            "beside --counts",
        ),
        (["catalogue", "-o", ""], "name of a folder"),
        (["flips", "--kick", 0.001, "--flips", -5], "1 to"),
        (["animate", "--drop-height", 1e100, "-o", "a.gif"], "samples of a drop"),
        (["animate", "-o", "pipe.gif"], "no file"),
    ],
)
def test_what_would_be_ignored_or_never_end_is_refused(
    box, monkeypatch, tmp_path, words, refusal_words
):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.gif")
    (tmp_path / "flips.csv").write_text("kick,0,1,5\n")
    assert refusal_words in refusal(words[0], *box, *words[1:])


@pytest.mark.parametrize(
    "words", [["estimate", f"{300 * 'a'}.stl"], ["bag", 300 * "a"]]
)
def test_a_name_that_no_file_can_have_is_refused(words):
    assert "File name too long" in refusal(*words)


class TestNumbers:
    @pytest.mark.parametrize(
        ("text", "number"),
        [
            ("100", 100),
            ("1e2", 100),
            ("1.5E+2", 150),
            ("120.0", 120),
            (2**64 - 1, 2**64 - 1),
        ],
    )
    def test_a_count_may_be_in_scientific_notation_and_is_kept_to_its_last_digit(
        self, box, text, number
    ):
        values = answer_json("simulate", *box, "--drops", "1.2e1", "--seed", text)
        assert (values["drops"], values["seed"]) == (12, number)

    @pytest.mark.parametrize(
        "text", ["1.5", "nan", "-inf", "many", "", "0x10", "1,000", "1e5e5"]
    )
    def test_others_are_refused_with_what_was_expected_and_what_came(self, text):
        expected = "--drops: expected a whole number, for instance 100000 or 1e5"
        assert f"{expected}, got '{text}'" in refusal(
            "simulate", PART, f"--drops={text}"
        )

    @pytest.mark.parametrize("text", ["1e30", "1e999999999", "9" * 5000])
    def test_what_no_memory_would_hold_is_refused_in_a_short_line(self, text):
        line = refusal("simulate", PART, "--drops", text)
        assert "at most 30 digits" in line and len(line) < 250

    @pytest.mark.parametrize(
        ("option", "command"),
        [
            ("--seed", "animate"),
            ("--workers", "estimate"),
            ("--flips", "flips"),
            ("--checks", "sensitivity"),
            ("--drop", "animate"),
            ("--drops", "report"),
        ],
    )
    def test_every_count_is_read_alike(self, command, option):
        assert f"{option}: expected a whole number" in refusal(
            command, PART, option, "1.5"
        )

    def test_a_negative_number_is_no_option(self, box):
        poses = answer_json("estimate", *box, "--com", "-1e-3", "-2.5e-4", "0")["poses"]
        assert min(pose["height"] for pose in poses) == pytest.approx(9e-3, rel=1e-6)


class TestWanted:
    @pytest.mark.parametrize(
        "words",
        [
            ("0", "1", "3"),
            ("0,1,3",),
            ("0,1", "3"),
            ("0, 1, 3",),
            ("0-1", "3"),
            ("0-1,3",),
            ("0\N{EN DASH}1", "3-3"),
        ],
    )
    def test_commas_spaces_and_ranges(self, box, words):
        answer = answer_json("sensitivity", *box, "--checks", 0, "--wanted", *words)
        assert answer["wanted"] == [0, 1, 3]

    @pytest.mark.parametrize(
        "text", ["x", "0;1", "0,,1", "", "0,1.5", "nan", "0-", "0-1-2", "0--1"]
    )
    def test_rubbish_is_refused_with_what_was_expected_and_what_came(self, text):
        line = refusal("report", PART, "-o", "p.html", "--wanted", "0", text)
        expected = "indices of poses, for instance 0,1 or 0 1 or 0-3"
        assert f"--wanted: expected {expected}, got '{text}'" in line

    @pytest.mark.parametrize("text", ["3-0", "0-999999999999"])
    def test_a_range_falls_or_fills_the_memory(self, text):
        assert "a range rises and has at most 100000 poses" in refusal(
            "sensitivity", PART, "--wanted", text
        )


def test_version_is_that_of_the_package():
    assert call("--version").stdout == f"{ros_pose_stats.__version__}\n"
