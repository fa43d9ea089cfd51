"""Clients answered in turn, and those that hear before those that do not.

A client that sends a thousand requests at once would keep all others waiting, for the middleware
hands them over in the order in which they came. And for a client that the node has not discovered
entirely, or whose quality of service does not fit, `rcl_send_response` waits a tenth of a second
with the interpreter locked before the answer is thrown away.

rclpy does not tell which client a request is from, but a client numbers its requests one after
the other: the request that has the next number is taken for its next one.
"""

import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import NamedTuple

from rclpy.exceptions import InvalidHandle

THREADS = 3  # those that wait for the disk at the same time wait for it together
MOST_WAITING = 2000  # requests; the others are left to the middleware
SORTING_SECONDS = 0.02
"""Between a thread's requests while others are sorted, which has the interpreter meanwhile."""

MOST_NUMBERS, MOST_ALIKE = 1000, 16
"""Numbers by which clients are told apart, and clients of one number; beyond, the last ones."""

PAUSE, AGAIN, MOST_TRIES = 0.3, 10.0, 5
"""Seconds before a client is tried again, and between all such tries; but a few may be made at
once, for clients that are only slow to be discovered."""

MOST_UNSENT, FEW_UNSENT, GIVE_UP = 1000, 20, 30.0
"""Answers kept for a client that was not reached, at first and later, and for how many seconds."""

QUIET = 60.0  # seconds between two warnings of a kind

warnings.filterwarnings("error", message="failed to send response", category=RuntimeWarning)
"""rclpy warns so of each answer that was thrown away, and that is what tells which ones were. Time
would not: on a machine with too much to do an answer that arrives may take as long."""


@dataclass(eq=False)
class Client:
    """Requests to one service that seem to be one client's."""

    service: str
    requests: deque[Callable[[], object]] = field(default_factory=deque)  # that wait
    # answers that did not reach it, and since when they wait
    unsent: deque[tuple[float, Callable[[], object]]] = field(default_factory=deque)
    tries: int = 0  # in vain, since it was reached
    due: float = 0.0  # when it may be tried again, by the monotonic clock

    @property
    def is_deaf(self) -> bool:
        """Whether to send nothing for the time being; once alone, it is only being discovered."""
        return self.tries >= 2

    def keep(self, since: float, send: Callable[[], object]) -> None:
        """Keep an answer; few of them for a client that was tried again and again."""
        self.unsent.append((since, send))
        while len(self.unsent) > (MOST_UNSENT if self.tries < MOST_TRIES else FEW_UNSENT):
            self.unsent.popleft()

    def put_off(self) -> None:
        """Note that it was not reached, and try it again after a while."""
        self.due = time.monotonic() + PAUSE * 3.0**min(self.tries, 10)
        self.tries += 1


class Asked(NamedTuple):
    """Who a request seems to be from; the rival does not hear, and it may be from that one."""

    client: Client
    rival: Client | None


