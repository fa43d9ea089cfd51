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
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.action import ActionServer
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.service import Service

PAUSES = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8)
"""Seconds before each further attempt: lost packets of discovery are repeated within three."""

REST = 0.4
"""Seconds after a failed attempt, which holds the interpreter for a tenth of a second."""

MOST_WAITING = 50
"""Answers kept for later; a client that will never hear must not use up the node."""

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


@dataclass(slots=True)
class Answer:
    """An answer on its way: what it answers, how to send it, and when next."""

    what: str
    send: Callable[[], object]
    due: float
    attempts: int = 0


class LateAnswers:
    """Sends answers, in a thread of its own where the client cannot be reached at once.

    Parameters
    ----------
    say : callable
        Told in one line of an answer that is given up.
    """

    def __init__(self, say: Callable[[str], object]) -> None:
        self._say = say
        self._said: dict[str, float] = {}
        self._waiting: list[Answer] = []
        self._news = threading.Condition()
        self._thread: threading.Thread | None = None
        self._closed = False
        catch_losses()

    def send(self, what: str, send: Callable[[], object]) -> None:
        """Send an answer now, or else later."""
        with losses() as lost:
            send()
        if lost:
            self.send_later(what, send)

    def send_later(self, what: str, send: Callable[[], object]) -> None:
        """Send an answer that could not be delivered just now."""
        with self._news:
            if self._closed:
                return
            out = self._make_room()
            self._waiting.append(Answer(what, send, time.monotonic() + PAUSES[0]))
            self._news.notify()
            if self._thread is None or not self._thread.is_alive():
                self._thread = threading.Thread(target=self._run, name="late answers",
                                                daemon=True)
                self._thread.start()
        if out is not None:
            self._give_up(out.what)

    def _make_room(self) -> Answer | None:
        """Drop the answer that has been tried most often, if too many wait."""
        if len(self._waiting) < MOST_WAITING:
            return None
        out = max(self._waiting, key=lambda answer: answer.attempts)
        self._waiting.remove(out)
        return out

    def close(self) -> None:
        """Give up what still waits."""
        with self._news:
            self._closed = True
            self._waiting.clear()
            self._news.notify()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        while (answer := self._next()) is not None:
            if not self._attempt(answer):
                with self._news:
                    self._news.wait_for(lambda: self._closed, REST)

    def _next(self) -> Answer | None:
        """Wait for the answer that is due first; none once all is closed."""
        with self._news:
            while not self._closed:
                first = min(self._waiting, key=lambda answer: answer.due, default=None)
                left = None if first is None else first.due - time.monotonic()
                if first is not None and left is not None and left <= 0:
                    self._waiting.remove(first)
                    return first
                self._news.wait(left)
        return None

    def _attempt(self, answer: Answer) -> bool:
        """Send once more; False if that was in vain."""
        try:
            with losses() as lost:
                answer.send()
        except InvalidHandle:  # the service has ended, and the node with it
            return True
        except Exception as error:  # must not end the thread that the others wait for
            self._say(f"{answer.what}: the answer could not be sent: {error}")
            return True
        if not lost:
            return True
        answer.attempts += 1
        if answer.attempts == len(PAUSES):
            self._give_up(answer.what)
        else:
            answer.due = time.monotonic() + PAUSES[answer.attempts]
            with self._news:
                if not self._closed:
                    self._waiting.append(answer)
        return False

    def _give_up(self, what: str) -> None:
        now = time.monotonic()
        if now < self._said.get(what, now):
            return
        self._said[what] = now + QUIET
        self._say(f"{what}: an answer could not be delivered: expected a client whose quality of "
                  f"service fits the node's (reliable, volatile), got one that cannot be reached; "
                  f"check its quality of service and call again")


class PatientNode(Node):
    """A node all of whose services, those for parameters too, send lost answers again.

    Attributes
    ----------
    late_answers : LateAnswers
    """

    def __init__(self, name: str, **options: Any) -> None:
        self.late_answers = LateAnswers(lambda line: self.get_logger().warning(line))
        super().__init__(name, **options)

    def create_service(self, *arguments: Any, **options: Any) -> Service:
        """Make a service whose answers reach clients that are still being discovered."""
        service = super().create_service(*arguments, **options)
        send = service.send_response
        service.send_response = lambda response, header: self.late_answers.send(
            service.srv_name, partial(send, response, header))
        return service


class PatientActionServer(ActionServer):
    """Sends lost answers to goals, to cancels and to requests for results again.

    Parameters
    ----------
    node : PatientNode
    action_type : type
    action_name : str
    *arguments, **options
        Of rclpy's `ActionServer`.
    """

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
            self.action_name, partial(self._handle.send_goal_response, header, answer))

    async def _execute_cancel_request(self, request_header_and_message: Any) -> None:
        await ActionServer._execute_cancel_request(self._patient(), request_header_and_message)

    async def _execute_get_result_request(self, request_header_and_message: Any) -> None:
        await ActionServer._execute_get_result_request(self._patient(),
                                                       request_header_and_message)

    def _patient(self) -> Any:
        """The server, but that its answers to cancels and requests for results are sent again."""
        handle: Any = _StandIn(self._handle)
        patient: Any = _StandIn(self)
        handle.send_cancel_response = partial(self._send, self._handle.send_cancel_response)
        handle.send_result_response = partial(self._send, self._handle.send_result_response)
        patient._handle = handle
        patient._send_result_response = partial(ActionServer._send_result_response, patient)
        return patient

    def _send(self, send: Callable[[Any, Any], object], header: Any, answer: Any) -> None:
        self.late_answers.send(self.action_name, partial(send, header, answer))


class _StandIn:
    """Stands in for another object, of which it has all attributes but those set on itself."""

    def __init__(self, other: Any) -> None:
        self._other = other

    def __getattr__(self, name: str) -> Any:
        return getattr(self._other, name)
