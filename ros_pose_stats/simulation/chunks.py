"""Drops in chunks on all cores: handed out in order, taken in in order.

Workers are threads; the kernel lets go of the interpreter while it runs. A chunk is sized
to take about 25 ms, so that progress is smooth and a stop is quick. What is counted is
always a contiguous prefix, so nothing depends on who did which chunk and when.
"""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

from .drops import DropOutcomes

CHUNK_SECONDS = 0.025
"""What a chunk is sized for; a drop that is given up takes as long, or a few times, by itself."""

FIRST_CHUNK = 1
LAST_CHUNKS = 16
"""Towards the end chunks get no smaller than this."""

GROWTH = 8
"""A chunk has at most this many times the drops of the largest one before."""

POLL_SECONDS = 0.01
"""How often a stop is looked for while workers are busy."""


class Chunk(NamedTuple):
    """Outcomes of drops first ... first + n - 1."""

    first: int
    outcomes: DropOutcomes


class ChunkRun:
    """Chunks of a run of drops, made by worker threads.

    Parameters
    ----------
    drop : callable
        From the first drop and a count to their outcomes; called from the workers.
    drops : int
        The bound of the run.
    workers : int
        Threads.
    should_stop : callable
        Asked from the caller's thread; True ends the run after the chunks in hand.
    background : bool
        Workers give way to other threads.
    wanted : int, optional
        Drops that are wanted for certain; default: all. See `want`.
    """

    def __init__(self, drop: Callable[[int, int], DropOutcomes], drops: int, workers: int,
                 should_stop: Callable[[], bool], background: bool = False,
                 wanted: int | None = None) -> None:
        self._drop = drop
        self._bound = drops
        self._workers = workers
        self._should_stop = should_stop
        self._background = background
        self._wanted = drops if wanted is None else wanted
        self._lock = threading.Condition()
        self._next = 0
        self._size = FIRST_CHUNK
        self._stopped = False
        self._done: queue.SimpleQueue[Chunk | BaseException | None] = queue.SimpleQueue()

    def stop(self) -> None:
        """Hand out no more chunks."""
        with self._lock:
            self._stopped = True
            self._lock.notify_all()

    def want(self, drops: int) -> None:
        """Hand out chunks up to that many drops; beyond them the workers wait.

        A run that is looked at now and then would else do drops in vain after its last look.
        """
        with self._lock:
            self._wanted = drops
            self._lock.notify_all()

    def in_order(self) -> Iterator[DropOutcomes]:
        """Outcomes as they come, from drop 0 on without gaps.

        Once stopped, what is left of the contiguous prefix still comes.
        """
        threads = [threading.Thread(target=self._work, name=f"drops-{i}", daemon=True)
                   for i in range(self._workers)]
        for thread in threads:
            thread.start()
        try:
            yield from self._arrange()
        finally:
            self.stop()
            for thread in threads:
                thread.join()

    def _arrange(self) -> Iterator[DropOutcomes]:
        waiting: dict[int, DropOutcomes] = {}
        wanted, busy = 0, self._workers
        while busy:
            if self._should_stop():
                self.stop()
            try:
                came = self._done.get(timeout=POLL_SECONDS)
            except queue.Empty:
                continue
            if came is None:
                busy -= 1
            elif isinstance(came, BaseException):
                raise came
            else:
                waiting[came.first] = came.outcomes
            while wanted in waiting:
                outcomes = waiting.pop(wanted)
                wanted += outcomes.pose.shape[0]
                yield outcomes

    def _work(self) -> None:
        try:
            if self._background:
                _give_way()
            while True:
                first, count = self._take()
                if count == 0:
                    break
                begin = time.perf_counter()
                outcomes = self._drop(first, count)
                self._learn(count, time.perf_counter() - begin)
                self._done.put(Chunk(first, outcomes))
        except BaseException as error:  # handed on to the caller's thread
            self._done.put(error)
        else:
            self._done.put(None)

    def _take(self) -> tuple[int, int]:
        """The next chunk's first drop and size; size 0 if there is none."""
        with self._lock:
            self._lock.wait_for(lambda: self._stopped or self._next < self._wanted
                                or self._next >= self._bound)
            if self._stopped:
                return self._next, 0
            # Towards the end the chunks get smaller, so that all workers end together.
            left = self._wanted - self._next
            fair = -(-left // (2 * self._workers))
            count = min(self._size, max(fair, LAST_CHUNKS), left)
            self._next += count
            return self._next - count, count

    def _learn(self, count: int, seconds: float) -> None:
        """Size chunks by the pace of the last one."""
        wanted = int(count * CHUNK_SECONDS / max(seconds, 1e-9))
        with self._lock:
            self._size = max(1, min(wanted, GROWTH * max(count, self._size)))


NICENESS = 10


def _give_way() -> None:
    """Lower the priority of this thread, where threads have priorities of their own."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
