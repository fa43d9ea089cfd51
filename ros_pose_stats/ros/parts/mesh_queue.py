"""A bounded queue of meshes on their way to become parts, and the thread that works it off."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Generic, TypeVar

from ...errors import RequestError

T = TypeVar("T")

MOST_WAITING = 64


@dataclass(eq=False)
class _Task(Generic[T]):
    work: Callable[[], T]
    size: int
    future: Future[T]


class MeshQueue:
    """Runs tasks one after the other in a thread of its own.

    Parameters
    ----------
    most_bytes : callable
        How many bytes may wait; a task larger than that waits alone.
    """

    def __init__(self, most_bytes: Callable[[], int]) -> None:
        self._most_bytes = most_bytes
        self._tasks: deque[_Task[object]] = deque()
        self._urgent: deque[_Task[object]] = deque()
        self._later: deque[_Task[object]] = deque()
        self._all = self._urgent, self._tasks, self._later
        self._bytes = 0
        self._changed = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="queue", daemon=True)

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    def put(self, work: Callable[[], T], size: int) -> Future[T]:
        """Queue a task; waits while the queue is full.

        Parameters
        ----------
        work : callable
        size : int
            Bytes that it holds on to.

        Returns
        -------
        Future
            Of what `work` returns or raises; cancelled where the queue is closed.
        """
        task = _Task(work, size, Future())
        with self._changed:
            while not self._closed and self._full(size):
                self._changed.wait()
            self._append(self._tasks, task)
        return task.future

    def put_first(self, work: Callable[[], T]) -> Future[T]:
        """Queue a task that a client waits for, before the others; never waits itself.

        Raises
        ------
        RequestError
            If too many wait.
        """
        task = _Task(work, 0, Future())
        with self._changed:
            if len(self._urgent) >= MOST_WAITING:
                raise RequestError(f"at most {MOST_WAITING} meshes of requests waiting",
                                   "as many", "ask again in a moment")
            self._append(self._urgent, task)
        return task.future

    def put_later(self, work: Callable[[], T]) -> Future[T]:
        """Queue a small task for when nothing else waits; never waits itself."""
        task = _Task(work, 0, Future())
        with self._changed:
            self._append(self._later, task)
        return task.future

    def _append(self, tasks: deque[_Task[object]], task: _Task[T]) -> None:
        if self._closed:
            task.future.cancel()
            return
        self._bytes += task.size
        tasks.append(task)  # type: ignore[arg-type]
        self._changed.notify_all()

    def _full(self, size: int) -> bool:
        return bool(self._tasks) and (len(self._tasks) >= MOST_WAITING
                                      or self._bytes + size > self._most_bytes())

    def waiting(self) -> int:
        """Tasks that wait."""
        with self._changed:
            return sum(map(len, self._all))

    def close(self) -> None:
        """Finish the task in hand and drop the others."""
        with self._changed:
            self._closed = True
            dropped = [task for tasks in self._all for task in tasks]
            for tasks in self._all:
                tasks.clear()
            self._changed.notify_all()
        for task in dropped:
            task.future.cancel()
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while (task := self._next()) is not None:
            try:
                task.future.set_result(task.work())
            except BaseException as error:  # belongs to whoever asked
                task.future.set_exception(error)
            finally:
                with self._changed:
                    self._bytes -= task.size
                    self._changed.notify_all()

    def _next(self) -> _Task[object] | None:
        with self._changed:
            while not self._closed:
                waiting = self._urgent or self._tasks or self._later
                if waiting:
                    return waiting.popleft()
                self._changed.wait()
            return None
