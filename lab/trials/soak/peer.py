"""A client that is always in the middle of a call, to be killed there."""

import os

from rclpy.action import ActionClient
from ros_pose_stats_msgs.action import SimulateDrops

from ..cell import WEDGE, Client, flat
from .life import PREFIX

part = flat(WEDGE, "peer")
goal = SimulateDrops.Goal(part=part, drops=10**6, max_seconds=0.3)
with Client(int(os.environ["ROS_DOMAIN_ID"]), PREFIX) as client:
    client.service("estimate")
    action = ActionClient(client.node, SimulateDrops, f"{PREFIX}/simulate_drops")
    print("ready", flush=True)
    while True:
        client.call("estimate", part=part)
        client.run(lambda: action.send_goal_async(goal))
