"""The node class behind `pose_stats`: what rclpy leaves undone for services and clocks."""

from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.service import Service
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock

from ..messages.times import steady_timer
from .answers import PAUSE, QUIET, Answers, Asked

SERVICE_QUALITY = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=1000, reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE)
"""ROS's own depth of ten loses all other requests of a thousand silently."""


class AnsweringNode(Node):
    """A node that no single client holds up, and no simulated time that rclpy cannot hold ends."""

    def __init__(self, name: str, **options: Any) -> None:
        self.answers = Answers(lambda line: self.get_logger().warning(line))
        super().__init__(name, **options)

        def send(name: str, send_now: Callable[..., object], response: Any, header: Any) -> None:
            self.answers.send(self.answers.asked(name, number_of(header)),
                              lambda: send_now(response, header))

        for service in self.services:  # of parameters and types, which rclpy has made by itself
            service.send_response = partial(send, service.srv_name, service.send_response)
        steady_timer(self, PAUSE, self.answers.retry)

    def serve(self, kind: Any, name: str, callback: Callable[..., Any],
              may_wait: Callable[[Any], bool] = lambda request: True) -> None:
        """Make a service whose clients are answered in turn, also by a future of the answer.

        `may_wait`: whether a request may wait for its client's turn; it must hold on to little.
        """
        service: Service = self.create_service(
            kind, name, _Taken, qos_profile=SERVICE_QUALITY,
            callback_group=MutuallyExclusiveCallbackGroup())
        send_now = service.send_response

        def send(asked: Asked, header: Any, response: Any) -> None:
            if isinstance(response, Future):  # no thread waits until the answer is there
                response.add_done_callback(lambda done: send(asked, header, done.result()))
            else:
                self.answers.send(asked, lambda: send_now(response, header))

        def answer(asked: Asked, header: Any, request: Any) -> None:
            send(asked, header, callback(request, kind.Response()))

        def sort_all(taken: _Taken, header: Any) -> None:
            """Sort a request that the executor took, and those that wait behind it.

            One that may not wait is answered now; the executor comes for what is behind it.
            """
            request: Any = taken.request
            act: Callable[[], object] | None = None
            with self.answers.sorting(), suppress(InvalidHandle):  # of a service that has ended
                while header is not None:
                    asked = self.answers.asked(name, number_of(header))
                    act = partial(answer, asked, header, request)
                    if not (may_wait(request) and self.answers.has_room()):
                        break
                    self.answers.put(asked.client, act)
                    act = None
                    with service.handle:
                        request, header = service.handle.service_take_request(kind.Request)
            if act is not None:
                act()

        service.send_response = sort_all

    def create_subscription(self, msg_type: Any, topic: str, callback: Callable[..., Any],
                            *arguments: Any, **options: Any) -> Subscription:
        """Make a subscription; a time on /clock that rclpy cannot hold would end the executor."""
        def follow(message: Clock) -> None:
            try:
                callback(message)
            except (ValueError, OverflowError) as error:
                self.get_logger().warning(
                    f"{topic}: expected a time from 0 on, got {message.clock.sec} s ({error}); "
                    "the time before holds", throttle_duration_sec=QUIET)

        return super().create_subscription(
            msg_type, topic, follow if msg_type is Clock else callback, *arguments, **options)


def number_of(header: Any) -> int:
    """What a client numbered its request."""
    number: int = header.request_id.sequence_number
    return number


@dataclass(slots=True, eq=False)
class _Taken:
    """A request that waits for its turn, in place of its answer."""

    request: Any
    response: Any
