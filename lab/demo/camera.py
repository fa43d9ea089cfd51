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

"""A simulated camera over a plate that is not as the node supposes.

python -m lab.demo.camera --ros-args -p file:=clamp.stl -p unit:=mm
"""

import sys
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import Pose, Quaternion
from numpy.typing import ArrayLike
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_pose_stats_msgs.msg import ObservedParts, PoseStatistics

from ros_pose_stats import load_part, simulate
from ros_pose_stats.core.records import Array

LATCHED = QoSProfile(
    depth=256,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


class SimulatedCamera(Node):
    """Drops parts and publishes how it sees them lie; a real one only sees them."""

    def __init__(self) -> None:
        super().__init__("simulated_camera")
        file = self.declare_parameter("file", "").value
        unit = self.declare_parameter("unit", "").value
        self.restitution = self.declare_parameter("restitution", 0.1).value
        # of the centre of mass, metres
        self.drop_height = self.declare_parameter("drop_height", 0.04).value
        # standard deviation of the measured tilt, radians
        self.tilt = self.declare_parameter("tilt", 0.05).value
        # share of the parts that are taken to lie in another pose
        self.misread = self.declare_parameter("misread", 0.02).value
        self.batch = self.declare_parameter("batch", 10).value  # parts a picture
        self.seed = self.declare_parameter("seed", 1).value
        # from picture to picture, seconds
        period = self.declare_parameter("period", 0.5).value
        if not file:
            raise ValueError("no mesh of a part, give it as -p file:=clamp.stl")
        if not (0.0 <= self.misread <= 1.0 and self.tilt >= 0.0 and period > 0.0):
            raise ValueError(
                "expected misread from 0 to 1, tilt from 0 up and a period above 0, "
                f"got {self.misread}, {self.tilt} and {period}"
            )
        self.part = load_part(file, unit=unit or None)
        self.random = np.random.default_rng(self.seed)
        self.drop_parts()  # refuses what cannot be dropped
        self.is_known = False
        self.publisher = self.create_publisher(
            ObservedParts, "pose_stats/observed_parts", 100
        )
        self.create_subscription(
            PoseStatistics, "pose_stats/pose_statistics", self.on_result, LATCHED
        )
        self.create_timer(period, self.take_picture)

    def on_result(self, result: Any) -> None:
        """Begin once the node knows the part: it would refuse pictures before."""
        self.is_known = self.is_known or result.part_id == self.part.part_id

    def take_picture(self) -> None:
        """Drop a batch of parts, and publish where the camera sees each of them."""
        if not (self.is_known and self.publisher.get_subscription_count()):
            return
        resting, confidence = self.drop_parts()
        orientations = multiply(self.turns(len(resting)), resting)
        message = ObservedParts(
            part_id=self.part.part_id,
            confidence=confidence.tolist(),
            poses=[
                Pose(orientation=Quaternion(x=x, y=y, z=z, w=w))
                for x, y, z, w in orientations.tolist()
            ],
        )
        message.header.stamp = self.get_clock().now().to_msg()
        self.publisher.publish(message)

    def drop_parts(self) -> tuple[Array, Array]:
        """Orientations x y z w, some of them misread, and the camera's confidence."""
        statistics = simulate(
            self.part,
            self.batch,
            self.restitution,
            seed=self.seed,
            drop_height=self.drop_height,
            workers=1,
        )
        self.seed += 1
        poses = statistics.poses
        orientations = np.array([pose.orientation for pose in poses])
        rows = np.repeat(np.arange(len(poses)), [pose.count for pose in poses])
        is_misread = self.random.random(len(rows)) < self.misread
        rows[is_misread] = self.random.integers(len(poses), size=is_misread.sum())
        doubt = self.random.random(len(rows))
        return orientations[rows], 1.0 - np.where(is_misread, doubt, 0.4 * doubt)

    def turns(self, parts: int) -> Array:
        """A random yaw of each part, and the camera's error about both axes."""
        half_yaw = self.random.uniform(0.0, np.pi, parts)
        tilt = np.zeros((parts, 4))
        tilt[:, :2] = self.random.normal(0.0, 0.5 * self.tilt, (parts, 2))
        tilt[:, 3] = 1.0
        zero = np.zeros(parts)
        return multiply(
            tilt / np.linalg.norm(tilt, axis=1, keepdims=True),
            np.stack([zero, zero, np.sin(half_yaw), np.cos(half_yaw)], axis=1),
        )


def multiply(first: ArrayLike, second: ArrayLike) -> Array:
    """Products of quaternions x y z w by row: the second rotation, then the first."""
    x, y, z, w = np.asarray(first).T
    a, b, c, d = np.asarray(second).T
    return np.stack(
        [
            w * a + x * d + y * c - z * b,
            w * b - x * c + y * d + z * a,
            w * c + x * b - y * a + z * d,
            w * d - x * a - y * b - z * c,
        ],
        axis=1,
    )


def main() -> int:
    """Take pictures until Ctrl-C."""
    try:
        rclpy.init()
        node = SimulatedCamera()
    # Of what rcl refuses it makes RuntimeErrors.
    except (ValueError, ParameterException, RuntimeError) as refusal:
        print(f"simulated_camera: {refusal}", file=sys.stderr)
        return 2
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    except Exception:
        # Ctrl-C or SIGTERM end ROS, maybe in the middle of a callback.
        if rclpy.ok():
            raise
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
