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

"""Starts the node with the parameters of a file, and RViz where it is asked for.

The file is config/pose_stats.yaml where no other one is named. What would go wrong
later is refused before anything is started: a process that has been started outlives
a launch that fails.
"""

from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    OpaqueFunction,
    RegisterEventHandler,
)
from launch.event_handlers import OnProcessExit
from launch.events import matches_action
from launch.events.process import ShutdownProcess
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare
from launch_ros.utilities import make_namespace_absolute, prefix_namespace

from launch import LaunchContext, LaunchDescription

NAME = "pose_stats"
REFUSED = 2
"""Status of a node whose parameters are refused; starting it again does not help."""

CONFIG = PathJoinSubstitution([FindPackageShare("ros_pose_stats"), "config"])
LEVELS = ["debug", "info", "warn", "error", "fatal"]
BOOLEANS = ["true", "false", "True", "False"]
ARGUMENTS = {
    "namespace": ("", "of the node, and of the topic that RViz shows", None),
    "params_file": (
        PathJoinSubstitution([CONFIG, "pose_stats.yaml"]),
        "YAML file with the node's parameters",
        None,
    ),
    "log_level": ("info", "of the node's own lines", LEVELS),
    "use_sim_time": ("false", "whether stamps are those of /clock", BOOLEANS),
    "rviz": ("false", "whether to start RViz, too", BOOLEANS),
    "respawn": (
        "false",
        "whether to start the node again when it ends, but not where it refuses its "
        "parameters",
        BOOLEANS,
    ),
    "respawn_max_retries": (
        "-1",
        "how many times the node is started again at most; -1: always",
        None,
    ),
}


def generate_launch_description() -> LaunchDescription:
    """The arguments, and what is started with their values."""
    declarations = [
        DeclareLaunchArgument(
            name, default_value=default, description=about, choices=choices
        )
        for name, (default, about, choices) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declarations, OpaqueFunction(function=start)])


def start(context: LaunchContext) -> list:
    """The node and RViz; a RuntimeError where an argument cannot be used."""
    values = {
        name: LaunchConfiguration(name).perform(context).strip() for name in ARGUMENTS
    }
    is_set = {name: value.lower() == "true" for name, value in values.items()}
    check_file(values["params_file"])
    retries = read_count(values["respawn_max_retries"])
    if is_set["rviz"]:
        check_rviz()
    # Of those who include this file as well, who may have pushed a namespace.
    pushed = context.launch_configurations.get("ros_namespace")
    namespace = make_namespace_absolute(
        prefix_namespace(pushed, values["namespace"] or None) or "/"
    )
    full_name = f"{namespace.rstrip('/')}/{NAME}"
    node = Node(
        package="ros_pose_stats",
        executable="pose_stats_node",
        name=NAME,
        namespace=namespace,
        respawn=is_set["respawn"],
        respawn_delay=2.0,
        respawn_max_retries=retries,
        parameters=[
            values["params_file"],
            {"use_sim_time": is_set["use_sim_time"]},
        ],
        # Of the node's logger alone: rcl and DDS have hundreds of lines at `debug`.
        ros_arguments=[
            "--log-level",
            f"{full_name[1:].replace('/', '.')}:={values['log_level']}",
        ],
        output="screen",
    )
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", PathJoinSubstitution([CONFIG, "pose_stats.rviz"])],
        remappings=[(f"/{NAME}/markers", f"{full_name}/markers")],
    )
    return [
        RegisterEventHandler(
            OnProcessExit(target_action=node, on_exit=end_where_refused)
        ),
        node,
        *([rviz] if is_set["rviz"] else []),
    ]


def end_where_refused(event, context: LaunchContext) -> list:
    """Have a node that has refused its parameters not be started again."""
    if event.returncode != REFUSED:
        return []
    process = matches_action(event.action)
    return [EmitEvent(event=ShutdownProcess(process_matcher=process))]


def check_file(file: str) -> None:
    """Refuse a file of parameters that is none; launch_ros would go on without."""
    if not Path(file).is_file():
        raise RuntimeError(
            f"expected params_file to be a YAML file, got '{file}', which is none; "
            "check the path"
        )


def read_count(text: str) -> int:
    """A number of times."""
    try:
        return int(text)
    except ValueError:
        raise RuntimeError(
            "expected respawn_max_retries to be a whole number, got "
            f"'{text}'; for instance 5, or -1 for always"
        ) from None


def check_rviz() -> None:
    """Refuse rviz:=true where there is no RViz."""
    try:
        get_package_prefix("rviz2")
    except PackageNotFoundError:
        raise RuntimeError(
            "expected the package rviz2 for rviz:=true, got none; install it with "
            "`sudo apt install ros-jazzy-rviz2`, or leave rviz:=true out"
        ) from None
