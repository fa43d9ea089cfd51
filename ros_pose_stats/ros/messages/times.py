"""Stamps as whole nanoseconds and as messages."""

from __future__ import annotations

import time

from builtin_interfaces.msg import Duration, Time

FIRST, LAST = -2**31 * 10**9, 2**31 * 10**9 - 1
"""Nanoseconds that a stamp can hold."""


def now() -> int:
    """Nanoseconds since the epoch."""
    return time.time_ns()


def time_message(stamp: int) -> Time:
    """Nanoseconds as a stamp; the first or last one there is where they are beyond."""
    seconds, rest = divmod(min(max(stamp, FIRST), LAST), 10**9)
    return Time(sec=seconds, nanosec=rest)


def duration_message(seconds: float) -> Duration:
    """Seconds, at least 0, as a duration; 0 where they are not known."""
    whole, rest = divmod(round(1e9 * seconds) if seconds > 0.0 else 0, 10**9)
    return Duration(sec=whole, nanosec=rest)
