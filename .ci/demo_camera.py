"""A simulated camera over a plate that is not as the node supposes.

python .ci/demo_camera.py --ros-args -p file:=clamp.stl -p unit:=mm
"""

import sys
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import Pose, Quaternion
from numpy.typing import ArrayLike, NDArray
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_pose_stats_msgs.msg import ObservedParts, PoseStatistics

from ros_pose_stats import load_part, simulate

Array = NDArray[np.float64]

LATCHED = QoSProfile(
    depth=256,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


class SimulatedCamera(Node):
    """Drops parts on a plate and publishes how it sees them lie; a real one only sees them."""

    def __init__(self) -> None:
        super().__init__("simulated_camera")
        file = self.declare_parameter("file", "").value
        unit = self.declare_parameter("unit", "").value
        self.restitution = self.declare_parameter("restitution", 0.1).value
        self.drop_height = self.declare_parameter(
            "drop_height", 0.04
        ).value  # of the COM [m]
        self.tilt = self.declare_parameter(
            "tilt", 0.05
        ).value  # standard deviation [rad]
        self.misread = self.declare_parameter(
            "misread", 0.02
        ).value  # share of the parts
        self.batch = self.declare_parameter("batch", 10).value  # parts a picture
        self.seed = self.declare_parameter("seed", 1).value
        period = self.declare_parameter(
            "period", 0.5
        ).value  # from picture to picture [s]
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
        self.known = False
        self.publisher = self.create_publisher(
            ObservedParts, "pose_stats/observed_parts", 100
        )
        self.create_subscription(
            PoseStatistics, "pose_stats/pose_statistics", self.on_result, LATCHED
        )
        self.create_timer(period, self.take_picture)

    def on_result(self, result: Any) -> None:
        """Begin once the node knows the part; before that it would refuse the pictures."""
        self.known = self.known or result.part_id == self.part.part_id

    def take_picture(self) -> None:
        """Drop a batch of parts, and publish where the camera sees each of them, once."""
        if not (self.known and self.publisher.get_subscription_count()):
            return
        lying, confidence = self.drop_parts()
        seen = multiply(self.turns(len(lying)), lying)
        message = ObservedParts(
            part_id=self.part.part_id,
            confidence=confidence.tolist(),
            poses=[
                Pose(orientation=Quaternion(x=x, y=y, z=z, w=w))
                for x, y, z, w in seen.tolist()
            ],
        )
        message.header.stamp = self.get_clock().now().to_msg()
        self.publisher.publish(message)

    def drop_parts(self) -> tuple[Array, Array]:
        """How the parts lie, a row x y z w each, some misread; and how sure the camera is."""
        landed = simulate(
            self.part,
            self.batch,
            self.restitution,
            seed=self.seed,
            drop_height=self.drop_height,
            workers=1,
        )
        self.seed += 1
        orientations = np.array([pose.orientation for pose in landed.poses])
        pose = np.repeat(
            np.arange(len(landed.poses)), [pose.count for pose in landed.poses]
        )
        wrong = self.random.random(len(pose)) < self.misread
        pose[wrong] = self.random.integers(len(landed.poses), size=wrong.sum())
        doubt = self.random.random(len(pose))
        return orientations[pose], 1.0 - np.where(wrong, doubt, 0.4 * doubt)

    def turns(self, parts: int) -> Array:
        """A random yaw of each part, and the camera's error about both horizontal axes."""
        yaw = self.random.uniform(0.0, np.pi, parts)  # half of it
        tilt = np.zeros((parts, 4))
        tilt[:, :2] = self.random.normal(0.0, 0.5 * self.tilt, (parts, 2))
        tilt[:, 3] = 1.0
        zero = np.zeros(parts)
        return multiply(
            tilt / np.linalg.norm(tilt, axis=1, keepdims=True),
            np.stack([zero, zero, np.sin(yaw), np.cos(yaw)], axis=1),
        )


def multiply(first: ArrayLike, second: ArrayLike) -> Array:
    """Products of quaternions x y z w, row by row: the second rotation, then the first."""
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
    except (
        ValueError,
        ParameterException,
        RuntimeError,
    ) as refusal:  # rcl has RuntimeErrors
        print(f"simulated_camera: {refusal}", file=sys.stderr)
        return 2
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    except Exception:
        if (
            rclpy.ok()
        ):  # else Ctrl-C or SIGTERM ended ROS, maybe in the middle of a callback
            raise
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
