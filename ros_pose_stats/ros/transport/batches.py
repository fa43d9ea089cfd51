"""Subscriptions under a flood: what waits is taken together, and what was overrun is counted.

The middleware tells of no sample that a newer one pushed out of the history, but every publisher
numbers its messages. Which publisher a message is from is not told either: it is taken to follow
the nearest lower number that has arrived.
"""

import bisect
import math
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node

from ..refusals import MINUTE, Refusals

DEPTH = 1000
"""Messages that wait in the middleware."""

MOST_AT_ONCE = 2**22
"""Bytes of messages that are taken together."""

OVERHEAD = 1000
"""Bytes that a message is taken to occupy beside its own, decoded and on its way."""

Received = tuple[bytes, Mapping[str, int]]

MOST_PUBLISHERS = 64


class SequenceGaps:
    """Counts what is missing between the numbers of one topic."""

    def __init__(self) -> None:
        self._last: list[int] = []

    def missing_before(self, number: int) -> int:
        """Messages lost just before the one that its publisher gave this number; 0: no number."""
        if number <= 0:
            return 0
        place = bisect.bisect_left(self._last, number) - 1
        missing = 0 if place < 0 else number - self._last.pop(place) - 1
        bisect.insort(self._last, number)
        if len(self._last) > MOST_PUBLISHERS:
            del self._last[0]
        return missing


class BatchSubscription:
    """Hands over all serialised messages that wait, and counts those that were overrun.

    While a batch is dealt with, more come. Those that came too quickly all the same are told by
    the numbers that are missing.

    `noun`: what is on it, for the log; `take`: called with serialised messages in the order of
    their coming, by one thread at a time; `count_lost`: counts those that were lost, and returns
    how many that is by now.
    """

    def __init__(self, node: Node, kind: type, topic: str, noun: str,
                 take: Callable[[list[bytes]], object], count_lost: Callable[[int], int],
                 refusals: Refusals) -> None:
        self._log = node.get_logger()
        self._kind, self._topic, self._noun = kind, topic, noun
        self._hand_over = take
        self._add_lost = count_lost
        self._refusals = refusals
        self._gaps = SequenceGaps()
        self._lost_told = -math.inf
        self._lock = threading.Lock()
        self._subscription: Any = node.create_subscription(
            kind, topic, self._on_message, DEPTH, raw=True,
            callback_group=MutuallyExclusiveCallbackGroup())

    def take_waiting(self) -> None:
        """Hand over what the middleware still has, at the end of the node."""
        with self._lock:
            while waiting := self._waiting(0):
                self._deal_with(waiting)

    def _on_message(self, data: bytes, info: Mapping[str, int]) -> None:
        with self._lock:
            self._deal_with([(data, info), *self._waiting(len(data))])

    def _waiting(self, size: int) -> list[Received]:
        """What waits in the middleware, up to so many bytes that can be held at once."""
        waiting: list[Received] = []
        handle = self._subscription.handle
        with handle:
            while size < MOST_AT_ONCE:
                received = handle.take_message(self._kind, True)
                if received is None:
                    break
                waiting.append(received)
                size += len(received[0]) + OVERHEAD
        return waiting

    def _deal_with(self, received: list[Received]) -> None:
        for _, info in received:
            self._count_lost(self._gaps.missing_before(info["publication_sequence_number"] or 0))
            self._refusals.floods.count(f"{self._noun} on {self._topic}")
        self._hand_over([data for data, _ in received])

    def _count_lost(self, lost: int) -> None:
        total = self._add_lost(lost)
        if lost and time.monotonic() - self._lost_told > MINUTE:
            self._lost_told = time.monotonic()
            self._log.warning(f"{self._topic}: {total} counts lost so far: they come faster than "
                              "they can be recorded")
