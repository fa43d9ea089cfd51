"""Answers to clients that the node has not discovered entirely yet are sent again.

A client may know the node before the node knows the client. `rcl_send_response` then returns
`RCL_RET_TIMEOUT`, of which rclpy (7.1.6; its pull request 1136) makes the warning "failed to send
response" and throws the answer away, and the client waits for ever. All of this file is for that
defect. Once rclpy itself delivers such answers, or tells its caller of them, the file can go:
`PatientNode` becomes `Node` again, and `PatientActionServer` becomes `ActionServer`.
"""

from __future__ import annotations

import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rclpy.action import ActionServer
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.service import Service

from .turns import Turns

PAUSES = (0.1, 0.4, 1.6, 5.0)
"""Seconds before each further attempt to reach a client, the last one again and again.

Lost packets of discovery are repeated within three seconds. An attempt in vain holds the
interpreter for a tenth of a second.
"""

GIVE_UP = 25.0
"""Seconds after which an answer is given up."""

FORGET = 20.0
"""Seconds after its last request in which a client is remembered as one that does not hear."""

MOST_CLIENTS = 50
"""Clients that are followed; a further one takes the place of the oldest."""

MOST_WAITING = 50
"""Answers kept for one client; a further one takes the place of the oldest."""

QUIET = 60.0
"""Seconds in which answers of one service that are given up are told of once."""

UNDELIVERED = "failed to send response"
"""How the warning begins."""

# `showwarning` would be the public place, but is put back for the whole process whenever any
# thread catches warnings, as numba does while it compiles.
_machinery: Any = warnings
_of_thread = threading.local()
_show_others = _machinery._showwarnmsg


def _show(warning: warnings.WarningMessage) -> None:
    lost: list[str] | None = getattr(_of_thread, "lost", None)
    if lost is not None and str(warning.message).startswith(UNDELIVERED):
        lost.append(str(warning.message))
    else:
        _show_others(warning)


def catch_losses() -> None:
    """Have `losses` catch what would otherwise be shown on standard error, once a line."""
    global _show_others
    if _machinery._showwarnmsg is not _show:
        _show_others, _machinery._showwarnmsg = _machinery._showwarnmsg, _show
    warnings.filterwarnings("always", message=UNDELIVERED, category=RuntimeWarning)


@contextmanager
def losses() -> Iterator[list[str]]:
    """What rclpy says of answers that this thread sends meanwhile and that are thrown away."""
    catch_losses()  # another thread that catches warnings may have taken the filter away
    outer = getattr(_of_thread, "lost", None)
    lost: list[str] = []
    _of_thread.lost = lost
    try:
        yield lost
    finally:
        _of_thread.lost = outer


@dataclass(slots=True, eq=False)
class Answer:
    """An answer that waits: how to send it, since when, and how often that was in vain."""

    send: Callable[[], object]
    since: float
    attempts: int = 0


@dataclass(slots=True, eq=False)
class UnreachedClient:
    """A client that answers do not reach, and what waits for it.

    rclpy does not tell which client a request is from. But a client numbers its requests one
    after the other, so the request that has the next number is taken for its next one. Where
    that is wrong, somebody else's answer waits until the next attempt.
    """

    service: str
    next_number: int  # of its next request
    asked: float  # when it last asked and when it is tried again, by the monotonic clock
    due: float = 0.0
    attempts: int = 0  # since an answer has arrived
    answers: list[Answer] = field(default_factory=list)  # oldest first

    def wait_longer(self) -> None:
        """Put off the next attempt after one in vain."""
        self.due = time.monotonic() + PAUSES[min(self.attempts, len(PAUSES) - 1)]
        self.attempts += 1


