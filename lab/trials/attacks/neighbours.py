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

"""Clients that trouble a node, each in a process of its own.

    python -m lab.trials.attacks.neighbours NAME PREFIX [NUMBER ...]

PREFIX is that of the node's names. Each prints a line when its trouble begins.
"""

import sys

import rclpy
from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionClient
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.action import SimulateFlips
from ros_pose_stats_msgs.msg import PartMesh, PoseCounts, PoseStatistics

from tests.contract.node.harness.parts import fine_box, flat

KNOWN = "known"
"""The part that all of them are about."""


class Neighbour:
    """A ROS node beside the one that is tried."""

    def __init__(self, prefix):
        rclpy.init()
        self.node = rclpy.create_node("neighbour")
        self.prefix = prefix

    def client(self, kind, name, depth=10):
        """The client of a service that is there."""
        client = self.node.create_client(
            kind, f"{self.prefix}/{name}", qos_profile=QoSProfile(depth=depth)
        )
        client.wait_for_service()
        return client

    def publisher(self, kind, name, depth=10):
        """A publisher of a topic."""
        return self.node.create_publisher(kind, f"{self.prefix}/{name}", depth)

    def go_on(self, act, rate):
        """Do something so many times a second."""
        self.node.create_timer(1.0 / rate, act)

    def begin(self):
        """Say that it begins, and go on for ever."""
        print("begun", flush=True)
        rclpy.spin(self.node)


def subscribe(neighbour):
    """Hear all results."""
    latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    neighbour.node.create_subscription(
        PoseStatistics,
        f"{neighbour.prefix}/pose_statistics",
        lambda _: print("heard", flush=True),
        latched,
    )


def ask(neighbour, rate):
    """Ask for an estimate, so many times a second, and say each time that it did."""
    client = neighbour.client(srv.EstimatePoses, "estimate")
    request = srv.EstimatePoses.Request(part_id=KNOWN)

    def ask_once():
        client.call_async(request)
        print("asked", flush=True)

    neighbour.go_on(ask_once, rate)


def ask_for_many(neighbour, count):
    """Ask at once for estimates at so many other restitutions."""
    client = neighbour.client(srv.EstimatePoses, "estimate", count)
    for number in range(count):
        client.call_async(
            srv.EstimatePoses.Request(part_id=KNOWN, restitution=0.3 + 1e-4 * number)
        )


def ask_for_outlines(neighbour, heights, at_once):
    """Ask for outlines at so many heights, so many times at once, once a second."""
    client = neighbour.client(srv.GetStatistics, "get_statistics", 10 * at_once)
    request = srv.GetStatistics.Request(
        part_id=KNOWN, heights=[1e-6 * number for number in range(heights)]
    )

    def ask_all():
        for _ in range(at_once):
            client.call_async(request)

    neighbour.go_on(ask_all, 1.0)


def publish_meshes(neighbour, triangles):
    """Publish a mesh of so many triangles every six seconds, each time another one."""
    publisher = neighbour.publisher(PartMesh, "part_mesh")
    vertices, corners = fine_box(triangles)
    messages = [
        flat((factor * vertices, corners), "large") for factor in (1.0, 1.01, 1.02)
    ]

    def publish():
        messages.append(messages.pop(0))
        publisher.publish(messages[0])

    neighbour.go_on(publish, 1.0 / 6.0)


def count(neighbour, rate):
    """Count parts as a camera does, in so many messages a second, ten at a time."""
    publisher = neighbour.publisher(PoseCounts, "pose_counts", 1000)
    message = PoseCounts(part_id=KNOWN, index=[0, 1], count=[1, 1])

    def publish():
        for _ in range(10):
            message.header.stamp.sec += 1
            publisher.publish(message)

    neighbour.go_on(publish, 0.1 * rate)


def set_parameters(neighbour, rate):
    """Set the restitution, so many times a second."""
    client = neighbour.client(SetParameters, "set_parameters")
    values = [0.3 + 0.01 * number for number in range(20)]

    def set_next():
        values.append(values.pop(0))
        parameter = Parameter("restitution", value=values[0]).to_parameter_msg()
        client.call_async(SetParameters.Request(parameters=[parameter]))

    neighbour.go_on(set_next, rate)


def flip(neighbour):
    """Have the part flipped, at one kick after the other."""
    name = f"{neighbour.prefix}/simulate_flips"
    client = ActionClient(neighbour.node, SimulateFlips, name)
    client.wait_for_server()
    goal = SimulateFlips.Goal(part_id=KNOWN, kick_height=0.01, drops=100_000)

    def send(_):
        goal.kick_height += 1e-4
        client.send_goal_async(goal).add_done_callback(follow)

    def follow(accepted):
        accepted.result().get_result_async().add_done_callback(send)

    send(None)


def fill_queue(neighbour, rate):
    """Start simulations, so many a second, most of which find the queue full."""
    client = neighbour.client(srv.StartDropSimulation, "start_drop_simulation")
    request = srv.StartDropSimulation.Request(part_id=KNOWN, drops=100_000)

    def start():
        request.seed += 1
        client.call_async(request)

    neighbour.go_on(start, rate)


NEIGHBOURS = {
    function.__name__: function
    for function in (
        subscribe,
        ask,
        ask_for_many,
        ask_for_outlines,
        publish_meshes,
        count,
        set_parameters,
        flip,
        fill_queue,
    )
}


def main():
    """Trouble the node until somebody ends it."""
    name, prefix, *numbers = sys.argv[1:]
    neighbour = Neighbour(prefix)
    NEIGHBOURS[name](neighbour, *map(int, numbers))
    neighbour.begin()


if __name__ == "__main__":
    main()
