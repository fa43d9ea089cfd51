"""A planner: which poses of a part to pick, out of which to flip it, out of which to drop it again.

    ros2 run ros_pose_stats example_planner --ros-args -p files:="[clamp.stl]" -p unit:=mm
"""

from __future__ import annotations

import sys
from array import array
from functools import partial
from typing import Any

import numpy as np
import rclpy
from numpy.typing import NDArray
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_pose_stats_msgs.msg import PartMesh, PoseStatistics
from ros_pose_stats_msgs.srv import FeedingAnswer

from ros_pose_stats import Part, load_part

# Who joins late gets the current result of every part only with transient local durability, and
# with a depth of as many parts as the node may know (its parameter max_parts).
LATCHED = QoSProfile(depth=256, reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)


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
            raise ValueError("no meshes of parts, give them as -p files:=\"[clamp.stl]\"")
        parts = [load_part(file, unit=unit or None) for file in files]
        self.picked: dict[str, set[int]] = {part.part_id: set() for part in parts}
        self.decided: dict[str, str] = {}
        self.news: dict[str, Any] = {}
        self.feeding = self.create_client(FeedingAnswer, "pose_stats/feeding")
        self.create_subscription(PoseStatistics, "pose_stats/pose_statistics", self.on_result,
                                 LATCHED)
        self.meshes = self.create_publisher(PartMesh, "pose_stats/part_mesh", LATCHED)
        for part in parts:  # latched too, for a node that starts later or again
            self.meshes.publish(mesh_message(part))
        self.create_timer(0.1, self.ask)

    def on_result(self, result: Any) -> None:
        """Keep the newest result of a part: an estimate, then drops, then what cameras saw."""
        if result.part_id in self.picked and result.poses:
            self.news[result.part_id] = result

    def ask(self) -> None:
        """Ask what a feeder gets that drops wrong parts again, and one that flips them."""
        if not self.feeding.service_is_ready():  # it may be found later than the topic
            return
        for part_id, result in self.news.items():
            self.picked[part_id] = wanted = self.choose_poses(result)
            asked = [self.feeding.call_async(FeedingAnswer.Request(
                part_id=part_id, wanted=wanted, rate=self.rate, kick_height=kick_height,
                cycle_time=self.cycle_time)) for kick_height in (0.0, self.kick_height)]
            for one in asked:
                one.add_done_callback(partial(self.decide, result, wanted, asked))
        self.news.clear()

    def choose_poses(self, result: Any) -> set[int]:
        """The most probable poses out of which no nudge topples the part.

        Poses of one group look alike, and are picked alike. Other poses than so far need other
        grippers: that must gain something.
        """
        steady = sorted((pose for pose in result.poses if pose.margin >= self.least_margin),
                        key=lambda pose: -pose.group_probability)
        groups = list(dict.fromkeys(pose.group for pose in steady))[:self.picks]
        old = self.picked[result.part_id]
        new = {pose.index for pose in steady if pose.group in groups}
        probability = {pose.index: pose.probability for pose in result.poses}
        gain = sum(map(probability.get, new)) - sum(map(probability.get, old))
        return new if not old or gain > self.gain else old

    def decide(self, result: Any, wanted: set[int], asked: list[Any], _: Any) -> None:
        """Once both questions are answered, decide where to flip; print what is new."""
        if not all(one.done() for one in asked):
            return
        afresh, flipped = (one.result() for one in asked)
        if not (afresh.success and flipped.success):
            self.get_logger().warning(flipped.message or afresh.message)
            return
        wrong = set(range(len(result.poses))) - wanted
        flips = wrong & poses_to_flip(probabilities(result), np.array(flipped.transition), wanted,
                                      60.0 / self.rate, self.cycle_time)
        decision = (f"{result.part_id}: pick poses {sorted(wanted)}, flip {sorted(flips)}, "
                    f"drop {sorted(wrong - flips)} again")
        if decision != self.decided.get(result.part_id):
            self.decided[result.part_id] = decision
            print(f"{decision}; {result.method}, {result.observed} parts seen: all dropped again "
                  f"{per_minute(afresh)}, all flipped {per_minute(flipped)}", flush=True)


def probabilities(result: Any) -> NDArray[np.float64]:
    """Probability of each pose by its `index`; results list the most probable pose first."""
    return np.array([pose.probability for pose in sorted(result.poses, key=lambda p: p.index)])


def poses_to_flip(probability: NDArray[np.float64], transition: NDArray[np.float64],
                  wanted: set[int], drop_seconds: float, flip_seconds: float) -> set[int]:
    """Poses out of which flips bring a part that is picked sooner than dropping it again.

    By value iteration of the seconds that it takes from each pose until a part is picked.
    """
    poses = len(probability)
    if not len(transition):  # the feeder does not flip
        return set()
    seconds = np.zeros(poses)
    for _ in range(1000):
        again = drop_seconds + probability @ seconds
        flipped = flip_seconds + transition.reshape(poses, poses) @ seconds
        seconds = np.minimum(again, flipped)
        seconds[list(wanted)] = 0.0
    return {int(pose) for pose in np.flatnonzero(flipped < again)}


def per_minute(answer: Any) -> str:
    """Accepted parts a minute with the bounds of their 90 % interval."""
    return (f"{answer.accepted_per_minute:.1f} ({answer.accepted_per_minute_low:.1f} to "
            f"{answer.accepted_per_minute_high:.1f}) a minute")


def mesh_message(part: Part) -> PartMesh:
    """A mesh in metres as flat arrays, which are much quicker than a `shape_msgs/Mesh`."""
    return PartMesh(part_id=part.part_id, vertices=array("d", part.vertices.tobytes()),
                    triangles=array("I", part.triangles.tobytes()), unit=1.0)


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
