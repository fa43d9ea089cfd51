"""The command line as a whole: version, help, exit statuses."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import ros_pose_stats
from ros_pose_stats import cli
from ros_pose_stats.commands import estimate
from tests.running import answer, command


def test_version():
    assert answer("--version") == f"{ros_pose_stats.__version__}\n"


def test_the_console_script_is_the_same_command():
    script = shutil.which("ros_pose_stats", path=Path(sys.executable).parent)
    if script is None:
        pytest.skip("the package is not installed beside this interpreter")
    done = subprocess.run([script, "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"{ros_pose_stats.__version__}\n")


@pytest.mark.parametrize("arguments", [["--help"], ["estimate", "--help"], ["shapes", "--help"]])
def test_help(arguments, capsys):
    with pytest.raises(SystemExit) as exit_:
        cli.main(arguments)
    assert exit_.value.code == 0
    assert capsys.readouterr().out.startswith("usage: ros_pose_stats")


@pytest.mark.parametrize("arguments", [[], ["frobnicate"], ["--colour"]])
def test_what_is_no_command_is_refused_in_one_line(arguments):
    done = command(*arguments)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "ros_pose_stats --help" in done.stderr


class TestExitStatus:
    @staticmethod
    def failing(monkeypatch, error):
        def run(options):
            raise error

        monkeypatch.setattr(estimate, "run", run)
        return cli.main(["estimate", "part.stl"])

    def test_interrupted(self, monkeypatch, capsys):
        assert self.failing(monkeypatch, KeyboardInterrupt()) == 130
        assert capsys.readouterr().err.count("\n") == 1

    def test_internal_failure_shows_where(self, monkeypatch, capsys):
        assert self.failing(monkeypatch, ZeroDivisionError("of the author's making")) == 1
        assert "of the author's making" in capsys.readouterr().err

    def test_refused(self, monkeypatch, capsys):
        refusal = ros_pose_stats.PoseStatsError("this", "that", "do so")
        assert self.failing(monkeypatch, refusal) == 2
        assert capsys.readouterr().err == "ros_pose_stats: expected this, got that; do so\n"


def test_version_and_helps_are_printed_without_loading_the_core():
    code = ("import sys; from ros_pose_stats import cli\n"
            "for words in (['--version'], ['--help'], ['estimate', '-h'], ['node', '-h']):\n"
            "    try:\n        cli.main(words)\n"
            "    except SystemExit:\n        pass\n"
            "print([name for name in ('numpy', 'numba', 'scipy', 'trimesh', 'rclpy')\n"
            "       if name in sys.modules])")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                          cwd=Path(ros_pose_stats.__file__).parents[1])
    assert done.stdout.splitlines()[-1] == "[]"
