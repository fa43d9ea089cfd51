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

"""A planner: has `~/plan_feeding` plan for a part, then looks, picks and flips.

ros2 run ros_pose_stats example_planner --ros-args \
    -p file:=clamp.stl -p unit:=mm -p wanted:="[0]"
"""

import sys
from array import array
from typing import Any

import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs.action import PlanFeeding
from ros_pose_stats_msgs.msg import Code, ObservedParts, PartList, PartMesh

from ros_pose_stats import classify_orientations, load_part

# As in PlanFeeding.
FEEDER = {
    "dropped_per_minute": 60.0,
    "cycle_seconds": 0.5,
    "plate_length": 0.3,
    "plate_width": 0.2,
    "clearance": 0.0,
    "feeder_setting": "",
}
RETRY_SECONDS = 1.0  # after which a busy node is asked again
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class ExamplePlanner(Node):
    """Plans again whenever the node knows more; robot and plate are lines of a log."""

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
        self.question = PlanFeeding.Goal(
            part_id=part.part_id,
            wanted=wanted_poses,
            **{
                name: self.declare_parameter(name, value).value
                for name, value in FEEDER.items()
            },
        )
        self.revision = 0  # of the result that the last plan was asked for
        self.plan: Any = None
        self.decided = ""
        self.kicks = 0
        self.planning = ActionClient(self, PlanFeeding, "pose_stats/plan_feeding")
        self.create_subscription(PartList, "pose_stats/parts", self.ask, LATCHED)
        self.create_subscription(
            ObservedParts, "pose_stats/observed_parts", self.look, 10
        )
        self.retry = self.create_timer(RETRY_SECONDS, self.request_plan)
        self.retry.cancel()
        self.meshes = self.create_publisher(PartMesh, "pose_stats/part_mesh", LATCHED)
        self.publish_mesh()

    def publish_mesh(self) -> None:
        """Tell the node of the part."""
        self.meshes.publish(
            PartMesh(
                part_id=self.part.part_id,
                vertices=array("d", self.part.vertices.tobytes()),
                triangles=array("I", self.part.triangles.tobytes()),
            )
        )

    def ask(self, message: Any) -> None:
        """Plan by what is new: by an estimate at first, then by what cameras saw."""
        for part in message.parts:
            if part.part_id == self.part.part_id and part.revision != self.revision:
                self.revision = part.revision
                self.request_plan()

    def request_plan(self) -> None:
        """Send the goal."""
        self.retry.cancel()
        self.planning.wait_for_server()
        accepted = self.planning.send_goal_async(self.question)
        accepted.add_done_callback(self.await_plan)

    def await_plan(self, accepted: Any) -> None:
        """Decide once the plan is there; the node accepts every goal."""
        accepted.result().get_result_async().add_done_callback(self.decide)

    def decide(self, planned: Any) -> None:
        """Take a plan, and print it where it is another one."""
        plan = planned.result().result
        if not plan.success:
            self.get_logger().warning(plan.message)
            if plan.code == Code.BUSY:
                self.retry.reset()
            elif plan.code == Code.UNKNOWN_PART:  # it was forgotten meanwhile
                self.publish_mesh()
            return
        pick, flip, leave = (
            [pose for pose, action in enumerate(plan.action) if action == plan_action]
            for plan_action in (plan.PICK, plan.FLIP, plan.LEAVE)
        )
        decided = f"{self.part.part_id}: pick {pick}, flip {flip}, leave {leave}"
        if decided != self.decided:
            for warning in plan.warnings:
                if warning.acts:
                    self.get_logger().warning(f"{warning.code}: {warning.text}")
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
