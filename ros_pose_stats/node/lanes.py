# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Work on parts in lanes, a thread each: what takes long holds up nothing quick."""

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

from ..core.mesh.bodies.overlap import TakesLongError
from .messages.codes import BusyError, refusal_at_end

T = TypeVar("T")


def finished_future(value: T) -> Future[T]:
    """A future that is done."""
    future: Future[T] = Future()
    future.set_result(value)
    return future


def result_or_refusal(future: Future[T]) -> T:
    """Wait for the result of a future; raises PoseStatsError if it is refused."""
    try:
        return future.result()
    except CancelledError as error:
        raise refusal_at_end() from error


class Lane(IntEnum):
    """Where a task waits."""

    QUICK = 0  # meshes that are built in the node, in moments
    SLOW = 1  # meshes that may take all the time that there is, in another process
    CHECK = 2  # drops beside estimates, some 50 ms each
    OUTLINE = 3
    FIT = 4  # of plates, seconds each, and their writing
    FILE = 5  # meshes that are read from a file, in a process with bounds
    RECORD = 6  # what is written down once a second, or after a mesh that is to be read


class Rank(IntEnum):
    """What goes first in a lane."""

    REQUESTED_MESH = 0  # somebody waits for it
    KNOWN_PART = 1  # a request about one
    PUBLISHED_MESH = 2
    WHEN_IDLE = 3  # when nothing else waits; holds on to little


MOST_WAITING = {
    Lane.QUICK: (64, "meshes of a kind"),
    Lane.SLOW: (64, "large meshes of a kind"),
    Lane.CHECK: (256, "estimates to be checked"),
    Lane.OUTLINE: (16, "requests for outlines and plans"),
    Lane.FIT: (16, "fits of plates"),
    Lane.FILE: (16, "files of meshes"),
    Lane.RECORD: (256, "answers to be recorded"),
}
MOST_LARGE_REQUESTED = (8, "large meshes with their requests")
"""Each may take a minute, and somebody waits for it."""

ROOM = (
    4  # times `max_mesh_bytes`, for all that wait or are in hand; half for large ones
)
LAST_SECONDS = 0.5  # for what is in hand when the lanes are closed


@dataclass(eq=False)
class _Task:
    work: Callable[[], Any]
    rank: Rank
    lane: (
        Lane  # where it is to be done; it waits in the slow lane behind one of its name
    )
    size: int  # bytes that it holds on to
    part_id: str  # empty: of no name
    number: int  # in the order of their coming
    future: Future[Any] = field(default_factory=Future)

    def work_off(self, lane: Lane) -> bool:
        """Do it for whoever asked; false where it takes too long for the quick lane."""
        with suppress(InvalidStateError):  # the lanes were closed just now
            try:
                self.future.set_result(self.work())
            except BaseException as error:
                if isinstance(error, TakesLongError) and lane is Lane.QUICK:
                    return False
                self.future.set_exception(error)
        return True


