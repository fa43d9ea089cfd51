"""Subscriptions under a flood: what waits is taken together, and what was overrun is counted.

The middleware tells of no sample that a newer one pushed out of the history, but every publisher
numbers its messages. Which publisher a message is from is not told either: it is taken to follow
the nearest lower number that has arrived.
"""

import bisect
import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Any

from rclpy import event_handler, qos
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

from .base import Base
from .refusals import MINUTE

DEPTH = 1000  # messages that wait in the middleware
MOST_AT_ONCE = 2**22  # bytes of messages that are taken together
OVERHEAD = 1000  # bytes that a message is taken to occupy beside its own, decoded and on its way

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
    """Hands all messages that wait over to `take`, in their order, by one thread at a time."""

    def __init__(self, base: Base, kind: type, topic: str, noun: str,
                 take: Callable[[list[bytes]], object]) -> None:
        self._log, self._floods = base.node.get_logger(), base.refusals.floods
        self._kind, self._topic, self._noun = kind, topic, noun
        self._hand_over, self._add_lost = take, base.recorder.count_lost
        self._gaps, self._warned = SequenceGaps(), -math.inf
        self._lock = threading.Lock()
        self._came: OrderedDict[tuple[int, int, int], None] = OrderedDict()
        group = MutuallyExclusiveCallbackGroup()
        self._subscription: Any = base.node.create_subscription(
            kind, topic, lambda data, info: self._take_with([(data, info)]), DEPTH, raw=True,
            callback_group=group,
            event_callbacks=event_handler.SubscriptionEventCallbacks(
                incompatible_qos=lambda info: None))
        base.node.create_subscription(kind, topic, self._take_unreliable, qos.QoSProfile(
            depth=DEPTH, reliability=qos.ReliabilityPolicy.BEST_EFFORT), raw=True,
            callback_group=group)

    def take_waiting(self) -> None:
        """Hand over what the middleware still has, at the end of the node."""
        while self._take_with([]):
            pass

    def _take_with(self, received: list[Received]) -> bool:
        """Hand over messages and what waits behind them, up to so many bytes; whether any."""
        size, handle = sum(len(data) for data, _ in received), self._subscription.handle
        with self._lock:
            with handle:
                while size < MOST_AT_ONCE and (
                        waiting := handle.take_message(self._kind, True)) is not None:
                    received.append(waiting)
                    size += len(waiting[0]) + OVERHEAD
            lost = 0
            for _, info in received:
                number = info["publication_sequence_number"] or 0
                lost += self._gaps.missing_before(number)
                self._floods.count(f"{self._noun} on {self._topic}")
            total = self._add_lost(lost)
            if lost and time.monotonic() - self._warned > MINUTE:
                self._warned = time.monotonic()
                self._log.warning(f"{self._topic}: {total} counts lost so far: they come faster "
                                  "than they can be recorded")
            fresh = [data for data, info in received if not self._is_copy(data, info)]
            if fresh:
                self._hand_over(fresh)
        return bool(received)

    def _take_unreliable(self, data: bytes, info: Mapping[str, int]) -> None:
        """Hand over what best-effort publishers send."""
        with self._lock:
            if not self._is_copy(data, info):
                self._hand_over([data])

    def _is_copy(self, data: bytes, info: Mapping[str, int]) -> bool:
        """Whether the other subscription had it: a reliable publisher matches both."""
        sent = info["source_timestamp"], info["publication_sequence_number"], hash(bytes(data))
        came = sent in self._came
        self._came[sent] = None
        if len(self._came) > 4 * DEPTH:
            self._came.popitem(last=False)
        return came
