"""What many messages at once do to the middleware's queues, and what the node does about it.

Services lose nothing, because their queues are long. Meshes are too large for that, so what a
flood of them overruns is counted. The middleware tells of no sample that a newer one pushed out
of the history, but every publisher numbers its messages. Which publisher a message is from is
not told either: it is taken to follow the nearest lower number that has arrived.
"""

from __future__ import annotations

import bisect

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

WAITING = 1000
"""Requests, and answers, that wait; ROS's own default of ten loses the others silently."""

SERVICE_QUALITY = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=WAITING, reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE)

MOST_PUBLISHERS = 64


class SequenceGaps:
    """Counts what is missing between the numbers of one topic."""

    def __init__(self) -> None:
        self._last: list[int] = []

    def missing_before(self, number: int) -> int:
        """Messages lost just before this one.

        `number`: of the message, counted by its publisher; 0 where the middleware has none.
        Returns 0 for the first message of a publisher.
        """
        if number <= 0:
            return 0
        place = bisect.bisect_left(self._last, number) - 1
        missing = 0 if place < 0 else number - self._last.pop(place) - 1
        bisect.insort(self._last, number)
        if len(self._last) > MOST_PUBLISHERS:
            del self._last[0]
        return missing
