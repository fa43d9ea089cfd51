"""The command as a user runs it: in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import ros_pose_stats

ROOT = Path(ros_pose_stats.__file__).resolve().parents[1]


def command(*arguments):
    """Run `python -m ros_pose_stats`, from the repository root."""
    return subprocess.run([sys.executable, "-m", "ros_pose_stats", *map(str, arguments)],
                          capture_output=True, text=True, cwd=ROOT)


def complaints(error):
    """What standard error holds besides the word that kernels are being compiled."""
    return [line for line in error.splitlines() if "compiling kernels" not in line]


def answer(*arguments):
    """Standard output of a command that must succeed without a complaint."""
    done = command(*arguments)
    assert done.returncode == 0, done.stderr
    assert complaints(done.stderr) == []
    return done.stdout


def strict_json(text):
    """Parse JSON as the standard has it: neither NaN nor infinity."""
    def refuse(name):
        raise AssertionError(f"{name} is not JSON")

    return json.loads(text, parse_constant=refuse)
