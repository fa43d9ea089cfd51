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

"""A camera for the node: a detector's `Detection3DArray` becomes `ObservedParts`.

ros2 run ros_pose_stats example_camera --ros-args -r detections:=/my_detector/detections
"""

import sys
from contextlib import suppress
from importlib import import_module
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from ros_pose_stats_msgs.msg import ObservedParts


class ExampleCamera(Node):
    """Takes each part that has just landed once, in the frame of the plate."""

    def __init__(self, detections: Any) -> None:
        super().__init__("example_camera")
        self.publisher = self.create_publisher(
            ObservedParts, "pose_stats/observed_parts", 10
        )
        self.create_subscription(detections, "detections", self.on_detections, 10)

    def on_detections(self, message: Any) -> None:
        """Publish what was detected."""
        for parts in observed_parts(message):
            self.publisher.publish(parts)


def observed_parts(message: Any) -> list[ObservedParts]:
    """An ObservedParts for each kind of part; the likeliest class_id is the part_id."""
    by_part: dict[str, ObservedParts] = {}
    for detection in message.detections:
        if not detection.results:
            continue
        best = max(detection.results, key=lambda result: result.hypothesis.score)
        part_id = best.hypothesis.class_id
        parts = by_part.setdefault(
            part_id, ObservedParts(header=message.header, part_id=part_id)
        )
        parts.poses.append(best.pose.pose)
        parts.confidence.append(best.hypothesis.score)
    return list(by_part.values())


def main() -> int:
    """Hand on until Ctrl-C."""
    try:
        detections = import_module("vision_msgs.msg").Detection3DArray
    except ImportError:
        print(
            "example_camera: expected the package vision_msgs, got none; install it: "
            "apt install ros-jazzy-vision-msgs",
            file=sys.stderr,
        )
        return 2
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(ExampleCamera(detections))
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
