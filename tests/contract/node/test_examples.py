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

"""The installed examples as a user runs them: processes beside a node, and their
decisions.
"""

import re
import signal
import sys
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import pytest
import rclpy
from geometry_msgs.msg import Point, Pose
from rclpy.task import Future
from ros_pose_stats_msgs.action import PlanFeeding
from ros_pose_stats_msgs.msg import Code
from std_msgs.msg import Header

from tests.running import ROOT, answer, call_copy, complaints

from .harness.cell import cell_of
from .harness.node import Running, parameters

EXECUTABLES = {script.name: script for script in entry_points(group="console_scripts")}
NO_VISION = pytest.mark.skipif(
    find_spec("vision_msgs") is not None, reason="it is installed"
)


@pytest.fixture(scope="module")
def part(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cad")
    answer("shapes", folder)
    return next(folder.glob("bracket.*"))


@pytest.mark.long
def test_the_node_learns_the_plate_while_the_planner_looks(domain, tmp_path, part):
    """Both are there before the node: the planner's mesh is latched."""
    arguments = "--ros-args", "-r", "__ns:=/shown", *parameters(file=part, unit="mm")
    with (
        Running(
            Path(sys.executable).with_name("example_planner"),
            *arguments,
            *parameters(wanted=[0, 2]),
        ) as planner,
        Running(
            sys.executable,
            ROOT / "lab/demo/camera.py",
            *arguments,
            *parameters(batch=20, period=0.05),
        ) as camera,
        cell_of(domain, tmp_path, "shown") as (node, client),
    ):
        planner.says("bracket: pick [0, 2]")
        with client.late_joiner() as joiner:
            learned = joiner.wait("bracket", lambda result: result.counted_parts >= 400)
        assert learned.method == "observed"
        look = planner.says("]: pick", "stderr")
        assert camera.end(signal.SIGINT) == (0, [])
        status, looks = planner.end(signal.SIGTERM)
        assert status == 0 and all(
            re.search(
                r"example_planner\]: pick \d+, (kick|empty the plate), drop \d+$", line
            )
            for line in (look, *looks)
        )
        node.assert_sound()


def test_the_planner_acts_on_the_code_of_a_refusal(domain, part, monkeypatch):
    module = sys.modules[EXECUTABLES["example_planner"].load().__module__]
    values = parameters(file=part, unit="mm", wanted=[0])
    rclpy.init(args=["--ros-args", "-r", "__ns:=/alone", *values])
    try:
        planner = module.ExamplePlanner()
        published = []
        monkeypatch.setattr(planner, "publish_mesh", lambda: published.append(part))

        def refuse(code):
            result = PlanFeeding.Result(success=False, code=code, message="refused")
            future = Future()
            future.set_result(SimpleNamespace(result=result))
            planner.decide(future)

        refuse(Code.BAD_VALUE)
        assert planner.retry.is_canceled() and not published
        refuse(Code.UNKNOWN_PART)
        assert planner.retry.is_canceled() and published == [part]
        refuse(Code.BUSY)
        assert not planner.retry.is_canceled() and published == [part]
        planner.destroy_node()
    finally:
        rclpy.try_shutdown()


def test_the_camera_hands_on_what_was_detected():
    """Messages that look like those of vision_msgs, which is no part of what is
    installed here.
    """

    def detection(*results):
        return SimpleNamespace(
            results=[
                SimpleNamespace(
                    hypothesis=SimpleNamespace(class_id=name, score=score),
                    pose=SimpleNamespace(pose=Pose(position=Point(x=score))),
                )
                for name, score in results
            ]
        )

    message = SimpleNamespace(
        header=Header(frame_id="plate"),
        detections=[
            detection(("nut", 0.2), ("bolt", 0.7)),
            detection(),
            detection(("bolt", 0.9)),
            detection(("nut", 0.6)),
        ],
    )
    module = sys.modules[EXECUTABLES["example_camera"].load().__module__]
    observed = {
        parts_of_picture.part_id: parts_of_picture
        for parts_of_picture in module.observed_parts(message)
    }
    assert {
        name: [pose.position.x for pose in parts_of_picture.poses]
        for name, parts_of_picture in observed.items()
    } == {"bolt": [0.7, 0.9], "nut": [0.6]}
    for parts_of_picture in observed.values():
        assert list(parts_of_picture.confidence) == [
            pose.position.x for pose in parts_of_picture.poses
        ]
        assert parts_of_picture.header.frame_id == "plate"


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("planner", {}, "file:="),
        ("planner", {"file": "missing.stl", "wanted": "[0]"}, "missing.stl"),
        ("planner", {"file": "{part}", "wanted": 0}, "INTEGER_ARRAY"),
        ("planner", {"file": "{part}", "wanted": "[0]"}, "-p unit:=mm, m, inch or cm"),
        ("planner", {"file": "[["}, "parse"),
        pytest.param(
            "camera", {}, "expected the package vision_msgs, got none", marks=NO_VISION
        ),
    ],
)
def test_bad_arguments_are_told_in_one_line(domain, part, name, values, words):
    values = {key: str(value).format(part=part) for key, value in values.items()}
    executable = EXECUTABLES[f"example_{name}"].value
    outcome = call_copy(executable, "--ros-args", *parameters(**values))
    # What cannot be parsed, rcl has complained of already.
    [line] = [line for line in complaints(outcome.stderr) if "[rcl]: " not in line]
    assert (
        outcome.returncode == 2
        and line.startswith(f"example_{name}: ")
        and words in line
    )
