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

"""Processes that end with the demo, how it waits, and a client of the node."""

import ctypes
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
DEMO = ROOT / "demo"

PATIENCE = 600.0
"""Seconds for anything to happen; the first start on a machine compiles the kernels."""

LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1  # of Linux's `prctl`

# Alone on the machine, and out of the way of a real cell.
os.environ.setdefault("ROS_DOMAIN_ID", str(os.getpid() % 90 + 10))
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
os.environ.setdefault("ROS_LOG_DIR", str(DEMO / "ros_log"))


def end_like_ctrl_c() -> None:
    """Let SIGTERM and a closed terminal end this process as Ctrl-C does."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda received, _: sys.exit(128 + received))


def end_with_parent() -> None:
    """Have this process told to end when its parent is killed."""
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGINT)


@contextmanager
def process(module: str, *arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """A module of the checkout in the background; ended with SIGINT in any case."""
    child = subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        cwd=ROOT,
        preexec_fn=end_with_parent,
    )
    try:
        yield child
    finally:
        child.send_signal(signal.SIGINT)
        try:
            child.wait(10.0)
        except subprocess.TimeoutExpired:
            print(f"demo: {module} is killed, for it did not end", file=sys.stderr)
        finally:
            child.kill()
            child.wait()


def wait_for(
    event: str, condition: Callable[[], Any], *children: subprocess.Popen[bytes]
) -> Any:
    """Wait for a condition while the children live, else end the demo."""
    deadline = time.monotonic() + PATIENCE
    while True:
        value = condition()
        if value:
            return value
        has_ended = any(child.poll() is not None for child in children)
        if has_ended or time.monotonic() > deadline:
            sys.exit(f"demo: no {event}")
        time.sleep(0.02)


class Listener:
    """A client with a thread of its own, which keeps all results that come."""

    def __init__(self) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from ros_pose_stats_msgs.msg import PoseStatistics

        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node("demo", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self._results: list[Any] = []
        self.node.create_subscription(
            PoseStatistics,
            "/pose_stats/pose_statistics",
            self._results.append,
            QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL),
        )
        self.thread = threading.Thread(target=self.executor.spin)
        self.thread.start()

    def close(self) -> None:
        """End the thread."""
        self.executor.shutdown()
        self.thread.join()
        self.node.destroy_node()
        self.context.try_shutdown()

    def results(self, part_id: str) -> list[Any]:
        """All results of a part so far, in the order in which they came."""
        return [result for result in self._results if result.part_id == part_id]