class Answers:
    """Works off requests in threads of its own, the clients in turn, and sends the answers."""

    def __init__(self, warn: Callable[[str], object]) -> None:
        self._warn = warn
        self._by_number: dict[tuple[str, int], list[Client]] = {}  # of their last requests
        self._lines: deque[Client] = deque()  # clients whose requests wait
        self._waiting = self._sorting = 0
        self._unreached: list[Client] = []
        self._tries, self._counted = 0.0, time.monotonic()
        self._warned: dict[str, float] = {}  # when, of each service's clients
        self._closed = False
        self._changed = threading.Condition()
        self._threads: list[threading.Thread] = []
        self.last = 0.0

    def asked(self, service: str, number: int) -> Asked:
        """Tell who has given its request this number; of several clients, one that hears."""
        with self._changed:
            # Of equal ones the last that asked: many at once come one right after the other.
            alike = sorted(self._by_number.pop((service, number - 1), []),
                           key=lambda candidate: -candidate.tries)
            client = alike.pop() if alike else Client(service)
            if alike:
                self._by_number[service, number - 1] = alike
            there = self._by_number.setdefault((service, number), [])
            there.append(client)
            del there[:-MOST_ALIKE]
            if len(self._by_number) > MOST_NUMBERS:
                del self._by_number[next(iter(self._by_number))]
            deaf = (candidate for candidate in alike[::-1] if candidate.is_deaf)
            return Asked(client, None if client.is_deaf else next(deaf, None))

    def has_room(self) -> bool:
        """Whether a further request may wait."""
        with self._changed:
            return self._waiting < MOST_WAITING and not self._closed

    @contextmanager
    def sorting(self) -> Iterator[None]:
        """Answer few requests while others are sorted, so that all are soon in their lines."""
        with self._changed:
            self._sorting += 1
        try:
            yield
        finally:
            with self._changed:
                self._sorting -= 1
                self._changed.notify_all()

    def put(self, client: Client, act: Callable[[], object]) -> None:
        """Have a request answered when it is its client's turn."""
        with self._changed:
            if not client.requests:
                self._lines.append(client)
            client.requests.append(act)
            self._waiting += 1
            self._changed.notify()
            if not self._threads:
                self._threads = [threading.Thread(target=self._run, name="answers", daemon=True)
                                 for _ in range(THREADS)]
                for thread in self._threads:
                    thread.start()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: not self._sorting, SORTING_SECONDS)
                self._changed.wait_for(lambda: self._lines or self._closed)
                if not self._lines:
                    return
                client = self._lines.popleft()
                act = client.requests.popleft()
                self._waiting -= 1
                if client.requests:
                    self._lines.append(client)
            try:
                act()
            except Exception as error:  # must not end the thread
                self._warn(f"a request could not be answered: {type(error).__name__}: {error}")

    def send(self, asked: Asked, send: Callable[[], object]) -> None:
        """Send an answer, or keep it for a client that was not reached the last times."""
        client, rival = asked
        begin = time.monotonic()
        with self._changed:
            if client.is_deaf:
                client.keep(begin, send)
                self._unreached += [] if client in self._unreached else [client]
                return
        if self._reaches(send):
            self._flush(client, send)
            return
        late = []
        with self._changed:
            if rival is not None and rival.is_deaf:  # the request was its, so they change places
                late = [answer for since, answer in rival.unsent if since >= begin]
                client.unsent.extend(answer for answer in rival.unsent if answer[0] < begin)
                client.tries, client.due, rival.tries = rival.tries, rival.due, 0
                rival.unsent.clear()
            else:
                client.put_off()
            client.keep(begin, send)
            self._unreached = [other for other in self._unreached if other not in asked] + [client]
        for answer in late:
            self._reaches(answer)

    def _flush(self, client: Client, sent: Callable[[], object]) -> None:
        """Send what else is kept for a client that was reached."""
        with self._changed:
            waiting = [answer for _, answer in client.unsent if answer is not sent]
            client.unsent.clear()
            client.tries = 0
        for answer in waiting:
            self._reaches(answer)

    def _reaches(self, send: Callable[[], object]) -> bool:
        """Send an answer; whether its client could be reached."""
        self.last = time.monotonic()
        try:
            with suppress(InvalidHandle):  # the service has ended, and the node with it
                send()
        except (RuntimeWarning, SystemError) as error:
            if not isinstance(error.__cause__ or error, RuntimeWarning):  # as which it comes out
                raise
            return False
        return True

    def retry(self) -> None:
        """Try the client that was tried least, if one is due, and give up what is too old."""
        now, lost, client = time.monotonic(), set(), None
        with self._changed:
            for other in self._unreached:
                while other.unsent and other.unsent[0][0] < now - GIVE_UP:
                    other.unsent.popleft()
                    lost.add(other.service)
            self._unreached = [other for other in self._unreached if other.unsent]
            self._tries = max(0.0, self._tries - (now - self._counted) / AGAIN)
            self._counted = now
            if self._tries <= MOST_TRIES - 1:
                client = min((other for other in self._unreached if other.due <= now),
                             key=lambda other: other.tries, default=None)
            if client is not None:
                self._tries += 1.0
                send = client.unsent[-1][1]
        for service in lost:
            if now - self._warned.get(service, -QUIET) >= QUIET:
                self._warned[service] = now
                self._warn(f"{service}: an answer could not be delivered: expected a client "
                           "whose quality of service fits the node's (reliable, volatile), got "
                           "one that cannot be reached; check its quality of service and call "
                           "again")
        if client is not None and self._reaches(send):
            self._flush(client, send)
            self._tries -= 1.0  # it held up nobody
        elif client is not None:
            with self._changed:
                client.put_off()

    def wait_until_quiet(self, pause: float, longest: float) -> None:
        """Let whoever waits be answered, until nobody was for some seconds."""
        begin = time.monotonic()
        while time.monotonic() < min(max(begin, self.last) + pause, begin + longest):
            time.sleep(0.01)

    def close(self, seconds: float) -> bool:
        """Answer all that wait; whether all have been answered within some seconds."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        until = time.monotonic() + seconds
        for thread in self._threads:
            thread.join(max(0.0, until - time.monotonic()))
        return not any(thread.is_alive() for thread in self._threads)
