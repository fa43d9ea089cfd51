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

"""The cost of rclpy itself: a process with an empty service, which the benchmark
starts.
"""

import sys
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from ros_pose_stats_msgs.srv import CancelDropSimulation

PREFIX = "/bare"
SERVICE = "cancel_drop_simulation"
"""Its request and its answer are small."""

SWITCH_SECONDS = 0.001
"""As in the node."""


def main() -> None:
    """Answer until SIGINT."""
    sys.setswitchinterval(SWITCH_SECONDS)
    rclpy.init()
    executor = SingleThreadedExecutor()
    try:
        node = rclpy.create_node("bare")

        def serve(_: Any, response: Any) -> Any:
            response.success = True
            return response

        def say_once() -> None:
            timer.cancel()
            print("[bare]: ready", file=sys.stderr, flush=True)

        node.create_service(CancelDropSimulation, f"{PREFIX}/{SERVICE}", serve)
        timer = node.create_timer(0.0, say_once)
        executor.add_node(node)
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
