"""What the node does with parameters and surroundings in which it cannot run."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from tests.volume import few_quick

from .harness.node import NodeProcess

START = [sys.executable, "-m", "ros_pose_stats", "node"]


def complaint(arguments, **environment):
    """The one line of a start that is refused."""
    done = subprocess.run(START + arguments, capture_output=True, text=True, timeout=240,
                          env={**os.environ, **environment})
    assert done.returncode == 2, (done.returncode, done.stderr)
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    return lines[0]


@pytest.fixture
def bags(domain, tmp_path):
    return tmp_path / "bags"


class TestRefusedParameters:
    @pytest.mark.parametrize("case", few_quick([
        ("restitution:=2.5", ("restitution", "2.5", "below 1")),
        ("log_directory:=7", ("log_directory", "7", "string")),
        ("mesh_topics:=[/a/clamp, /b/clamp]", ("'clamp'", "/a/clamp", "/b/clamp")),
        ("restitution:=.nan", ("restitution", "nan")),
        ("restitution:=high", ("restitution", "'high'", "double")),
        ("max_parts:=2.5", ("max_parts", "2.5", "integer")),
        ("default_method:=guess", ("default_method", "'guess'", "combined")),
        ("log_directory:=~nobody_of_this_name/bags", ("log_directory", "nobody")),
        ("mesh_topics:=[1, 2]", ("mesh_topics", "string_array")),
        ("mesh_topics:=['bad topic']", ("mesh_topics", "bad topic")),
    ], 3))
    def test_one_line_says_why(self, bags, case):
        given, said = case
        arguments = [] if given.startswith("log_directory") else ["-p", f"log_directory:={bags}"]
        line = complaint(["--ros-args", *arguments, "-p", given])
        assert all(word in line for word in said), line

    def test_arguments_that_ros_cannot_read(self, domain):
        done = subprocess.run([*START, "--ros-args", "-p", "nonsense"], capture_output=True,
                              text=True)
        *others, last = done.stderr.strip().splitlines()
        assert done.returncode == 2 and "nonsense" in last
        assert all("[rcl]" in line for line in others)  # it has logged it, too

    def test_arguments_that_are_no_ros_arguments(self, domain):
        done = subprocess.run([*START, "--fast"], capture_output=True, text=True)
        assert done.returncode == 2 and "Traceback" not in done.stderr


class TestTakenParameters:
    @pytest.mark.parametrize("given", [
        {"restitution": 0, "max_job_seconds": 5, "drop_height": 1, "mesh_unit": 1,
         "cluster_tolerance": 0, "target_error": 0, "mesh_topics": "[]"},
        {"mesh_topics": "[/cad/clamp, other=/cad/clamp2, '~/mine']", "workers": 1,
         "plate": "brass", "default_method": "area", "max_drops": 100},
    ])
    def test_start(self, domain, tmp_path, given):
        with NodeProcess(tmp_path, **given) as node:
            node.ready()


START_SCRIPT = """
from ros_pose_stats.cli import main
sys.exit(main())
"""
BLOCKER_OF = {name: f"""
import importlib.util
import sys

find_spec = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: (
    None if name.partition(".")[0] == {name!r} else find_spec(name, *rest))


class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == {name!r}:
            raise ModuleNotFoundError(name)


sys.meta_path.insert(0, Blocker())
""" for name in ("rclpy", "ros_pose_stats_msgs")}


class TestBareSurroundings:
    @pytest.mark.parametrize(("missing", "advice"), [
        ("rclpy", "source /opt/ros/jazzy/setup.bash"),
        ("ros_pose_stats_msgs", "colcon build --base-paths . msg_defs")])
    def test_without(self, tmp_path, missing, advice):
        script = tmp_path / "start.py"
        script.write_text(BLOCKER_OF[missing] + START_SCRIPT)
        done = subprocess.run([sys.executable, str(script), "node"], capture_output=True,
                              text=True)
        assert done.returncode == 2, done.stderr
        (line,) = done.stderr.strip().splitlines()
        assert missing in line and advice in line and "make setup" in line
