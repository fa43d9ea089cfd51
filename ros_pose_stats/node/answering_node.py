"""The node class behind `pose_stats`: what rclpy leaves undone for services.

A client that sends a thousand requests at once would keep all others waiting, for the middleware
hands them over in the order in which they came. And for a client whose quality of service does
not fit, `rcl_send_response` waits a tenth of a second with the interpreter locked before the
answer is thrown away.
"""

import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rclpy import callback_groups, exceptions, node as nodes, qos

from ..base.errors import PoseStatsError
from .lanes import describe_error, result_or_refusal
from .stop_signals import within

SERVICE_QUALITY = qos.QoSProfile(
    history=qos.HistoryPolicy.KEEP_LAST,
    depth=1000,
    reliability=qos.ReliabilityPolicy.RELIABLE,
    durability=qos.DurabilityPolicy.VOLATILE,
)
"""ROS's own depth of ten loses all other requests of a thousand silently."""

THREADS = 3  # those that wait for the disk at the same time wait for it together
MOST_WAITING = 2000  # requests; the others are left to the middleware
MOST_NUMBERS = 1000
MOST_ALIKE = 16  # by which clients are told apart; clients of one number
MISSES = 2  # in a row, after which a client is taken for one that cannot be reached
FIRST = 1.0
AGAIN = 10.0  # seconds before such a client is tried; the second for all together
QUIET = 60.0  # seconds between two warnings of a kind

warnings.filterwarnings(
    "error", "failed to send response", RuntimeWarning, r"rclpy\.service"
)
"""rclpy warns so of each answer that was thrown away, and that is what tells which ones were.

Those of its action servers it sends from another module, which takes no exception for that.
"""

Steps = Generator[Future[Any], Any, None]
"""What a callback waits for in turn; it is given what comes of each."""

Callback = Callable[
    [Any, Any], Steps | None
]  # of a request and the response to be filled in


def answered(
    callback: Callback,
    say_failure: Callable[[str], object],
    request: Any,
    response: Any,
) -> Future[Any]:
    """The response, with a refusal as `success = false` and its message."""
    coming_answer: Future[Any] = Future()

    def begin() -> Steps:
        yield from callback(request, response) or ()

    def go_on(steps: Steps, done: Future[Any] | None = None) -> None:
        coming = None
        try:
            try:
                value = None if done is None else result_or_refusal(done)
            except BaseException as error:
                coming = steps.throw(error)
            else:
                coming = steps.send(value)
        except StopIteration:
            pass
        except Exception as error:  # the client gets an answer in any case
            if not isinstance(error, PoseStatsError):
                say_failure(f"{type(request).__qualname__}: {describe_error(error)}")
            if hasattr(response, "success"):
                response.success = False
                response.message = describe_error(error)
        if coming is None:
            coming_answer.set_result(response)
        else:  # no thread waits
            coming.add_done_callback(partial(go_on, steps))

    if hasattr(response, "success"):
        response.success = True
    go_on(begin())
    return coming_answer


@dataclass(slots=True, eq=False)
class Client:
    """What seems to be one client of a service: rclpy tells only the numbers of its requests."""

    requests: deque[Callable[[], object]] = field(default_factory=deque)  # that wait
    misses: int = 0  # answers in a row that did not reach it
    due: float = 0.0  # when it may be tried again, by the monotonic clock
    # Another one gave a request the same number, and which is which is not known yet.
    is_mixed_up: bool = False


# who a request seems to be from, and the one that it may be from, which was not reached
Asked = tuple[Client, Client | None]


