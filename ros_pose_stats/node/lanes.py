"""Work on parts in lanes, a thread each, so that what takes long holds up nothing quick."""

import itertools
import threading
import time
from bisect import insort
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, TypeVar

from ..base.errors import PoseStatsError, RequestError
from ..core.mesh.overlap import TakesLongError

T = TypeVar("T")


def done_with(value: T) -> Future[T]:
    """A future that is done."""
    future: Future[T] = Future()
    future.set_result(value)
    return future


class NotDoneError(RequestError):
    """What was asked for was not done for a reason that is not its own."""


def ending() -> NotDoneError:
    """The refusal of whatever a node that ends is asked for."""
    return NotDoneError("a running node", "one that is ending", "start it again")


def words_of(error: BaseException) -> str:
    """What a client is told of an error: a refusal as it is, all else as an internal failure."""
    return (
        str(error)
        if isinstance(error, PoseStatsError)
        else (f"internal failure: {type(error).__name__}: {error}")
    )


def result_of(coming: Future[T]) -> T:
    """What is coming, once it is there; raises PoseStatsError if it is refused."""
    try:
        return coming.result()
    except CancelledError as error:
        raise ending() from error


class Lane(IntEnum):
    """Where a task waits."""

    QUICK = 0  # meshes that are built in the node, in moments
    SLOW = 1  # meshes that may take all the time that there is, in another process
    CHECK = 2  # drops beside estimates, some 50 ms each
    OUTLINE = 3
    FIT = 4  # of plates, seconds each, and their writing


class Rank(IntEnum):
    """What goes first in a lane."""

    SENT = 0  # by a request that waits for it
    KNOWN = 1  # for a request about a known part
    PUBLISHED = 2
    LATER = 3  # when nothing else waits; holds on to little


MOST_WAITING = {
    Lane.QUICK: (64, "meshes of a kind"),
    Lane.SLOW: (64, "large meshes of a kind"),
    Lane.CHECK: (256, "estimates to be checked"),
    Lane.OUTLINE: (16, "requests for outlines and plans"),
    Lane.FIT: (16, "fits of plates"),
}
MOST_SENT = 8  # large meshes that wait with their requests; each may take a minute

ROOM = 4  # times `max_mesh_bytes`, for all that wait or are in hand; half of it for large ones
LAST_SECONDS = (
    0.5  # what is in hand may be finished for so long when the lanes are closed
)


@dataclass(eq=False)
class _Task:
    work: Callable[[], Any]
    rank: Rank
    lane: Lane  # its own; behind a slow one of its name it waits in the slow lane
    size: int  # bytes that it holds on to
    part_id: str  # empty: of no name
    number: int  # in the order of their coming
    future: Future[Any] = field(default_factory=Future)

    def do(self, lane: Lane) -> bool:
        """Do it for whoever asked; false where it needs more time than the quick lane has."""
        with suppress(InvalidStateError):  # the lanes were closed just now
            try:
                self.future.set_result(self.work())
            except BaseException as error:
                if isinstance(error, TakesLongError) and lane is Lane.QUICK:
                    return False
                self.future.set_exception(error)
        return True


