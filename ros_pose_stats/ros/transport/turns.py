"""Requests of several clients are answered in turn, however many one of them has sent.

The middleware hands requests over in the order in which they came, so a client that sends a
thousand at once would keep all others waiting. They are therefore taken from it at once, sorted
by client, and worked off by a few threads. rclpy does not tell which client a request is from,
but a client numbers its requests one after the other: a request that has the next number is
taken for its next one. Where that is wrong, somebody waits as long as without turns.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

MOST_WAITING = 2000
"""Requests; the others are left to the middleware."""

THREADS = 3
"""Those that wait for the disk at the same time wait for it together."""


class _Line:
    """Requests that seem to be one client's."""

    def __init__(self) -> None:
        self.acts: deque[Callable[[], object]] = deque()
        self.next_number = 0


class Turns:
    """Works off requests in threads of its own, one of each client at a time.

    `say`: told in one line of requests that fail.
    """

    def __init__(self, say: Callable[[str], object]) -> None:
        self._say = say
        self._lines: deque[_Line] = deque()
        self._by_number: dict[int, _Line] = {}
        self._waiting = 0
        self._closed = False
        self._changed = threading.Condition()
        self._threads: list[threading.Thread] = []

    def has_room(self) -> bool:
        """Whether a further request may be put."""
        with self._changed:
            return self._waiting < MOST_WAITING and not self._closed

    def put(self, number: int, act: Callable[[], object]) -> None:
        """Have a request answered when it is its client's turn.

        `number`: that the client gave its request.
        """
        with self._changed:
            line = self._by_number.pop(number, None)
            if line is None:
                line = _Line()
            if not line.acts:
                self._lines.append(line)
            line.acts.append(act)
            line.next_number = number + 1
            self._by_number[number + 1] = line
            self._waiting += 1
            self._changed.notify()
            if not self._threads:
                self._threads = [threading.Thread(target=self._run, name="turns", daemon=True)
                                 for _ in range(THREADS)]
                for thread in self._threads:
                    thread.start()

    def close(self, seconds: float) -> bool:
        """Answer all that wait, which is quick once nothing is computed for them.

        Returns whether all have been answered within some seconds.
        """
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        for thread in self._threads:
            thread.join(seconds)
        return not any(thread.is_alive() for thread in self._threads)

    def _run(self) -> None:
        while (act := self._next()) is not None:
            try:
                act()
            except Exception as error:  # must not end the thread
                self._say(f"a request could not be answered: {type(error).__name__}: {error}")

    def _next(self) -> Callable[[], object] | None:
        """The next request of the client whose turn it is; none once all is closed."""
        with self._changed:
            while not self._lines:
                if self._closed:
                    return None
                self._changed.wait()
            line = self._lines.popleft()
            act = line.acts.popleft()
            self._waiting -= 1
            if line.acts:
                self._lines.append(line)
            elif self._by_number.get(line.next_number) is line:
                del self._by_number[line.next_number]
            return act