class Lanes:
    """Tasks that wait in the lanes, and the threads that work them off."""

    def __init__(self, most_bytes: Callable[[], int]) -> None:
        self._most_bytes = most_bytes  # of a single mesh
        self._numbers = itertools.count()
        # what is next comes first
        self._waiting: dict[Lane, list[_Task]] = {lane: [] for lane in Lane}
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
        self.is_closed = False
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
        """Queue a task; without room for it a BusyError comes of it, or `put` waits.

        Work of the quick lane that raises `TakesLongError` is called again in the slow
        one.
        """
        with self._changed:
            task = _Task(work, rank, lane, size, part_id, next(self._numbers))
            while (refusal := self._lack_of_room(task)) is not None:
                is_published = rank is Rank.PUBLISHED_MESH
                if not is_published or self._lane_to_wait_in(task) is not Lane.QUICK:
                    task.future.set_exception(refusal)
                    return task.future
                self._changed.wait()
            if self.is_closed:
                task.future.cancel()
            else:
                self._insert(self._lane_to_wait_in(task), task)
        return task.future

    def _tasks(self, *lanes: Lane) -> Iterator[_Task]:
        """All that wait or are in hand, but for those that wait for an idle node."""
        for lane in lanes:
            task_in_hand = self._in_hand[lane]
            if task_in_hand is not None:
                yield task_in_hand
            for task in self._waiting[lane]:
                if task.rank < Rank.WHEN_IDLE:
                    yield task

    def _lane_to_wait_in(self, task: _Task) -> Lane:
        """The lane in which a task has to wait: behind earlier ones of its name."""
        return Lane.SLOW if self._is_behind(task, Lane.SLOW) else task.lane

    def _is_behind(self, task: _Task, *lanes: Lane) -> bool:
        """Whether lanes have an earlier task of the same name."""
        return task.part_id != "" and any(
            earlier.part_id == task.part_id and earlier.number < task.number
            for earlier in self._tasks(*lanes)
        )

    def _insert(self, lane: Lane, task: _Task) -> None:
        """Queue a task where it came, also one that comes back from another lane."""
        insort(
            self._waiting[lane], task, key=lambda queued: (queued.rank, queued.number)
        )
        self._changed.notify_all()

    def _lack_of_room(self, task: _Task) -> BusyError | None:
        """Why a task is not taken in now; one larger than the bound waits alone."""
        if self.is_closed or task.rank is Rank.WHEN_IDLE:
            return None
        lane = self._lane_to_wait_in(task)
        most, noun = MOST_WAITING[lane]
        if lane is Lane.SLOW and task.rank is Rank.REQUESTED_MESH:
            most, noun = MOST_LARGE_REQUESTED
        waiting = sum(queued.rank is task.rank for queued in self._waiting[lane])
        if waiting >= most:
            return BusyError(
                f"at most {most} {noun} waiting", f"{waiting}", "ask again in a moment"
            )
        room = ROOM * self._most_bytes()
        queued_tasks = list(self._tasks(Lane.QUICK, Lane.SLOW))
        refusal = self._excess(task, queued_tasks, room, "")
        if refusal is None and task.lane is Lane.SLOW:
            large_tasks = [
                queued for queued in queued_tasks if queued.lane is Lane.SLOW
            ]
            refusal = self._excess(task, large_tasks, room // 2, "large ")
        return refusal

    def _excess(
        self, task: _Task, queued_tasks: list[_Task], bound: int, kind: str
    ) -> BusyError | None:
        """The refusal of a task that has no room beside others of a kind."""
        used = sum(queued.size for queued in queued_tasks)
        if not (task.size and used) or used + task.size <= bound:
            return None
        return BusyError(
            f"at most {bound} bytes of {kind}meshes waiting "
            f"({bound // self._most_bytes()} times max_mesh_bytes)",
            f"{task.size} bytes more than the {used} that wait",
            "send it again once they are done, or decimate it",
        )

    def _run(self, lane: Lane) -> None:
        while (task := self._next(lane)) is not None:
            is_done = task.work_off(lane)
            with self._changed:
                self._in_hand[lane] = None
                if not is_done:
                    task.lane = Lane.SLOW
                    self._insert(Lane.SLOW, task)
                self._changed.notify_all()
                is_dropped = self.is_closed and not is_done
            if is_dropped:
                task.future.cancel()
            del task  # which holds on to a mesh

    def _next(self, lane: Lane) -> _Task | None:
        """The next task that is to be done in a lane; none once all is closed."""
        with self._changed:
            while not self.is_closed:
                task = self._find_next(lane)
                if task is None:
                    self._changed.wait()
                    continue
                self._waiting[lane].remove(task)
                lane_to_wait_in = self._lane_to_wait_in(task)
                if lane_to_wait_in is lane:
                    self._in_hand[lane] = task
                    return task
                self._insert(lane_to_wait_in, task)
            return None

    def _find_next(self, lane: Lane) -> _Task | None:
        """The first task of a lane that has to wait for no other one."""
        tasks = self._waiting[lane]
        if lane is Lane.CHECK and self._waiting[Lane.QUICK]:
            # Checks that nobody waits for let meshes pass that are soon built.
            tasks = list(self._tasks(lane))
        for task in tasks:
            # A mesh waits for earlier ones of its name, of which quick ones may come
            # back as slow ones.
            if not self._is_behind(task, Lane.QUICK, Lane.FILE, lane):
                return task
        return None

    def count_meshes(self) -> int:
        """Meshes that wait."""
        with self._changed:
            return sum(
                len(self._waiting[lane]) for lane in (Lane.QUICK, Lane.SLOW, Lane.FILE)
            )

    def close(self) -> None:
        """Drop what waits, and finish what soon is."""
        with self._changed:
            self.is_closed = True
            dropped = [task for tasks in self._waiting.values() for task in tasks]
            self._waiting = {lane: [] for lane in Lane}
            self._changed.notify_all()
        for task in dropped:
            task.future.cancel()
        end = time.monotonic() + LAST_SECONDS
        for lane, thread in self._threads.items():
            if thread.is_alive():
                thread.join(timeout=max(0.0, end - time.monotonic()))
            in_hand = self._in_hand[lane]
            if thread.is_alive() and in_hand is not None:
                in_hand.future.cancel()  # nobody waits for it
