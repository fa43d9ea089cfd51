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

"""The end of the demo: a planner, and a camera over an unexpected plate."""

import subprocess
from pathlib import Path
from typing import Any

from lab.frame.documents import markdown_table, points

from .cell import DEMO, Listener, process, wait_for

PART = DEMO / "bracket.stl"
PARTS_SEEN = 1000  # by the camera until the demo ends

PLATE = {"restitution": 0.1, "drop_height": 0.04}
"""A low chute onto a dull plate; the node supposes 0.5 and 20 radii."""

FEEDER = {"rate": 60.0, "wanted": [0, 1], "cycle_time": 0.8}
TRUE_DROPS = 10_000


def learn_plate(listener: Listener, node: subprocess.Popen[bytes]) -> Path:
    """Run a planner and a camera until the node has learned; a picture of that."""
    with (
        process(
            "ros_pose_stats.node.examples.planner",
            *parameters(file=PART, unit="mm", **FEEDER),
        ) as planner,
        process(
            "lab.demo.camera",
            *parameters(file=PART, unit="mm", batch=10, period=0.05, **PLATE),
        ) as camera,
    ):
        wait_for(
            "result from what the camera saw",
            lambda: any(
                result.counted_parts >= PARTS_SEEN
                for result in listener.results(PART.stem)
            ),
            node,
            planner,
            camera,
        )
    from ros_pose_stats import load_part, simulate
    from ros_pose_stats.node.messages.statistics_messages import statistics_of_message

    from .figure import learning_figure

    results = [
        statistics_of_message(message) for message in listener.results(PART.stem)
    ]
    truth = simulate(load_part(PART, unit="mm"), TRUE_DROPS, seed=1, **PLATE)
    predicted = {pose.index: pose.probability for pose in results[0].poses}
    true = {pose.index: pose.probability for pose in truth.poses}
    head = ("pose", "predicted %", "calibrated", "90 %", "true %")
    rows = [
        (
            f"{pose.index}",
            points(predicted[pose.index]),
            points(pose.probability),
            interval(pose),
            points(true[pose.index]),
        )
        for pose in results[-1].poses
    ]
    print(f"\n{markdown_table(head, rows)}")
    file = DEMO / f"{PART.stem}_learned.png"
    learning_figure(results, truth).savefig(file, dpi=110)
    return file


def interval(pose: Any, digits: int = 1) -> str:
    """The 90 % interval of a pose in percent."""
    low, high = pose.probability_low, pose.probability_high
    return f"{points(low, digits)} - {points(high, digits)}"


def parameters(**values: object) -> list[str]:
    """ROS arguments that set parameters."""
    arguments = ["--ros-args"]
    for name, value in values.items():
        arguments += ["-p", f"{name}:={value}"]
    return arguments
