"""Answers to clients that the node has not discovered entirely yet are sent again."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from rclpy.exceptions import InvalidHandle

from .lost_answers import catch_losses, losses

PAUSES = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8)
"""Seconds before each further attempt: lost packets of discovery are repeated within three."""

REST = 0.4
"""Seconds after a failed attempt, which holds the interpreter for a tenth of a second."""

MOST_WAITING = 50
"""Answers kept for later; a client that will never hear must not use up the node."""

QUIET = 60.0
"""Seconds in which answers of one service that are given up are told of once."""


@dataclass(slots=True)
class Answer:
    """An answer on its way: what it answers, how to send it, and when next."""

    what: str
    send: Callable[[], object]
    due: float
    attempts: int = 0


class LateAnswers:
    """Sends answers, in a thread of its own where the client cannot be reached at once.

    A client may know the node before the node knows the client; its first answer would be
    lost then, and the client would wait for ever.

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
