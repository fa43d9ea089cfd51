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

"""Stamps as whole nanoseconds and as messages."""

import time
from collections.abc import Callable

from builtin_interfaces.msg import Time
from rclpy import callback_groups, timer
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

FIRST_STAMP = -(2**31) * 10**9
LAST_STAMP = 2**31 * 10**9 - 1  # nanoseconds that a stamp can hold

_read_clock: Callable[[], int] = time.time_ns


def follow_clock(clock: Clock) -> None:
    """Take this process's stamps from a node's clock, until then the system's."""
    global _read_clock
    _read_clock = lambda: clock.now().nanoseconds  # noqa: E731


def current_stamp() -> int:
    """Nanoseconds since the epoch; of simulated time where the node follows that."""
    return _read_clock()


def steady_timer(
    node: Node, seconds: float, callback: Callable[[], None]
) -> timer.Timer:
    """Make a timer beside all else that no jump of simulated time disturbs."""
    return node.create_timer(
        seconds,
        callback,
        callback_groups.MutuallyExclusiveCallbackGroup(),
        Clock(clock_type=ClockType.STEADY_TIME),
    )


CLOCK_SECONDS = 5.0  # that a /clock may take to come


def watch_clock(node: Node) -> None:
    """Warn once where time is simulated, and nobody has published it for a while."""

    def look() -> None:
        clock = node.get_clock()
        if clock.ros_time_is_active and not clock.now().nanoseconds:
            timer.cancel()
            topic = node.resolve_topic_name("/clock")
            node.get_logger().warning(
                f"use_sim_time is true and nobody publishes {topic}: stamps are 0 "
                "until somebody does; publish it, or set use_sim_time to false"
            )

    timer = steady_timer(node, CLOCK_SECONDS, look)


def time_message(stamp: int) -> Time:
    """Nanoseconds as a stamp; the first or last one there is where they are beyond."""
    seconds, nanoseconds = divmod(min(max(stamp, FIRST_STAMP), LAST_STAMP), 10**9)
    return Time(sec=seconds, nanosec=nanoseconds)
