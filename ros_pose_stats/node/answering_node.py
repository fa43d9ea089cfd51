"""The node class behind `pose_stats`: services whose answers may come later.

rclpy sends what a callback returns. Here a callback may be a generator that yields the
futures it waits for, so that no thread waits. Requests of a service are taken up one
after the other, in the order of their arrival; until then the middleware has them.
"""

import time
import warnings
from collections.abc import Callable, Generator
from concurrent.futures import Future
from functools import partial
from typing import Any

from rclpy import callback_groups, exceptions, qos
from rclpy.node import Node

from ..base.errors import PoseStatsError
from .lanes import result_or_refusal
from .messages.codes import describe_error, refuse

SERVICE_QUALITY = qos.QoSProfile(
    history=qos.HistoryPolicy.KEEP_LAST,
    depth=3000,  # requests that may wait; ROS's own ten lose the others silently
    reliability=qos.ReliabilityPolicy.RELIABLE,
    durability=qos.DurabilityPolicy.VOLATILE,
)
WARNING_SECONDS = 60.0  # between two warnings of a service's clients

# An answer that is thrown away makes rclpy warn, and only so is it known which one it
# was. Its action servers send theirs in another module, which can take no exception for
# that.
warnings.filterwarnings(
    "error", "failed to send response", RuntimeWarning, r"rclpy\.service"
)

Steps = Generator[Future[Any], Any, None]
"""The futures that a callback waits for, one by one; it is sent their results."""

Callback = Callable[[Any, Any], Steps | None]
"""Of a request and the response to be filled in."""


def answer_request(
    callback: Callback,
    log_failure: Callable[[str], object],
    request: Any,
    response: Any,
) -> Future[Any]:
    """The response to come; a refusal has its code and its message."""
    answer: Future[Any] = Future()

    def start() -> Steps:
        yield from callback(request, response) or ()

    def proceed(steps: Steps, finished: Future[Any] | None = None) -> None:
        awaited = None
        try:
            try:
                result = None if finished is None else result_or_refusal(finished)
            except BaseException as error:
                awaited = steps.throw(error)
            else:
                awaited = steps.send(result)
        except StopIteration:
            pass
        except Exception as error:  # the client gets an answer in any case
            if not isinstance(error, PoseStatsError):
                log_failure(f"{type(request).__qualname__}: {describe_error(error)}")
            refuse(response, error)
        if awaited is None:
            answer.set_result(response)
        else:
            awaited.add_done_callback(partial(proceed, steps))

    response.success = True
    proceed(start())
    return answer


class AnsweringNode(Node):
    """A node whose services answer when they can, and log which clients cannot hear."""

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        self._next_warning: dict[str, float] = {}  # by service, on the monotonic clock
        self.last_answer = 0.0  # on the monotonic clock
        for service in self.services:  # of parameters and types: rclpy's own
            service.send_response = partial(
                self._send, service.srv_name, service.send_response
            )

    def full_name(self, name: str) -> str:
        """A topic or service of this node as others call it, after all remappings."""
        return self.resolve_topic_name(f"~/{name}")

    def serve(self, kind: Any, name: str, callback: Callback) -> None:
        """Make a service whose callback may wait before it fills in the response."""
        service: Any = self.create_service(
            kind,
            f"~/{name}",
            lambda request, response: request,
            qos_profile=SERVICE_QUALITY,
            callback_group=callback_groups.MutuallyExclusiveCallbackGroup(),
        )
        send = partial(self._send, self.full_name(name), service.send_response)

        def take_up(request: Any, header: Any) -> None:
            begin = time.monotonic()
            answer = answer_request(
                callback, self.get_logger().error, request, kind.Response()
            )
            answer.add_done_callback(lambda future: send(future.result(), header))
            answer.add_done_callback(partial(self._log_answer, name, begin))

        # rclpy shows the header, which says where an answer goes, to this method alone.
        service.send_response = take_up

    def _log_answer(self, name: str, begin: float, answer: Future[Any]) -> None:
        """Log at the level `debug` how long a request took, and why it was refused."""
        response = answer.result()
        message = "" if response.success else f": {response.message}"
        self.get_logger().debug(
            f"{self.full_name(name)}: answered after "
            f"{1000.0 * (time.monotonic() - begin):.1f} ms{message}"
        )

    def _send(
        self, name: str, send: Callable[..., object], response: Any, header: Any
    ) -> None:
        """Send an answer; one that cannot be delivered is thrown away and logged."""
        self.last_answer = time.monotonic()
        try:
            send(response, header)
        except exceptions.InvalidHandle:
            pass  # the service has ended, and the node with it
        except Exception as error:
            if not isinstance(error.__cause__ or error, RuntimeWarning):
                self.get_logger().warning(
                    f"{name}: an answer could not be sent: {describe_error(error)}"
                )
            elif self.last_answer >= self._next_warning.get(name, 0.0):
                self._next_warning[name] = self.last_answer + WARNING_SECONDS
                self.get_logger().warning(
                    f"{name}: an answer could not be delivered: expected a client "
                    "whose quality of service fits the node's (reliable, volatile), "
                    "got one that cannot be reached; check its quality of service "
                    "and call again"
                )

    def wait_until_quiet(
        self, pause: float, longest: float, is_busy: Callable[[], bool]
    ) -> None:
        """Let whoever waits be answered, until nobody was for some seconds."""
        begin = time.monotonic()
        while time.monotonic() < begin + longest and (
            is_busy() or time.monotonic() < max(begin, self.last_answer) + pause
        ):
            time.sleep(0.01)
