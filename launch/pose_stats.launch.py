"""Starts the node with the parameters of config/pose_stats.yaml, or of another file."""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Arguments `namespace` and `params_file`."""
    default_file = PathJoinSubstitution(
        [FindPackageShare("ros_pose_stats"), "config", "pose_stats.yaml"])
    return LaunchDescription([
        DeclareLaunchArgument("namespace", default_value="", description="of the node"),
        DeclareLaunchArgument("params_file", default_value=default_file,
                              description="YAML file with the node's parameters"),
        Node(package="ros_pose_stats", executable="pose_stats_node", name="pose_stats",
             namespace=LaunchConfiguration("namespace"),
             parameters=[LaunchConfiguration("params_file")], output="screen"),
    ])
