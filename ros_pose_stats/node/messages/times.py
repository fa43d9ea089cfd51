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


def time_message(stamp: int) -> Time:
    """Nanoseconds as a stamp; the first or last one there is where they are beyond."""
    seconds, nanoseconds = divmod(min(max(stamp, FIRST_STAMP), LAST_STAMP), 10**9)
    return Time(sec=seconds, nanosec=nanoseconds)