class Lanes:
    """The lanes; `most_bytes` of a single mesh."""

    def __init__(self, most_bytes: Callable[[], int]) -> None:
        self._most_bytes = most_bytes
        self._numbers = itertools.count()
        self._waiting: dict[Lane, list[_Task]] = {
            lane: [] for lane in Lane
        }  # what is next first
        self._in_hand: dict[Lane, _Task | None] = dict.fromkeys(Lane)
        self._threads = {
            lane: threading.Thread(
                target=self._run,
                args=(lane,),
                daemon=True,
                name=f"{lane.name.lower()} lane",
            )
            for lane in Lane
        }
        self.closed = False
        self._changed = threading.Condition()

    def start(self) -> None:
        """Begin to work."""
        for thread in self._threads.values():
            thread.start()

    def is_quick(self) -> bool:
        """Whether this is called in the quick lane; elsewhere there is all the time."""
        return threading.current_thread() is self._threads[Lane.QUICK]

    def put(
        self,
        work: Callable[[], T],
        rank: Rank,
        lane: Lane = Lane.QUICK,
        size: int = 0,
        part_id: str = "",
    ) -> Future[T]:
        """Queue a task; where there is no room a RequestError comes of it, or `put` waits.

        Work of the quick lane that raises `TakesLongError` is called again in the slow one.
        """
        with self._changed:
            task = _Task(work, rank, lane, size, part_id, next(self._numbers))
            while (problem := self._lack_of_room(task)) is not None:
                if rank is not Rank.PUBLISHED or self._place(task) is Lane.SLOW:
                    task.future.set_exception(problem)
                    return task.future
                self._changed.wait()
            if self.closed:
                task.future.cancel()
            else:
                self._wait_in(self._place(task), task)
        return task.future

    def _tasks(self, *lanes: Lane) -> Iterator[_Task]:
        """All that wait or are in hand, but for what is done later."""
        for lane in lanes:
            yield from filter(None, [self._in_hand[lane]])
            yield from (task for task in self._waiting[lane] if task.rank < Rank.LATER)

    def _place(self, task: _Task) -> Lane:
        """The lane in which a task has to wait: behind earlier ones of its name."""
        return Lane.SLOW if self._is_behind(task, Lane.SLOW) else task.lane

    def _is_behind(self, task: _Task, *lanes: Lane) -> bool:
        """Whether lanes have an earlier task of the same name."""
        return bool(task.part_id) and any(
            other.part_id == task.part_id and other.number < task.number
            for other in self._tasks(*lanes)
        )

    def _wait_in(self, lane: Lane, task: _Task) -> None:
        """Queue a task where it came, also one that comes back from another lane."""
        insort(self._waiting[lane], task, key=lambda other: (other.rank, other.number))
        self._changed.notify_all()

    def _lack_of_room(self, task: _Task) -> RequestError | None:
        """Why a task cannot be taken in now; one that is larger than the bound waits alone."""
        if self.closed or task.rank is Rank.LATER:
            return None
        lane = self._place(task)
        most, noun = MOST_WAITING[lane]
        if (lane, task.rank) == (Lane.SLOW, Rank.SENT):
            most = MOST_SENT
            noun = "large meshes with their requests"
        waiting = sum(other.rank is task.rank for other in self._waiting[lane])
        if waiting >= most:
            return RequestError(
                f"at most {most} {noun} waiting", f"{waiting}", "ask again in a moment"
            )
        tasks = list(self._tasks(Lane.QUICK, Lane.SLOW))
        room = ROOM * self._most_bytes()
        held = sum(other.size for other in tasks)
        large = sum(other.size for other in tasks if other.lane is Lane.SLOW)
        for bound, used, kind in ((room, held, ""), (room // 2, large, "large ")):
            if (
                task.size
                and used
                and used + task.size > bound
                and (not kind or task.lane is Lane.SLOW)
            ):
                return RequestError(
                    f"at most {bound} bytes of {kind}meshes waiting "
                    f"({bound // self._most_bytes()} times max_mesh_bytes)",
                    f"{task.size} bytes more than the {used} that wait",
                    "send it again once they are done, or decimate it",
                )
        return None

    def _run(self, lane: Lane) -> None:
        while (task := self._next(lane)) is not None:
            is_done = task.do(lane)
            with self._changed:
                self._in_hand[lane] = None
                if not is_done:
                    task.lane = Lane.SLOW
                    self._wait_in(Lane.SLOW, task)
                self._changed.notify_all()
                is_dropped = self.closed and not is_done
            if is_dropped:
                task.future.cancel()
            del task  # which holds on to a mesh

    def _next(self, lane: Lane) -> _Task | None:
        """The next task that is to be done in a lane; none once all is closed."""
        with self._changed:
            while not self.closed:
                # Checks wait for meshes that are soon built, and a mesh, whoever sent it, for
                # earlier ones of its name, of which quick ones may come back as slow ones.
                first = (
                    list(self._tasks(lane))
                    if (lane is Lane.CHECK and self._waiting[Lane.QUICK])
                    else self._waiting[lane]
                )
                task = next(
                    (
                        task
                        for task in first
                        if not self._is_behind(task, Lane.QUICK, lane)
                    ),
                    None,
                )
                if task is None:
                    self._changed.wait()
                    continue
                self._waiting[lane].remove(task)
                if (place := self._place(task)) is not lane:
                    self._wait_in(place, task)
                else:
                    self._in_hand[lane] = task
                    return task
            return None

    def waiting(self) -> int:
        """Meshes that wait."""
        with self._changed:
            return len(self._waiting[Lane.QUICK]) + len(self._waiting[Lane.SLOW])

    def close(self) -> None:
        """Drop what waits, and finish what soon is."""
        with self._changed:
            self.closed = True
            dropped = list(itertools.chain(*self._waiting.values()))
            self._waiting = {lane: [] for lane in Lane}
            self._changed.notify_all()
        for task in dropped:
            task.future.cancel()
        until = time.monotonic() + LAST_SECONDS
        for lane, thread in self._threads.items():
            if thread.is_alive():
                thread.join(timeout=max(0.0, until - time.monotonic()))
            in_hand = self._in_hand[lane]
            if thread.is_alive() and in_hand is not None:
                in_hand.future.cancel()  # nobody waits for it
