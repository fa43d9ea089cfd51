"""Meshes on their way to become parts, in two lanes: what takes long holds up nothing quick."""

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, TypeVar

from ...errors import RequestError
from ...mesh.overlap import TakesLongError

T = TypeVar("T")

MOST_WAITING = 64

ROOM = 4
"""All meshes that wait or are in hand share so many times `max_mesh_bytes`.

The large ones take half of that at most, so that there is always room for small ones.
"""

LAST_SECONDS = 0.5  # what is in hand may be finished for so long when the queue is closed


class Lane(IntEnum):
    """Where a task waits."""

    QUICK = 0  # done in the node, in moments
    SLOW = 1  # it may take all the time that a mesh may take, in another process


class Rank(IntEnum):
    """What goes first in a lane."""

    URGENT = 0
    MESH = 1
    LATER = 2


@dataclass(eq=False)
class _Task:
    work: Callable[[], Any]
    size: int  # bytes that it holds on to
    part_id: str  # empty: of no name
    large: bool
    rank: Rank
    future: Future[Any] = field(default_factory=Future)  # of what comes of it
    lane: Lane = Lane.QUICK  # in which it waits

    def do(self) -> bool:
        """Do it for whoever asked; false where it needs more time than the quick lane has."""
        with suppress(InvalidStateError):  # the queue was closed just now
            try:
                self.future.set_result(self.work())
            except BaseException as error:
                if isinstance(error, TakesLongError) and self.lane is Lane.QUICK:
                    return False
                self.future.set_exception(error)
        return True