class LateAnswers:
    """Sends answers, in a thread of its own where the client cannot be reached at once.

    A client that never hears costs an attempt every few seconds, however often it asks.

    `say`: told in one line of answers that are given up.
    """

    def __init__(self, say: Callable[[str], object]) -> None:
        self._say = say
        self._said: dict[str, float] = {}
        self._clients: list[UnreachedClient] = []
        self._news = threading.Condition()
        self._thread: threading.Thread | None = None
        self._closed = False
        catch_losses()

    def send(self, service: str, number: int, send: Callable[[], object]) -> None:
        """Send an answer now, or else later.

        `number`: that the client gave its request.
        """
        client = self._unreached(service, number)
        if client is None or time.monotonic() >= client.due:
            with losses() as lost:
                send()
            if not lost:
                return
        self.send_later(service, number, send, client)

    def send_later(self, service: str, number: int, send: Callable[[], object],
                   client: UnreachedClient | None = None) -> None:
        """Send an answer that could not be delivered just now."""
        now = time.monotonic()
        client = client or UnreachedClient(service, number + 1, now)
        with self._news:
            if self._closed:
                return
            if client not in self._clients:
                self._clients = [*self._clients[-MOST_CLIENTS + 1:], client]
            if now >= client.due:
                client.wait_longer()
            client.answers = [*client.answers[-MOST_WAITING + 1:], Answer(send, now)]
            self._news.notify()
            if self._thread is None or not self._thread.is_alive():
                self._thread = threading.Thread(target=self._run, name="late answers",
                                                daemon=True)
                self._thread.start()

    def _unreached(self, service: str, number: int) -> UnreachedClient | None:
        """The client that a request seems to be from, if answers have not reached it."""
        now = time.monotonic()
        with self._news:
            self._clients = [one for one in self._clients
                             if one.answers or now - one.asked < FORGET]
            for client in self._clients:
                if (client.service, client.next_number) == (service, number):
                    client.next_number, client.asked = number + 1, now
                    return client
        return None

    def close(self) -> None:
        """Give up what still waits."""
        with self._news:
            self._closed = True
            self._clients.clear()
            self._news.notify()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        while (client := self._next()) is not None:
            while (answer := self._least_tried(client)) is not None:
                if self._is_lost(client.service, answer):
                    client.wait_longer()
                    break
                self._remove(client, answer)

    def _next(self) -> UnreachedClient | None:
        """Wait for the client whose turn is next; none once all is closed."""
        with self._news:
            while not self._closed:
                client = min((one for one in self._clients if one.answers),
                             key=lambda one: one.due, default=None)
                left = None if client is None else client.due - time.monotonic()
                if client is not None and left is not None and left <= 0.0:
                    return client
                self._news.wait(left)
        return None

    def _least_tried(self, client: UnreachedClient) -> Answer | None:
        """The answer of a client to try now, once those that are too old are given up.

        The newest of those that were tried least: it may be somebody else's after all.
        """
        with self._news:
            latest = time.monotonic() - GIVE_UP
            fresh = [one for one in client.answers if one.since > latest]
            given_up = len(client.answers) - len(fresh)
            client.answers = fresh
        if given_up:
            self._give_up(client.service)
        return min(reversed(fresh), key=lambda one: one.attempts, default=None)

    def _remove(self, client: UnreachedClient, answer: Answer) -> None:
        """Note that an answer needs no further attempt; with the last one the client hears."""
        with self._news:
            client.attempts = 0
            client.answers = [one for one in client.answers if one is not answer]
            if not client.answers and client in self._clients:
                self._clients.remove(client)

    def _is_lost(self, service: str, answer: Answer) -> bool:
        """Send once more; whether that was in vain."""
        answer.attempts += 1
        try:
            with losses() as lost:
                answer.send()
        except InvalidHandle:  # the service has ended, and the node with it
            return False
        except Exception as error:  # must not end the thread that the others wait for
            self._say(f"{service}: the answer could not be sent: {error}")
            return False
        return bool(lost)

    def _give_up(self, service: str) -> None:
        now = time.monotonic()
        if now < self._said.get(service, now):
            return
        self._said[service] = now + QUIET
        self._say(f"{service}: an answer could not be delivered: expected a client whose quality "
                  f"of service fits the node's (reliable, volatile), got one that cannot be "
                  f"reached; check its quality of service and call again")


def number_of(header: Any) -> int:
    """What a client numbered its request; services and actions have headers of their own."""
    number: int = getattr(header, "request_id", header).sequence_number
    return number