class Answers:
    """Works off requests, the clients in turn; while `lock` is held nobody is answered."""

    def __init__(
        self, warn: Callable[[str], object], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._warn = warn
        self._clock = clock
        self._by_number: dict[
            tuple[str, int], list[Client]
        ] = {}  # of their last requests
        self._lines: deque[Client] = deque()  # clients whose requests wait
        self._waiting = 0
        self._closed = False
        self._next_try = 0.0
        self._warned = dict[str, float]()
        self.lock = threading.RLock()
        self.last = 0.0
        self._pool = ThreadPoolExecutor(THREADS, "answers")

    def asked(self, service: str, number: int) -> Asked:
        """Tell who has given its request this number; of several clients, one that is reached."""
        with self.lock:
            # Of equal ones the last that asked: many at once come one right after the other.
            alike = sorted(
                self._by_number.pop((service, number - 1), []),
                key=lambda candidate: -candidate.misses,
            )
            client = alike.pop() if alike else Client()
            if alike:
                self._by_number[service, number - 1] = alike
            there = self._by_number.setdefault((service, number), [])
            there.append(client)
            del there[:-MOST_ALIKE]
            if len(self._by_number) > MOST_NUMBERS:
                del self._by_number[next(iter(self._by_number))]
            rival = (
                alike[-1]
                if alike and client.misses < MISSES <= alike[-1].misses
                else None
            )
            if rival is not None:
                rival.is_mixed_up = True
            return client, rival

    def put(self, client: Client, act: Callable[[], object]) -> bool:
        """Have a request answered when it is its client's turn; whether it may wait."""
        with self.lock:
            if self._waiting >= MOST_WAITING or self._closed:
                return False
            if not client.requests:
                self._lines.append(client)
            client.requests.append(act)
            self._waiting += 1
            self._pool.submit(self._answer_next)
            return True

    def _answer_next(self) -> None:
        with self.lock:
            client = self._lines.popleft()
            act = client.requests.popleft()
            self._waiting -= 1
            if client.requests:
                self._lines.append(client)
        try:
            act()
        except Exception as error:  # which nobody else would hear of
            self._warn(
                f"a request could not be answered: {type(error).__name__}: {error}"
            )

    def send(self, service: str, asked: Asked, send: Callable[[], object]) -> None:
        """Send an answer, unless its client was surely not reached the last times."""
        client, rival = asked
        with self.lock:
            now = self._clock()
            if client.misses >= MISSES and not client.is_mixed_up:
                if now < max(client.due, self._next_try):
                    return
                self._next_try = now + AGAIN
        self.last = now
        reached = True
        try:
            with suppress(
                exceptions.InvalidHandle
            ):  # the service has ended, and the node with it
                send()
        except Exception as error:
            if not isinstance(
                error.__cause__ or error, RuntimeWarning
            ):  # as which it comes out
                self._warn(
                    f"{service}: an answer could not be sent: {describe_error(error)}"
                )
                return
            reached = False
        with self.lock:
            if rival is not None:
                rival.is_mixed_up = False
                if not reached and rival.misses >= MISSES:  # it was the rival's
                    client.misses = rival.misses
                    rival.misses = 0
            if reached:
                if client.misses >= MISSES:  # the try held up nobody
                    self._next_try = 0.0
                client.misses = 0
                return
            client.misses += 1
            client.due = now + (FIRST if client.misses == MISSES else AGAIN)
            if (
                client.misses < MISSES
                or now - self._warned.get(service, -QUIET) < QUIET
            ):
                return
            self._warned[service] = now
        self._warn(
            f"{service}: an answer could not be delivered: expected a client whose quality "
            "of service fits the node's (reliable, volatile), got one that cannot be "
            "reached; check its quality of service and call again"
        )

    def wait_until_quiet(
        self, pause: float, longest: float, is_busy: Callable[[], bool]
    ) -> None:
        """Let whoever waits be answered, until nobody was for some seconds."""
        begin = self._clock()
        while self._clock() < begin + longest and (
            is_busy() or self._clock() < max(begin, self.last) + pause
        ):
            time.sleep(0.01)

    def close(self, seconds: float) -> None:
        """Answer all that wait, as far as that takes some seconds."""
        with self.lock:
            self._closed = True
        within(seconds, self._pool.shutdown)


class AnsweringNode(nodes.Node):
    """A node that no single client holds up."""

    def __init__(self, name: str, **options: Any) -> None:
        self.answers = Answers(lambda line: self.get_logger().warning(line))
        super().__init__(name, **options)

        def send(
            name: str, send_now: Callable[..., object], response: Any, header: Any
        ) -> None:
            self.answers.send(
                name,
                self.answers.asked(name, header.request_id.sequence_number),
                lambda: send_now(response, header),
            )

        for (
            service
        ) in self.services:  # of parameters and types, which rclpy has made by itself
            service.send_response = partial(
                send, service.srv_name, service.send_response
            )

    def serve(
        self,
        kind: Any,
        name: str,
        callback: Callback,
        may_wait: Callable[[Any], bool] = lambda request: True,
    ) -> None:
        """Make a service that answers in turn, also by a future; `may_wait`: what is not large."""
        service: Any = self.create_service(
            kind,
            name,
            lambda request, response: request,
            qos_profile=SERVICE_QUALITY,
            callback_group=callback_groups.MutuallyExclusiveCallbackGroup(),
        )
        send_now = service.send_response
        answers = self.answers

        def answer(asked: Asked, header: Any, request: Any) -> None:
            coming = answered(
                callback, self.get_logger().error, request, kind.Response()
            )
            coming.add_done_callback(
                lambda done: answers.send(
                    name, asked, lambda: send_now(done.result(), header)
                )
            )

        def sort_all(request: Any, header: Any) -> None:
            """Sort a request and those behind it; one that may not wait is answered now."""
            with answers.lock:
                while header is not None:
                    asked = answers.asked(name, header.request_id.sequence_number)
                    act = partial(answer, asked, header, request)
                    if not (may_wait(request) and answers.put(asked[0], act)):
                        break
                    try:
                        with service.handle:
                            request, header = service.handle.service_take_request(
                                kind.Request
                            )
                    except exceptions.InvalidHandle:  # of a service that has ended
                        return
                else:
                    return
            act()

        service.send_response = sort_all  # what it is given is the request, see above
