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

"""`completion`: what bash offers on Tab, asked of bash itself."""

import shlex
import shutil
import subprocess

import pytest

from tests.running import answer, refusal

BASH = shutil.which("bash")
TYPED = {
    "commands": ("",),
    "a command begun": ("estim",),
    "options": ("estimate", "--"),
    "a choice": ("estimate", "part.stl", "--unit", "in"),
    "a shell": ("completion", "z"),
    "a file": ("estimate", "cad/g"),
    "options begun": ("simulate", "--dr"),
    "a file begun with a space": ("estimate", r"cad/big\ g"),
    "a page": ("report", "part.stl", "-o", "cad/g"),
    "behind --ros-args": ("node", "--ros-args", "--par"),
    "a file for ROS": ("node", "--ros-args", "--params-file", "cad/g"),
    "where ROS is named": ("publish", "part.stl", "--ro"),
}


@pytest.fixture(scope="module")
def offered(tmp_path_factory):
    """By what was typed: all that bash offers for the last word."""
    if BASH is None:
        pytest.skip("there is no bash")
    folder = tmp_path_factory.mktemp("completion")
    (folder / "cad").mkdir()
    (folder / "cad" / "gear.stl").touch()
    (folder / "cad" / "big gear.stl").touch()
    (folder / "tab.bash").write_text(answer("completion", "bash"))
    lines = [
        "source ./tab.bash",
        "program=$(complete -p ros_pose_stats)",
        "program=${program#*-F }; program=${program%% *}",
    ]
    for words in TYPED.values():
        lines += [
            f"COMP_WORDS=(ros_pose_stats {' '.join(map(shlex.quote, words))})",
            f"COMP_CWORD={len(words)}; COMPREPLY=()",
            f"$program ros_pose_stats {shlex.quote(words[-1])} {shlex.quote(words[0])}",
            "printf '%s ' \"${COMPREPLY[@]}\"; echo",
        ]
    outcome = subprocess.run(
        [BASH, "--norc", "-c", "\n".join(lines)],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert outcome.returncode == 0, outcome.stderr
    return dict(
        zip(TYPED, (line.split() for line in outcome.stdout.splitlines()), strict=True)
    )


def test_commands(offered):
    assert {"estimate", "simulate", "catalogue", "bag", "node"} <= set(
        offered["commands"]
    )
    assert offered["a command begun"] == ["estimate"]


def test_options_of_the_command(offered):
    assert {"--unit", "--method", "--json"} <= set(offered["options"])
    assert set(offered["options begun"]) == {"--drops", "--drop-height"}


def test_values_and_files(offered):
    assert offered["a choice"] == ["inch"] and offered["a shell"] == ["zsh"]
    assert offered["a file"] == ["cad/gear.stl"]


def test_arguments_for_ros(offered):
    assert offered["where ROS is named"] == ["--ros-args"]
    assert offered["behind --ros-args"] == ["--params-file"]
    assert offered["a file for ROS"] == ["cad/gear.stl"]


def test_zsh_has_a_script_too_and_other_shells_none():
    assert "ros_pose_stats" in answer("completion", "zsh")
    assert "bash" in refusal("completion", "fish")
