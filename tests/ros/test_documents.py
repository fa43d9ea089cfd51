"""What README and docs/node.md tell a reader to type does what they say."""

import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType, SimpleNamespace
from unittest import mock

import pytest
from geometry_msgs.msg import Point, Pose
from std_msgs.msg import Header

from tests.test_docs import README, ROOT, lines_of

from .harness.cell import latched
from .harness.client import Client
from .harness.node import PATIENCE

PAGE = (ROOT / "docs/node.md").read_text(encoding="utf-8")


def python_blocks() -> list[str]:
    return re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    directory = tmp_path_factory.mktemp("cell")
    subprocess.run([sys.executable, "-m", "ros_pose_stats", "shapes", "demo"], cwd=directory,
                   check=True, stdout=subprocess.DEVNULL)
    return directory


@pytest.fixture(scope="module")
def apart(other_domain):
    """The environment of a domain without the shared node, which has the same name."""
    return {**os.environ, "ROS_DOMAIN_ID": str(other_domain)}


@pytest.fixture(scope="module")
def running(apart, home):
    """The lines of the README that go on until Ctrl-C, running."""
    children = [subprocess.Popen([sys.executable, "-m", *shlex.split(line)], cwd=home, env=apart,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                for line in lines_of(README, "node", "publish")]
    yield children
    for child in children:
        if child.poll() is None:
            child.send_signal(signal.SIGINT)
        said = child.communicate(timeout=PATIENCE)[1]
        assert child.returncode == 0, said
        assert "Traceback" not in said


@pytest.fixture(scope="module")
def answered(running, other_domain):
    """Those lines, once their part has its answer."""
    with Client(other_domain) as client:
        latched(client, "clamp")


def run(home: Path, *command: str,
        environment: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=home, capture_output=True, text=True, check=False,
                          timeout=PATIENCE, env=environment)


def test_the_readme_shows_the_three_commands():
    lines = lines_of(README, "node", "publish", "bag")
    assert [line.split()[1] for line in lines] == ["node", "publish", "bag"]


def test_bag_line_of_the_readme_shows_the_published_part(answered, home):
    (line,) = lines_of(README, "bag")
    until = time.monotonic() + PATIENCE
    done = run(home, sys.executable, "-m", *shlex.split(line))
    while "clamp" not in done.stdout and time.monotonic() < until:
        time.sleep(1.0)
        done = run(home, sys.executable, "-m", *shlex.split(line))
    assert done.returncode == 0, done.stderr
    assert "clamp" in done.stdout and "split" in done.stdout


def test_camera_of_the_page_makes_parts_seen_of_detections():
    """Without vision_msgs, which is no part of what is installed here."""
    (code,) = (block for block in python_blocks() if "vision_msgs" in block)
    names = {"__name__": "camera"}
    stand_ins = {"vision_msgs": ModuleType("vision_msgs"),
                 "vision_msgs.msg": SimpleNamespace(Detection3DArray=None)}
    with mock.patch.dict(sys.modules, stand_ins):
        exec(code, names)

    def detection(*results):
        return SimpleNamespace(results=[SimpleNamespace(
            hypothesis=SimpleNamespace(class_id=name, score=score),
            pose=SimpleNamespace(pose=Pose(position=Point(x=score)))) for name, score in results])

    message = SimpleNamespace(header=Header(frame_id="plate"), detections=[
        detection(("nut", 0.2), ("bolt", 0.7)), detection(), detection(("bolt", 0.9)),
        detection(("nut", 0.6))])
    found = {seen.part_id: seen for seen in names["observed_parts"](message)}
    assert {name: [pose.position.x for pose in seen.poses] for name, seen in found.items()} == {
        "bolt": [0.7, 0.9], "nut": [0.6]}
    for seen in found.values():
        assert list(seen.confidence) == [pose.position.x for pose in seen.poses]
        assert seen.header.frame_id == "plate"


@pytest.mark.parametrize("code", [block for block in python_blocks()
                                  if "vision_msgs" not in block])
def test_planner_of_the_page_runs(code, answered, home, apart):
    done = run(home, sys.executable, "-c", code, environment=apart)
    assert done.returncode == 0, done.stderr
    assert "clamp/0" in done.stdout and "expected error" in done.stdout
