"""Meshes on their way to become parts, in two lanes: what takes long holds up nothing quick."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError, wait
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

from ...errors import RequestError

T = TypeVar("T")

MOST_WAITING = 64

LAST_SECONDS = 0.5
"""What is in hand may be finished for so long when the queue is closed."""


@dataclass(eq=False)
class _Task:
    work: Callable[[], Any]
    size: int
    future: Future[Any]


class _Lane:
    """Runs tasks one after the other in a thread of its own."""

    def __init__(self, name: str) -> None:
        self.urgent: deque[_Task] = deque()
        self.tasks: deque[_Task] = deque()
        self.later: deque[_Task] = deque()
        self.bytes = 0
        self.closed = False
        self.changed = threading.Condition()
        self._in_hand: _Task | None = None
        self.thread = threading.Thread(target=self._run, name=name, daemon=True)

    def append(self, tasks: deque[_Task], task: _Task) -> None:
        """Take in a task, with `changed` held."""
        if self.closed:
            task.future.cancel()
            return
        self.bytes += task.size
        tasks.append(task)
        self.changed.notify_all()

    def is_full(self, size: int, most_bytes: int) -> bool:
        """Whether a task has to wait; one that is larger than the bound waits alone."""
        return bool(self.tasks) and (len(self.tasks) >= MOST_WAITING
                                     or self.bytes + size > most_bytes)

    def waiting(self) -> int:
        """Tasks that wait."""
        with self.changed:
            return len(self.urgent) + len(self.tasks) + len(self.later)

    def close(self) -> None:
        """Drop what waits."""
        with self.changed:
            self.closed = True
            dropped = [*self.urgent, *self.tasks, *self.later]
            for tasks in (self.urgent, self.tasks, self.later):
                tasks.clear()
            self.changed.notify_all()
        for task in dropped:
            task.future.cancel()

    def ended(self) -> bool:
        """Whether the thread ends soon; if not, nobody waits for what is in hand any more."""
        if self.thread.is_alive():
            self.thread.join(timeout=LAST_SECONDS)
        in_hand = self._in_hand
        if self.thread.is_alive() and in_hand is not None:
            in_hand.future.cancel()
        return not self.thread.is_alive()

    def _run(self) -> None:
        while (task := self._next()) is not None:
            _do(task)
            with self.changed:
                self._in_hand = None
                self.bytes -= task.size
                self.changed.notify_all()

    def _next(self) -> _Task | None:
        with self.changed:
            while not self.closed:
                waiting = self.urgent or self.tasks or self.later
                if waiting:
                    self._in_hand = waiting.popleft()
                    return self._in_hand
                self.changed.wait()
            return None


def _do(task: _Task) -> None:
    """Do a task; what comes of it belongs to whoever asked, if they still wait."""
    try:
        found = task.work()
    except BaseException as error:
        with suppress(InvalidStateError):
            task.future.set_exception(error)
        return
    with suppress(InvalidStateError):  # the queue was closed just now
        task.future.set_result(found)


class MeshQueue:
    """A quick lane and a slow one.

    Large meshes take the slow lane, and so does what comes under the name of one that has not
    been done yet: of two meshes of one name the later one is done last.

    Parameters
    ----------
    most_bytes : callable
        How many bytes may wait in each lane; a task larger than that waits alone.
    """

    def __init__(self, most_bytes: Callable[[], int]) -> None:
        self._most_bytes = most_bytes
        self._quick, self._slow = _Lane("queue"), _Lane("slow queue")
        self._last: dict[tuple[_Lane, str], Future[Any]] = {}
        self._names = threading.Lock()

    def start(self) -> None:
        """Begin to work."""
        for lane in (self._quick, self._slow):
            lane.thread.start()

    def put(self, work: Callable[[], T], size: int, part_id: str = "",
            large: bool = False) -> Future[T]:
        """Queue a task; waits while the quick lane is full.

        Parameters
        ----------
        work : callable
        size : int
            Bytes that it holds on to.
        part_id : str
            Tasks of one name are done in their order.
        large : bool
            Whether it takes long.

        Returns
        -------
        Future
            Of what `work` returns or raises; cancelled where the queue is closed, and refused
            where the slow lane is full: to wait for that would hold up small meshes.
        """
        lane, task = self._task(work, size, part_id, large)
        try:
            with lane.changed:
                while lane is self._quick and not lane.closed and (
                        lane.is_full(size, self._most_bytes())):
                    lane.changed.wait()
                if lane is self._slow and lane.is_full(size, self._most_bytes()):
                    raise RequestError(
                        f"at most {MOST_WAITING} large meshes of {self._most_bytes()} bytes in "
                        f"all waiting", "more", "publish it again once they are done")
                lane.append(lane.tasks, task)
        except RequestError as refusal:
            task.future.set_exception(refusal)
        return task.future

    def put_first(self, work: Callable[[], T], size: int = 0, part_id: str = "",
                  large: bool = False) -> Future[T]:
        """Queue a task that a client waits for, before the others; never waits itself.

        Raises
        ------
        RequestError
            If too many wait.
        """
        lane, task = self._task(work, size, part_id, large)
        with lane.changed:
            full = len(lane.urgent) >= MOST_WAITING
            if not full:
                lane.append(lane.urgent, task)
        if full:
            task.future.cancel()
            raise RequestError(f"at most {MOST_WAITING} meshes of requests waiting",
                               "as many", "ask again in a moment")
        return task.future

    def put_later(self, work: Callable[[], T], large: bool = False) -> Future[T]:
        """Queue a task that holds on to little for when nothing else waits; never waits."""
        lane = self._slow if large else self._quick
        task = _Task(work, 0, Future())
        with lane.changed:
            lane.append(lane.later, task)
        return task.future

    def _task(self, work: Callable[[], T], size: int, part_id: str,
              large: bool) -> tuple[_Lane, _Task]:
        """A task, and the lane that it has to take."""
        future: Future[Any] = Future()
        with self._names:
            slow = large or (self._slow, part_id) in self._last
            lane = self._slow if slow else self._quick
            before = self._last.get((self._quick, part_id)) if slow else None
            if part_id:
                self._last[lane, part_id] = future
        if part_id:
            future.add_done_callback(lambda done: self._forget(lane, part_id, done))
        if before is None:
            return lane, _Task(work, size, future)

        def work_after() -> T:
            wait([before])  # of the quick lane, which never waits for the slow one
            return work()

        return lane, _Task(work_after, size, future)

    def _forget(self, lane: _Lane, part_id: str, done: Future[Any]) -> None:
        with self._names:
            if self._last.get((lane, part_id)) is done:
                del self._last[lane, part_id]

    def waiting(self) -> int:
        """Tasks that wait."""
        return self._quick.waiting() + self._slow.waiting()

    def close(self) -> bool:
        """Drop what waits, finish what is in hand if that is soon done.

        Returns
        -------
        bool
            Whether nothing is computed any more.
        """
        for lane in (self._quick, self._slow):
            lane.close()
        quick_ended, slow_ended = self._quick.ended(), self._slow.ended()
        return quick_ended and slow_ended
