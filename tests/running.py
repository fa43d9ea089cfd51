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

"""The command: in this process, as `cli.main` runs it, or in one of its own.

Commands that speak ROS run in a copy of a process that has loaded all (`copies`).
"""

import contextlib
import io
import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

import ros_pose_stats
from ros_pose_stats import PoseStatsError
from ros_pose_stats.tools import cli

from .copies import copies

ROOT = Path(ros_pose_stats.__file__).resolve().parents[1]

SPEAKS_ROS = {("node",), ("publish",), ("show",)}

STATISTICS_KEYS = {
    "choice",
    "counted_parts",
    "model_gap",
    "numbering",
    "units",
    "part_id",
    "part_digest",
    "radius",
    "bodies",
    "unit",
    "unit_guessed",
    "method",
    "restitution",
    "drop_height",
    "cluster_tolerance",
    "round_sides",
    "drops",
    "unsettled",
    "seed",
    "expected_error",
    "largest_error",
    "scene",
    "plate_error",
    "seconds",
    "version",
    "warnings",
    "poses",
}
POSE_KEYS = {
    "alike_from_above",
    "index",
    "group",
    "down",
    "height",
    "top",
    "margin",
    "barrier",
    "spread",
    "probability",
    "probability_low",
    "probability_high",
    "standard_error",
    "count",
    "orientation",
    "members",
    "group_size",
    "group_probability",
    "rolls",
    "roll_axis",
    "yaw_symmetry",
    "position",
}


class Done(NamedTuple):
    """How a command ended; `returncode`, `stdout` and `stderr` as of a process."""

    returncode: int
    stdout: str
    stderr: str


def call(*arguments, program=cli.main):
    """Run a command, or another program that takes its arguments.

    One that makes a participant of DDS is run in a process of its own.
    """
    if program is cli.main and arguments[:1] in SPEAKS_ROS:
        return call_copy("ros_pose_stats.tools.cli:main", *arguments)
    return call_here(*arguments, program=program)


def call_copy(executable, *arguments):
    """Run a program, as `module:function`, in a process of its own."""
    return Done(*copies().run(executable, [str(argument) for argument in arguments]))


def call_here(*arguments, program=cli.main):
    """Run a program in this process; signals that it takes over are given back."""
    printed = io.StringIO()
    err = io.StringIO()
    handlers = {
        number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)
    }
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(err):
        try:
            status = program([str(argument) for argument in arguments])
        except SystemExit as end:  # of the parser
            status = end.code if isinstance(end.code, int) else 1
        finally:
            for number, handler in handlers.items():
                if signal.getsignal(number) is not handler:
                    signal.signal(number, handler)
    return Done(status or 0, printed.getvalue(), err.getvalue())


def answer(*arguments):
    """Standard output of a command that must succeed without a complaint."""
    outcome = call(*arguments)
    assert outcome.returncode == 0, outcome.stderr
    assert complaints(outcome.stderr) == []
    return outcome.stdout


def answer_json(*arguments):
    """What a command prints with `--json`: an object, or a list of them, with all their
    keys.
    """
    values = strict_json(answer(*arguments, "--json"))
    objects = values if isinstance(values, list) else [values]
    assert all("units" in entry for entry in objects)
    if arguments[0] in ("estimate", "simulate"):
        assert all(entry.keys() == STATISTICS_KEYS for entry in objects)
        assert all(
            pose.keys() == POSE_KEYS for entry in objects for pose in entry["poses"]
        )
    return values


def refusal(*arguments, call=call):
    """The one line on standard error of a command that must be refused."""
    outcome = call(*arguments)
    assert outcome.returncode == 2, outcome
    assert outcome.stdout == ""
    lines = complaints(outcome.stderr)
    assert lines, "refused without a word"
    return lines[-1]


def refusal_of(call, *arguments, **options):
    """The one line with which the library refuses a call."""
    with pytest.raises(PoseStatsError, match=r"^expected .*, got .*; .+$") as caught:
        call(*arguments, **options)
    line = str(caught.value)
    assert len(line.splitlines()) == 1 and len(line) < 700
    return line


def command(*arguments):
    """Run `python -m ros_pose_stats` in a process of its own, from the repository
    root.
    """
    return subprocess.run(
        [sys.executable, "-m", "ros_pose_stats", *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )


def about(process, file):
    """What Linux says about a process or one of its threads; nothing once it is
    gone.
    """
    try:
        return Path(f"/proc/{process}/{file}").read_text(errors="replace")
    except (FileNotFoundError, ProcessLookupError, PermissionError):
        return ""


def children(process):
    """Ids of the processes that one has started."""
    return [
        int(child)
        for task in Path(f"/proc/{process}/task").glob("*")
        for child in about(process, f"task/{task.name}/children").split()
    ]


def is_gone(process):
    """Whether a process has ended, though its parent may not have heard of it."""
    status = about(process, "stat")
    return not status or ") Z" in status


def complaints(error):
    """What standard error holds besides the word that kernels are being compiled."""
    return [line for line in error.splitlines() if "compiling kernels" not in line]


def strict_json(text):
    """Parse JSON as the standard has it: neither NaN nor infinity."""

    def refuse(name):
        raise AssertionError(f"{name} is not JSON")

    return json.loads(text, parse_constant=refuse)
