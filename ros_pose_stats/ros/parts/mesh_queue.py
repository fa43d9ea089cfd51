"""Meshes on their way to become parts, in three lanes: what takes long holds up nothing quick."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

from ...errors import RequestError
from .lanes import Lane, Pace, Rank, Task

T = TypeVar("T")

MOST_WAITING = 64

ROOM = 4
"""All meshes that wait or are in hand share so many times `max_mesh_bytes`.

The large ones take half of that at most, so that there is always room for small ones.
"""


class MeshQueue:
    """Three lanes, and what each of them has to wait for.

    A small mesh begins in the quick lane, a large one in the middle one. What is not done within
    the lane's time goes on to the next lane, and so does what comes under the name of a mesh
    there: of two meshes of one name the later one is done last.

    `most_bytes`: how many bytes a single mesh may have.
    """

    def __init__(self, most_bytes: Callable[[], int]) -> None:
        self._most_bytes = most_bytes
        self._lanes = [Lane(pace) for pace in Pace]
        self._threads = [threading.Thread(target=self._run, args=(lane,), daemon=True,
                                          name=f"{lane.pace.name.lower()} lane")
                         for lane in self._lanes]
        self._names: dict[str, list[Task]] = {}
        self._bytes = {False: 0, True: 0}
        self._closed = False
        self._changed = threading.Condition()
        self._of_thread = threading.local()

    def start(self) -> None:
        """Begin to work."""
        for thread in self._threads:
            thread.start()

    def pace(self) -> Pace:
        """Of the lane in whose thread this is called; elsewhere there is all the time."""
        found: Pace = getattr(self._of_thread, "pace", Pace.SLOW)
        return found

    def put(self, work: Callable[[], T], size: int, part_id: str = "",
            large: bool = False) -> Future[T]:
        """Queue a task; waits while the quick lane is full.

        `work`: may raise `TakesLongError`, and is called again in the next lane then; `size`:
        bytes that it holds on to; `part_id`: tasks of one name are done in their order. Returns of
        what `work` returns or raises; cancelled where the queue is closed, and refused where a
        slower lane is full: to wait for that would hold up small meshes.
        """
        task = Task(work, size, part_id, Pace.MIDDLE if large else Pace.QUICK, Rank.MESH)
        with self._changed:
            while not self._closed and (problem := self._lack_of_room(task)):
                if self._entry(task).pace is not Pace.QUICK:
                    task.future.set_exception(problem)
                    return task.future
                self._changed.wait()
            self._append(task)
        return task.future

    def put_first(self, work: Callable[[], T], size: int = 0, part_id: str = "",
                  large: bool = False) -> Future[T]:
        """Queue a task that a client waits for, before the others; never waits itself.

        Raises RequestError if there is no room for it.
        """
        task = self._request(work, size, part_id, large)
        with self._changed:
            problem = None if self._closed else self._lack_of_room(task)
            if problem is not None:
                raise problem
            self._append(task)
        return task.future

    def check_room(self, size: int, part_id: str = "", large: bool = False) -> None:
        """Refuse what `put_first` would refuse.

        Raises RequestError if there is no room for it.
        """
        with self._changed:
            problem = None if self._closed else self._lack_of_room(self._request(
                lambda: None, size, part_id, large))
        if problem is not None:
            raise problem

    def put_later(self, work: Callable[[], T], large: bool = False) -> Future[T]:
        """Queue a task that holds on to little for when nothing else waits; never waits."""
        task = Task(work, 0, "", Pace.SLOW if large else Pace.QUICK, Rank.LATER)
        with self._changed:
            self._append(task)
        return task.future

    @staticmethod
    def _request(work: Callable[[], object], size: int, part_id: str, large: bool) -> Task:
        return Task(work, size, part_id, Pace.MIDDLE if large else Pace.QUICK, Rank.URGENT)

    def _entry(self, task: Task) -> Lane:
        """The lane to wait in at first: behind the last one of its name."""
        others = self._names.get(task.part_id)
        return self._lanes[others[-1].lane if others else task.pace]

    def _lack_of_room(self, task: Task) -> RequestError | None:
        """Why a task cannot be taken in now; one that is larger than the bound waits alone."""
        waiting = len(self._entry(task).waiting[task.rank])
        if waiting >= MOST_WAITING:
            return RequestError(f"at most {MOST_WAITING} meshes of a kind waiting", f"{waiting}",
                                "send it again in a moment")
        room, large = ROOM * self._most_bytes(), task.pace is not Pace.QUICK
        for most, held in ((room, sum(self._bytes.values())),
                           *(((room // 2, self._bytes[True]),) if large else ())):
            if held and held + task.size > most:
                return RequestError(
                    f"at most {most} bytes of {'large ' * (most < room)}meshes waiting "
                    f"({most // self._most_bytes()} times max_mesh_bytes)",
                    f"{task.size} bytes more than the {held} that wait",
                    "send it again once they are done, or decimate it")
        return None

    def _append(self, task: Task) -> None:
        """Take in a task."""
        if self._closed:
            task.future.cancel()
            return
        task.lane = self._entry(task).pace
        if task.part_id:
            self._names.setdefault(task.part_id, []).append(task)
        self._bytes[task.pace is not Pace.QUICK] += task.size
        self._lanes[task.lane].waiting[task.rank].append(task)
        self._changed.notify_all()

    def _move(self, task: Task, pace: Pace) -> None:
        """Have a task wait in a slower lane, behind those there."""
        self._bytes[task.pace is not Pace.QUICK] -= task.size
        task.pace = task.lane = pace
        self._bytes[True] += task.size
        self._lanes[pace].waiting[task.rank].append(task)
        self._changed.notify_all()

    def _remove(self, task: Task) -> None:
        """Let go of a task that has been done."""
        self._bytes[task.pace is not Pace.QUICK] -= task.size
        others = self._names.get(task.part_id, [])
        if task in others:
            others.remove(task)
            if not others:
                del self._names[task.part_id]
        self._changed.notify_all()

    def _run(self, lane: Lane) -> None:
        self._of_thread.pace = lane.pace
        while self._do_next(lane):
            pass

    def _do_next(self, lane: Lane) -> bool:
        """Do the next task, of which nothing is held on to; false once the queue is closed."""
        task = self._next(lane)
        if task is None:
            return False
        done = task.do(lane.pace)
        with self._changed:
            lane.in_hand = None
            dropped = self._closed and not done
            if done or dropped:
                self._remove(task)
            else:
                self._move(task, Pace(lane.pace + 1))
        if dropped:
            task.future.cancel()
        return True

    def _next(self, lane: Lane) -> Task | None:
        """The next task that is to be done in a lane; none once the queue is closed."""
        with self._changed:
            while not self._closed:
                task = lane.pop()
                if task is None:
                    self._changed.wait()
                elif (pace := self._pace_of(task)) > lane.pace:
                    self._move(task, pace)
                else:
                    lane.in_hand = task
                    return task
            return None

    def _pace_of(self, task: Task) -> Pace:
        """The lane that a task has to take, as large as it is and behind those of its name."""
        others = self._names.get(task.part_id, [])
        before = others[:others.index(task)] if task in others else []
        return max([task.pace, *(one.lane for one in before)])

    def waiting(self) -> int:
        """Tasks that wait."""
        with self._changed:
            return sum(len(tasks) for lane in self._lanes for tasks in lane.waiting)

    def close(self) -> bool:
        """Drop what waits, finish what is in hand if that is soon done.

        Returns whether nothing is computed any more.
        """
        with self._changed:
            self._closed = True
            dropped = [task for lane in self._lanes for tasks in lane.waiting for task in tasks]
            for lane in self._lanes:
                for tasks in lane.waiting:
                    tasks.clear()
            self._changed.notify_all()
        for task in dropped:
            task.future.cancel()
        ended = [lane.ended(thread)  # each is asked, so that nobody waits for what it has in hand
                 for lane, thread in zip(self._lanes, self._threads, strict=True)]
        return all(ended)