class PatientNode(Node):
    """A node all of whose services, those for parameters too, send lost answers again.

    Attributes `turns`: of the clients of services that answer in turn.
    """

    def __init__(self, name: str, **options: Any) -> None:
        self.late_answers = LateAnswers(lambda line: self.get_logger().warning(line))
        self.turns = Turns(lambda line: self.get_logger().error(line))
        self._last_answer = 0.0
        super().__init__(name, **options)

    def create_service(self, kind: Any, name: str, callback: Callable[..., Any], *,
                       in_turn: Callable[[Any], bool] | None = None, **options: Any) -> Service:
        """Make a service whose answers reach clients that are still being discovered.

        `kind, name, callback, **options`: as rclpy takes them; the callback may also return a
        `concurrent.futures.Future` of its answer; `in_turn`: whether a request may wait for its
        client's turn; it must hold on to little.
        """
        service: Service = super().create_service(
            kind, name, callback if in_turn is None else _Taken, **options)
        send = service.send_response

        def send_now(response: Any, header: Any) -> None:
            self._last_answer = time.monotonic()
            self.late_answers.send(service.srv_name, number_of(header),
                                   partial(send, response, header))

        def send_response(response: Any, header: Any) -> None:
            if isinstance(response, Future):  # no thread waits until the answer is there
                response.add_done_callback(lambda done: send_now(done.result(), header))
            else:
                send_now(response, header)

        def answer(request: Any, header: Any) -> None:
            send_response(callback(request, kind.Response()), header)

        def take_turns(taken: _Taken, header: Any) -> None:
            """Put a request that the executor took, and all that wait behind it."""
            request: Any = taken.request
            while header is not None:
                if in_turn is not None and in_turn(request) and self.turns.has_room():
                    self.turns.put(number_of(header), partial(answer, request, header))
                else:
                    answer(request, header)
                try:
                    with service.handle:
                        request, header = service.handle.service_take_request(kind.Request)
                except InvalidHandle:  # the service has ended, and the node with it
                    return

        service.send_response = send_response if in_turn is None else take_turns
        return service


    def wait_until_quiet(self, pause: float, longest: float) -> None:
        """Let whoever waits be answered, until nobody was for some seconds."""
        begin = time.monotonic()
        while time.monotonic() < min(max(begin, self._last_answer) + pause, begin + longest):
            time.sleep(0.01)


@dataclass(slots=True, eq=False)
class _Taken:
    """A request that waits for its turn, in place of its answer."""

    request: Any
    response: Any


class PatientActionServer(ActionServer):
    """Sends lost answers to goals, to cancels and to requests for results again."""

    def __init__(self, node: PatientNode, action_type: Any, action_name: str,
                 *arguments: Any, **options: Any) -> None:
        self.late_answers = node.late_answers
        self.action_name = action_name
        super().__init__(node, action_type, action_name, *arguments, **options)

    async def _execute_goal_request(self, request_header_and_message: Any) -> None:
        """Accept or reject a goal as rclpy does, and see whether the client was told.

        The handle of a goal is made of the server's own, so no stand-in will do here.
        """
        header, request = request_header_and_message
        goal = bytes(request.goal_id.uuid)
        known = goal in self._goal_handles
        with losses() as lost:  # of this thread, in which all of it runs: no callback waits
            await super()._execute_goal_request(request_header_and_message)
        if not lost:
            return
        answer = self._action_type.Impl.SendGoalService.Response()
        accepted = None if known else self._goal_handles.get(goal)
        if accepted is not None:
            answer.accepted, answer.stamp = True, accepted._goal_info.stamp
        self.late_answers.send_later(
            f"{self.action_name}/_action/send_goal", number_of(header),
            partial(self._handle.send_goal_response, header, answer))

    async def _execute_cancel_request(self, request_header_and_message: Any) -> None:
        await ActionServer._execute_cancel_request(self._patient(), request_header_and_message)

    async def _execute_get_result_request(self, request_header_and_message: Any) -> None:
        await ActionServer._execute_get_result_request(self._patient(),
                                                       request_header_and_message)

    def _patient(self) -> Any:
        """The server, but that its answers to cancels and requests for results are sent again."""
        handle: Any = _StandIn(self._handle)
        patient: Any = _StandIn(self)
        handle.send_cancel_response = partial(
            self._send, "cancel_goal", self._handle.send_cancel_response)
        handle.send_result_response = partial(
            self._send, "get_result", self._handle.send_result_response)
        patient._handle = handle
        patient._send_result_response = partial(ActionServer._send_result_response, patient)
        return patient

    def _send(self, what: str, send: Callable[[Any, Any], object], header: Any,
              answer: Any) -> None:
        self.late_answers.send(f"{self.action_name}/_action/{what}", number_of(header),
                               partial(send, header, answer))


class _StandIn:
    """Stands in for another object, of which it has all attributes but those set on itself."""

    def __init__(self, other: Any) -> None:
        self._other = other

    def __getattr__(self, name: str) -> Any:
        return getattr(self._other, name)
