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
