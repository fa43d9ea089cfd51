"""Stamps as whole nanoseconds and as messages."""

import time
from collections.abc import Callable

from builtin_interfaces.msg import Time
from rclpy import callback_groups, clock as clocks, node as nodes, timer

FIRST = -(2**31) * 10**9
LAST = 2**31 * 10**9 - 1  # nanoseconds that a stamp can hold

_read_clock: Callable[[], int] = time.time_ns


def follow_clock(clock: clocks.Clock) -> None:
    """Take the stamps of this process from a node's clock; until then they are the system's."""
    global _read_clock
    _read_clock = lambda: clock.now().nanoseconds  # noqa: E731


def now() -> int:
    """Nanoseconds since the epoch; of simulated time where the node follows that."""
    return _read_clock()


def steady_timer(
    node: nodes.Node, seconds: float, callback: Callable[[], None]
) -> timer.Timer:
    """Make a timer that goes on beside all else, where simulated time stands still or jumps."""
    return node.create_timer(
        seconds,
        callback,
        callback_groups.MutuallyExclusiveCallbackGroup(),
        clocks.Clock(clock_type=clocks.ClockType.STEADY_TIME),
    )


def time_message(stamp: int) -> Time:
    """Nanoseconds as a stamp; the first or last one there is where they are beyond."""
    seconds, rest = divmod(min(max(stamp, FIRST), LAST), 10**9)
    return Time(sec=seconds, nanosec=rest)