class MeshQueue:
    """Two lanes, each with a thread of its own.

    What is large, takes long or comes under the name of a mesh in the slow lane goes there: of two
    meshes of one name the later one is done last. `most_bytes`: of a single mesh.
    """

    def __init__(self, most_bytes: Callable[[], int]) -> None:
        self._most_bytes = most_bytes
        self._lanes = {lane: tuple(deque[_Task]() for _ in Rank) for lane in Lane}
        self._in_hand: dict[Lane, _Task | None] = dict.fromkeys(Lane)
        self._threads = {lane: threading.Thread(target=self._run, args=(lane,), daemon=True,
                                                name=f"{lane.name.lower()} lane")
                         for lane in Lane}
        self._names: dict[str, list[_Task]] = {}
        self._bytes = {False: 0, True: 0}  # of small and of large meshes
        self._closed = False
        self._changed = threading.Condition()

    def start(self) -> None:
        """Begin to work."""
        for thread in self._threads.values():
            thread.start()

    def is_quick(self) -> bool:
        """Whether this is called in the quick lane; elsewhere there is all the time."""
        return threading.current_thread() is self._threads[Lane.QUICK]

    def put(self, work: Callable[[], T], size: int, part_id: str = "",
            large: bool = False) -> Future[T]:
        """Queue a task; waits while the quick lane is full, and is refused where the slow one is.

        `work`: may raise `TakesLongError`, and is called again in the slow lane then; `size`:
        bytes that it holds on to; `part_id`: tasks of one name are done in their order.
        """
        task = _Task(work, size, part_id, large, Rank.MESH)
        with self._changed:
            while (problem := self._lack_of_room(task)) is not None:
                if self._entry(task) is Lane.SLOW:
                    task.future.set_exception(problem)
                    return task.future
                self._changed.wait()
            self._append(task)
        return task.future

    def put_first(self, work: Callable[[], T], size: int = 0, part_id: str = "",
                  large: bool = False) -> Future[T]:
        """Queue a task before the others, at once; raises RequestError if there is no room."""
        task = _Task(work, size, part_id, large, Rank.URGENT)
        with self._changed:
            self._refuse_without_room(task)
            self._append(task)
        return task.future

    def check_room(self, size: int, part_id: str = "", large: bool = False) -> None:
        """Refuse what `put_first` would refuse; raises RequestError if there is no room for it."""
        with self._changed:
            self._refuse_without_room(_Task(lambda: None, size, part_id, large, Rank.URGENT))

    def _refuse_without_room(self, task: _Task) -> None:
        problem = self._lack_of_room(task)
        if problem is not None:
            raise problem

    def put_later(self, work: Callable[[], T], large: bool = False) -> Future[T]:
        """Queue a task that holds on to little for when nothing else waits; never waits."""
        task = _Task(work, 0, "", large, Rank.LATER)
        with self._changed:
            self._append(task)
        return task.future

    def _entry(self, task: _Task) -> Lane:
        """The lane of a task, as large as it is and behind those of its name."""
        others = self._names.get(task.part_id, [])
        before = others[:others.index(task)] if task in others else others
        slow = task.large or any(other.lane is Lane.SLOW for other in before)
        return Lane.SLOW if slow else Lane.QUICK

    def _lack_of_room(self, task: _Task) -> RequestError | None:
        """Why a task cannot be taken in now; one that is larger than the bound waits alone."""
        if self._closed:
            return None
        waiting = len(self._lanes[self._entry(task)][task.rank])
        if waiting >= MOST_WAITING:
            return RequestError(f"at most {MOST_WAITING} meshes of a kind waiting", f"{waiting}",
                                "send it again in a moment")
        room = ROOM * self._most_bytes()
        for most, held in ((room, sum(self._bytes.values())),
                           *(((room // 2, self._bytes[True]),) if task.large else ())):
            if held and held + task.size > most:
                return RequestError(
                    f"at most {most} bytes of {'large ' * (most < room)}meshes waiting "
                    f"({most // self._most_bytes()} times max_mesh_bytes)",
                    f"{task.size} bytes more than the {held} that wait",
                    "send it again once they are done, or decimate it")
        return None

    def _append(self, task: _Task) -> None:
        if self._closed:
            task.future.cancel()
            return
        if task.part_id:
            self._names.setdefault(task.part_id, []).append(task)
        self._bytes[task.large] += task.size
        self._wait_in(self._entry(task), task)

    def _wait_in(self, lane: Lane, task: _Task) -> None:
        task.lane = lane
        self._lanes[lane][task.rank].append(task)
        self._changed.notify_all()

    def _remove(self, task: _Task) -> None:
        self._bytes[task.large] -= task.size
        others = self._names.get(task.part_id, [])
        if task in others:
            others.remove(task)
            if not others:
                del self._names[task.part_id]
        self._changed.notify_all()

    def _run(self, lane: Lane) -> None:
        while self._do_next(lane):  # and let go of it
            pass

    def _do_next(self, lane: Lane) -> bool:
        task = self._next(lane)
        if task is None:
            return False
        done = task.do()
        with self._changed:
            self._in_hand[lane] = None
            dropped = self._closed and not done
            if done or dropped:
                self._remove(task)
            else:  # it takes long
                self._bytes[False] -= task.size
                self._bytes[True] += task.size
                task.large = True
                self._wait_in(Lane.SLOW, task)
        if dropped:
            task.future.cancel()
        return True

    def _next(self, lane: Lane) -> _Task | None:
        """The next task that is to be done in a lane; none once the queue is closed."""
        with self._changed:
            while not self._closed:
                task = next((tasks.popleft() for tasks in self._lanes[lane] if tasks), None)
                if task is None:
                    self._changed.wait()
                elif self._entry(task) is Lane.SLOW and lane is Lane.QUICK:
                    self._wait_in(Lane.SLOW, task)
                else:
                    self._in_hand[lane] = task
                    return task
            return None

    def waiting(self) -> int:
        """Tasks that wait."""
        with self._changed:
            return sum(len(tasks) for lane in self._lanes.values() for tasks in lane)

    def is_quiet(self) -> bool:
        """Whether nothing waits that is soon done."""
        with self._changed:
            return not any(self._lanes[Lane.QUICK])

    def close(self) -> bool:
        """Drop what waits, finish what soon is; whether nothing is computed any more."""
        with self._changed:
            self._closed = True
            waiting = [tasks for ranks in self._lanes.values() for tasks in ranks]
            dropped = [task for tasks in waiting for task in tasks]
            for tasks in waiting:
                tasks.clear()
            self._changed.notify_all()
        for task in dropped:
            task.future.cancel()
        for lane, thread in self._threads.items():
            if thread.is_alive():
                thread.join(timeout=LAST_SECONDS)
            in_hand = self._in_hand[lane]
            if thread.is_alive() and in_hand is not None:
                in_hand.future.cancel()  # nobody waits for it
        return not any(thread.is_alive() for thread in self._threads.values())
