"""The cost of rclpy itself: a process with an empty service and subscriptions to meshes.

    python -m lab.benchmarks.node.bare

The benchmark starts it. The ordinary subscription is that of any rclpy node, so rclpy turns each
vertex and triangle into an object before the callback sees the mesh. The raw one, like the node's,
receives the bytes.
"""

from __future__ import annotations

import sys
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from ros_pose_stats_msgs.srv import CancelDropSimulation
from shape_msgs.msg import Mesh
from std_msgs.msg import UInt32

MESHES = "/bare/mesh"
RAW_MESHES = "/bare/raw_mesh"
SIZES = "/bare/size"
SERVICE = "/bare/service"
SWITCH_SECONDS = 0.001
"""As in the node."""


def main() -> None:
    """Answer until SIGINT."""
    sys.setswitchinterval(SWITCH_SECONDS)
    rclpy.init()
    executor = SingleThreadedExecutor()
    try:
        node = rclpy.create_node("bare")
        answers = node.create_publisher(UInt32, SIZES, 10)

        def on_mesh(mesh: Any) -> None:
            answers.publish(UInt32(data=len(mesh.triangles)))

        def on_bytes(data: bytes) -> None:
            answers.publish(UInt32(data=len(data)))

        def serve(_: Any, response: Any) -> Any:
            response.success = True
            return response

        def say_once() -> None:
            timer.cancel()
            print("ready", flush=True)

        node.create_subscription(Mesh, MESHES, on_mesh, 10)
        node.create_subscription(Mesh, RAW_MESHES, on_bytes, 10, raw=True)
        node.create_service(CancelDropSimulation, SERVICE, serve)
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
