"""Starts the node with the parameters of a file, and RViz.

The file is config/pose_stats.yaml where no other one is named.
"""

from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import (
    LaunchConfiguration,
    PathJoinSubstitution,
    PythonExpression,
)
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

CONFIG = PathJoinSubstitution([FindPackageShare("ros_pose_stats"), "config"])
ARGUMENTS = {
    "namespace": ("", "of the node, and of the topic that RViz shows"),
    "params_file": (
        PathJoinSubstitution([CONFIG, "pose_stats.yaml"]),
        "YAML file with the node's parameters",
    ),
    "log_level": ("info", "of the node: debug, info, warn or error"),
    "use_sim_time": ("false", "whether stamps are those of /clock"),
    "rviz": ("false", "whether to start RViz, too"),
    "respawn": ("false", "whether to start the node again when it ends"),
}


def generate_launch_description() -> LaunchDescription:
    """The node, and RViz where it is asked for; `ARGUMENTS` says with what."""
    given = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=value, description=about)
                for name, (value, about) in ARGUMENTS.items()
            ),
            Node(
                package="ros_pose_stats",
                executable="pose_stats_node",
                name="pose_stats",
                namespace=given["namespace"],
                respawn=given["respawn"],
                respawn_delay=2.0,
                parameters=[
                    given["params_file"],
                    {"use_sim_time": given["use_sim_time"]},
                ],
                ros_arguments=["--log-level", given["log_level"]],
                output="screen",
            ),
            Node(
                package="rviz2",
                executable="rviz2",
                condition=IfCondition(given["rviz"]),
                arguments=["-d", PathJoinSubstitution([CONFIG, "pose_stats.rviz"])],
                remappings=[
                    (
                        "/pose_stats/markers",
                        PythonExpression(
                            [
                                "('/' + '",
                                given["namespace"],
                                "' + '/pose_stats/markers').replace('//', '/')",
                            ]
                        ),
                    )
                ],
            ),
        ]
    )
