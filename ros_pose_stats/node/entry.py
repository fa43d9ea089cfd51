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

"""The executable `pose_stats_node`, and what every program with ROS begins with."""

import sys
import traceback
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

from ..base.errors import PoseStatsError, RequestError
from ..base.extras import failed_import, keep_algebra_to_one_thread
from .participant import finish

INTERFACES = "ros_pose_stats_msgs"
REFUSED = 2
FAILED = 1


def main() -> int:
    """The executable `pose_stats_node`."""
    try:
        status = start_node(sys.argv[1:])
    except PoseStatsError as refusal:
        print(f"pose_stats_node: {refusal}", file=sys.stderr)
        status = REFUSED
    except Exception as error:
        refusal_of_import = None
        if isinstance(error, ImportError):
            refusal_of_import = failed_import(error)
        if refusal_of_import is None:
            traceback.print_exc()
            status = FAILED
        else:
            print(f"pose_stats_node: {refusal_of_import}", file=sys.stderr)
            status = REFUSED
    return finish(status)


def start_node(words: list[str]) -> int:
    """Run the node until SIGINT or SIGTERM; `words`: `--ros-args` and what follows."""
    arguments = ros_arguments("pose_stats_node", words)
    prepare_ros()
    from .stop_signals import StopSignals

    # Signals are taken before ROS, which takes a while, is imported.
    stop_signals = StopSignals()
    from .node import run_node

    return run_node(stop_signals, arguments)


def ros_arguments(program: str, words: list[str]) -> list[str]:
    """Arguments for rclpy; RequestError where `words` begin without `--ros-args`."""
    for option, file in pairwise(words):
        if option == "--params-file" and not Path(file).is_file():
            raise RequestError(
                "a file after --params-file",
                f"'{file}', which is none",
                "check the path",
            )
    if words and words[0] != "--ros-args":
        raise RequestError(
            "ROS arguments after --ros-args",
            " ".join(words),
            "for instance --ros-args -p log_directory:=/tmp/bags",
        )
    return [program, *words]


def prepare_ros() -> None:
    """Refuse to go on without ROS; keep linear algebra off the cores that simulate."""
    if find_spec("rclpy") is None:
        raise RequestError(
            "ROS 2 Jazzy to be importable",
            "no module rclpy",
            "source /opt/ros/jazzy/setup.bash, or run `make setup` and use .venv",
        )
    if find_spec(INTERFACES) is None:
        raise RequestError(
            f"the interface package {INTERFACES}",
            "none",
            "build it: `make setup`, or a workspace as docs/workspace.md says",
        )
    keep_algebra_to_one_thread()
