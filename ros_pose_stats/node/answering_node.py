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

"""The node class behind `pose_stats`: services whose answers may come later.

rclpy sends what a callback returns. Here a callback may be a generator that yields the
futures it waits for, so that no thread waits. Requests of a service are taken up one
after the other, in the order of their arrival; until then the middleware has them.
Answers are sent by threads of each service, since one may have to wait for its client.
"""

import threading
import time
from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any, TypeVar

from rclpy import callback_groups, exceptions, logging, qos
from rclpy.node import Node
from rclpy.service import Service

from ..base.errors import PoseStatsError
from .lanes import result_or_refusal
from .messages.codes import describe_error, refuse
from .messages.sending import send_response

T = TypeVar("T")

SERVICE_QUALITY = qos.QoSProfile(
    history=qos.HistoryPolicy.KEEP_LAST,
    depth=3000,  # requests that may wait; ROS's own ten lose the others silently
    reliability=qos.ReliabilityPolicy.RELIABLE,
    durability=qos.DurabilityPolicy.VOLATILE,
)
SENDERS = 16  # answers of a service that may wait for their clients at once
MOST_UNSENT = 1000  # answers of a service; whoever has another one waits
WARNING_SECONDS = 60.0  # between two warnings of a service's clients

Steps = Generator[Future[Any], Any, T]
"""The futures that a callback waits for, one by one."""

Callback = Callable[[Any, Any], Steps[None] | None]
"""Of a request and the response to be filled in."""


def result_of(future: Future[T]) -> Steps[T]:
    """Wait for the result of a future; raises PoseStatsError if it is refused."""
    yield future
    return result_or_refusal(future)


def answer_request(
    callback: Callback,
    log_failure: Callable[[str], object],
    request: Any,
    response: Any,
) -> Steps[None]:
    """Fill in a response; a refusal has its code and its message."""
    response.success = True
    try:
        yield from callback(request, response) or ()
    except Exception as error:  # the client gets an answer in any case
        if not isinstance(error, PoseStatsError):
            log_failure(f"{type(request).__qualname__}: {describe_error(error)}")
        refuse(response, error)


def advance(steps: Steps[None], _: Future[Any] | None = None) -> None:
    """Go on with steps each time that what they wait for is there."""
    future = next(steps, None)
    if future is not None:
        future.add_done_callback(partial(advance, steps))


class AnsweringNode(Node):
    """A node whose services answer when they can, and log which clients cannot hear."""

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        self.last_answer = 0.0  # on the monotonic clock
        for service in self.services:  # of parameters and types: rclpy's own
            service.send_response = self._sender_of(service)

    def full_name(self, name: str) -> str:
        """A topic or service of this node as others call it, after all remappings."""
        return self.resolve_topic_name(f"~/{name}")

    def serve(self, kind: Any, name: str, callback: Callback) -> None:
        """Make a service whose callback may wait before it fills in the response."""
        service = self.create_service(
            kind,
            f"~/{name}",
            lambda request, response: request,
            qos_profile=SERVICE_QUALITY,
            callback_group=callback_groups.MutuallyExclusiveCallbackGroup(),
        )
        send = self._sender_of(service)
        full_name = service.service_name
        log = self.get_logger()

        def answer(request: Any, header: Any) -> Steps[None]:
            begin = time.monotonic()
            response = kind.Response()
            yield from answer_request(callback, log.error, request, response)
            milliseconds = 1000.0 * (time.monotonic() - begin)
            log.debug(
                f"{full_name}: answered after {milliseconds:.1f} ms: "
                f"{response.message or 'done'}"
            )
            send(response, header)

        # rclpy shows the header, which says where an answer goes, to this method alone.
        service.send_response = lambda request, header: advance(answer(request, header))

    def _sender_of(self, service: Service) -> Callable[[Any, Any], None]:
        """What has threads send the answers of a service to those who asked."""
        threads = ThreadPoolExecutor(SENDERS)
        room = threading.Semaphore(MOST_UNSENT)
        full_name = service.service_name
        log = logging.get_logger(self.get_logger().name)  # with minutes of its own

        def send(response: Any, header: Any) -> None:
            try:
                send_response(service, response, header)
            except exceptions.InvalidHandle:
                pass  # the service has ended, and the node with it
            except Exception as error:
                log.warning(
                    f"{full_name}: an answer could not be delivered: "
                    f"{describe_error(error)}",
                    throttle_duration_sec=WARNING_SECONDS,
                )
            self.last_answer = time.monotonic()
            room.release()

        def put(response: Any, header: Any) -> None:
            room.acquire()
            threads.submit(send, response, header)

        return put

    def wait_until_quiet(
        self, pause: float, longest: float, is_busy: Callable[[], bool]
    ) -> None:
        """Let whoever waits be answered, until nobody was for some seconds."""
        self.last_answer = begin = time.monotonic()
        while time.monotonic() < begin + longest and (
            is_busy() or time.monotonic() < self.last_answer + pause
        ):
            time.sleep(0.01)
