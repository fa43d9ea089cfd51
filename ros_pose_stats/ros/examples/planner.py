"""A planner: which poses of a part to pick, and from which to flip it or to drop it again.

ros2 run ros_pose_stats example_planner --ros-args -p files:="[clamp.stl]" -p unit:=mm
"""

import sys
import time
from array import array
from functools import partial
from itertools import count
from typing import Any

import numpy as np
import rclpy
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_pose_stats_msgs.msg import PartMesh, PoseStatistics
from ros_pose_stats_msgs.srv import FeedingAnswer

from ros_pose_stats import load_part

# Who joins late gets the current result of every part only with transient local durability, and
# with a depth of as many parts as the node may know (its parameter max_parts).
LATCHED = QoSProfile(depth=256, reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)

TIMEOUT = 30.0
"""Seconds after which a question is asked again: flips may take ten, and an answer may be lost."""


class ExamplePlanner(Node):
    """Decides again whenever the node knows more of a part, and prints what has changed."""

    def __init__(self) -> None:
        super().__init__("example_planner")
        files = self.declare_parameter("files", Parameter.Type.STRING_ARRAY).value
        unit = self.declare_parameter("unit", "").value
        self.picks = self.declare_parameter("picks", 2).value  # groups of poses to pick at most
        self.least_margin = self.declare_parameter("least_margin", 0.1).value  # of these [rad]
        self.gain = self.declare_parameter("gain", 0.02).value  # share worth picking others
        self.rate = self.declare_parameter("rate", 60.0).value  # parts dropped [1/min]
        self.kick_height = self.declare_parameter("kick_height", -1.0).value  # the node's [m]
        self.cycle_time = self.declare_parameter("cycle_time", 0.5).value  # of a flip [s]
        if not files:
            raise ValueError('no meshes of parts, give them as -p files:="[clamp.stl]"')
        parts = [load_part(file, unit=unit or None) for file in files]
        self.picked: dict[str, set[int]] = {part.part_id: set() for part in parts}
        self.decided: dict[str, tuple[int, str]] = {}  # the question's number, and the decision
        self.questions = count()
        self.waiting: dict[str, tuple[float, Any]] = {}  # until when, and the question's result
        self.news: dict[str, Any] = {}
        self.feeding = self.create_client(FeedingAnswer, "pose_stats/feeding")
        self.create_subscription(PoseStatistics, "pose_stats/pose_statistics", self.on_result,
                                 LATCHED)
        self.meshes = self.create_publisher(PartMesh, "pose_stats/part_mesh", LATCHED)
        for part in parts:  # in metres; latched, for a node that starts later or again
            self.meshes.publish(PartMesh(
                part_id=part.part_id, vertices=array("d", part.vertices.tobytes()),
                triangles=array("I", part.triangles.tobytes())))
        self.create_timer(0.1, self.ask)

    def on_result(self, result: Any) -> None:
        """Keep the newest result of a part: an estimate, then drops, then what cameras saw."""
        if result.part_id in self.picked and result.poses:
            self.news[result.part_id] = result

    def ask(self) -> None:
        """Ask what a feeder gets that drops wrong parts again, and one that flips them."""
        if not self.feeding.service_is_ready():  # it may be found later than the topic
            return
        for part_id, (until, result) in self.waiting.items():
            if time.monotonic() > until:
                self.news.setdefault(part_id, result)
        for part_id, result in self.news.items():
            number, wanted = next(self.questions), self.choose_poses(result)
            self.picked[part_id] = wanted
            self.waiting[part_id] = time.monotonic() + TIMEOUT, result
            asked = [self.feeding.call_async(FeedingAnswer.Request(
                part_id=part_id, wanted=wanted, rate=self.rate, kick_height=kick_height,
                cycle_time=self.cycle_time)) for kick_height in (0.0, self.kick_height)]
            for one in asked:
                one.add_done_callback(partial(self.decide, number, result, wanted, asked))
        self.news.clear()

    def choose_poses(self, result: Any) -> set[int]:
        """The likeliest groups of poses that stand firm; new ones only if they gain enough."""
        firm = [pose for pose in result.poses if pose.margin >= self.least_margin]
        best = sorted({(-pose.group_probability, pose.group) for pose in firm})[:self.picks]
        new = {pose.index for pose in firm if (-pose.group_probability, pose.group) in best}
        old = self.picked[result.part_id]
        gain = sum(pose.probability * ((pose.index in new) - (pose.index in old))
                   for pose in result.poses)
        return new if not old or gain > self.gain else old

    def decide(self, number: int, result: Any, wanted: set[int], asked: list[Any], _: Any) -> None:
        """Once both answers are there, see which poses to flip, and print what is new."""
        last, before = self.decided.get(result.part_id, (-1, ""))
        if number < last or not all(one.done() for one in asked):  # answers may overtake others
            return
        self.waiting.pop(result.part_id, None)
        afresh, flipped = (one.result() for one in asked)
        if not (afresh.success and flipped.success):
            self.get_logger().warning(afresh.message if flipped.success else flipped.message)
            return
        wrong = {pose.index for pose in result.poses} - wanted
        flips = wrong & self.choose_flips(result, flipped.transition, wanted)
        decision = (f"{result.part_id}: pick {sorted(wanted)}, flip {sorted(flips)}, "
                    f"drop again {sorted(wrong - flips)}")
        self.decided[result.part_id] = number, decision
        if decision != before:
            print(f"{decision} ({result.method}, {result.observed} parts seen; if all are dropped "
                  f"again {per_minute(afresh)}, flipped {per_minute(flipped)})", flush=True)

    def choose_flips(self, result: Any, transition: Any, wanted: set[int]) -> set[int]:
        """Poses from which flips bring the part into a wanted one sooner than dropping again."""
        if not len(transition):  # the feeder does not flip
            return set()
        poses = sorted(result.poses, key=lambda pose: pose.index)  # they come likeliest first
        probability = np.array([pose.probability for pose in poses])
        seconds = np.zeros(len(poses))  # until the part is picked, by value iteration
        for _ in range(1000):
            dropped = 60.0 / self.rate + probability @ seconds
            flipped = self.cycle_time + np.reshape(transition, (len(poses), -1)) @ seconds
            seconds = np.minimum(dropped, flipped)
            seconds[list(wanted)] = 0.0
        return {pose.index for pose in poses if flipped[pose.index] < dropped}


def per_minute(answer: Any) -> str:
    """Accepted parts a minute, and their 90 % interval."""
    return (f"{answer.accepted_per_minute:.1f} a minute, {answer.accepted_per_minute_low:.1f} to "
            f"{answer.accepted_per_minute_high:.1f}")


def main() -> int:
    """Run the planner until Ctrl-C."""
    try:
        rclpy.init()
        node = ExamplePlanner()
    except (ValueError, ParameterException, RuntimeError) as refusal:  # rcl has RuntimeErrors
        print(f"example_planner: {refusal}", file=sys.stderr)
        return 2
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    except Exception:
        if rclpy.ok():  # else Ctrl-C or SIGTERM ended ROS, maybe in the middle of a callback
            raise
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
