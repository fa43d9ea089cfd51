"""A planner: asks `~/feeding` what to do with a part, then looks, picks and flips.

ros2 run ros_pose_stats example_planner --ros-args \
    -p file:=clamp.stl -p unit:=mm -p wanted:="[0]"
"""

import sys
from array import array
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs.msg import ObservedParts, PartMesh, PoseStatistics
from ros_pose_stats_msgs.srv import FeedingAnswer

from ros_pose_stats import classify_orientations, load_part

# As in FeedingAnswer.
FEEDER = {
    "rate": 60.0,
    "cycle_time": 0.5,
    "plate_length": 0.3,
    "plate_width": 0.2,
    "clearance": 0.0,
    "feeder_speed": "",
}
LATCHED = QoSProfile(depth=256, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class ExamplePlanner(Node):
    """Asks again whenever the node knows more; robot and plate are lines of a log."""

    def __init__(self) -> None:
        super().__init__("example_planner")
        file = self.declare_parameter("file", "").value
        unit = self.declare_parameter("unit", "").value
        wanted_poses = self.declare_parameter(
            "wanted", Parameter.Type.INTEGER_ARRAY
        ).value
        if not file or not wanted_poses:
            raise ValueError(
                'expected -p file:=clamp.stl -p wanted:="[0, 1]", the poses to pick'
            )
        self.part = part = load_part(file, unit=unit or None)
        if part.unit_guessed:
            raise ValueError(
                f"expected -p unit:=mm, m, inch or cm, since {file} names none"
            )
        self.question = FeedingAnswer.Request(
            part_id=part.part_id,
            wanted=wanted_poses,
            **{
                name: self.declare_parameter(name, value).value
                for name, value in FEEDER.items()
            },
        )
        self.plan: Any = None
        self.decided = ""
        self.kicks = 0
        self.feeding = self.create_client(FeedingAnswer, "pose_stats/feeding")
        self.create_subscription(
            PoseStatistics, "pose_stats/pose_statistics", self.ask, LATCHED
        )
        self.create_subscription(
            ObservedParts, "pose_stats/observed_parts", self.look, 10
        )
        self.meshes = self.create_publisher(PartMesh, "pose_stats/part_mesh", LATCHED)
        self.meshes.publish(
            PartMesh(
                part_id=part.part_id,
                vertices=array("d", part.vertices.tobytes()),
                triangles=array("I", part.triangles.tobytes()),
            )
        )

    def ask(self, result: Any) -> None:
        """Ask what to do: of an estimate at first, then of what cameras saw."""
        if result.part_id == self.part.part_id and result.poses:
            self.feeding.call_async(self.question).add_done_callback(self.decide)

    def decide(self, answered: Any) -> None:
        """Take a plan, and print it where it is another one."""
        plan = answered.result()
        if not plan.success:
            self.get_logger().warning(plan.message)
            return
        pick, flip, leave = (
            [pose for pose, action in enumerate(plan.action) if action == plan_action]
            for plan_action in (plan.PICK, plan.FLIP, plan.LEAVE)
        )
        decided = f"{self.part.part_id}: pick {pick}, flip {flip}, leave {leave}"
        if decided != self.decided:
            print(
                f"{decided}; {plan.parts_on_plate} parts, "
                f"{1e3 * plan.kick_height:.3g} mm kicks: "
                f"{plan.parts_per_minute:.3g} a minute. {plan.message}",
                flush=True,
            )
        self.plan = plan
        self.decided = decided

    def look(self, picture: Any) -> None:
        """Pick what lies right, fill the plate up, and kick it if that is worth it."""
        if self.plan is None or picture.part_id != self.part.part_id:
            return
        turns = [
            [getattr(pose.orientation, axis) for axis in "xyzw"]
            for pose in picture.poses
        ]
        # -1: none, or not surely
        poses = classify_orientations(self.part, turns).tolist()
        actions = [
            self.plan.action[pose] if pose >= 0 else self.plan.LEAVE for pose in poses
        ]
        picks = actions.count(self.plan.PICK)
        kick = self.plan.FLIP in actions and self.kicks < self.plan.kicks
        self.kicks = self.kicks + 1 if kick else 0
        missing = self.plan.parts_on_plate - (len(poses) - picks if kick else 0)
        self.get_logger().info(
            f"pick {picks}, {'kick' if kick else 'empty the plate'}, drop "
            f"{max(0, missing)}",
            throttle_duration_sec=1.0,
        )


def main() -> int:
    """Run the planner until Ctrl-C."""
    node = None
    try:
        rclpy.init()
        node = ExamplePlanner()
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    except Exception as error:
        if node is None:
            print(f"example_planner: {error}", file=sys.stderr)
            return 2
        # Else Ctrl-C or SIGTERM ended ROS, maybe in the middle of a callback.
        if rclpy.ok():
            raise
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
