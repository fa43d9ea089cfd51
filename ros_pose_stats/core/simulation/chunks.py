"""The worker threads of one simulation, which compute its drops in chunks on all cores.

The kernel releases the interpreter's lock while it runs. A chunk is sized to take about 25 ms, so
that progress is smooth and a stop is quick. The outcomes come back in the order of the drops and
without gaps, so that nothing depends on which worker computed which chunk, and when.
"""

import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator

from .drops import DropOutcomes

CHUNK_SECONDS = 0.025
"""Time that a chunk is sized for; a single drop that is given up takes as long, or longer."""

FIRST_CHUNK = 1
LAST_CHUNKS = 16  # least number of drops in the chunks near the end, which get smaller
GROWTH = 8  # factor by which a chunk may have more drops than the largest one before
POLL_SECONDS = (
    0.01  # time between two questions whether to stop, while workers are busy
)
NICENESS = 10  # of workers in the background


class DropWorkers:
    """Threads that compute the drops of one simulation.

    `drop`: from the first drop and a count to their outcomes; `wanted`: see `request_drops`.
    """

    def __init__(
        self,
        drop: Callable[[int, int], DropOutcomes],
        drops: int,
        workers: int,
        should_stop: Callable[[], bool],
        background: bool = False,
        wanted: int | None = None,
    ) -> None:
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
        # outcomes with the number of the first drop among them; how a worker ended
        self._done: queue.SimpleQueue[
            tuple[int, DropOutcomes] | BaseException | None
        ] = queue.SimpleQueue()

    def stop(self) -> None:
        """Hand out no more chunks."""
        with self._lock:
            self._stopped = True
            self._lock.notify_all()

    def request_drops(self, drops: int) -> None:
        """Let the workers compute up to that many drops, so that none is in vain."""
        with self._lock:
            self._wanted = drops
            self._lock.notify_all()

    def outcomes_in_order(self) -> Iterator[DropOutcomes]:
        """Start the workers, and yield outcomes from drop 0 on, without gaps."""
        threads = [
            threading.Thread(
                target=self._compute_chunks, name=f"drops-{i}", daemon=True
            )
            for i in range(self._workers)
        ]
        try:
            for thread in threads:
                thread.start()
            yield from self._arrange_outcomes()
        finally:
            self.stop()
            for thread in threads:
                if thread.ident is not None:  # none where one could not be started
                    thread.join()

    def _arrange_outcomes(self) -> Iterator[DropOutcomes]:
        waiting: dict[int, DropOutcomes] = {}
        wanted = 0
        busy = self._workers
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
                first, outcomes = came
                waiting[first] = outcomes
            while wanted in waiting:
                outcomes = waiting.pop(wanted)
                wanted += outcomes.pose.shape[0]
                yield outcomes

    def _compute_chunks(self) -> None:
        try:
            if (
                self._background and sys.platform == "linux"
            ):  # where threads have priorities
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
            while True:
                first, count = self._next_chunk()
                if count == 0:
                    break
                begin = time.perf_counter()
                outcomes = self._drop(first, count)
                pace = count / max(time.perf_counter() - begin, 1e-9)
                with self._lock:
                    self._size = max(
                        1,
                        min(int(pace * CHUNK_SECONDS), GROWTH * max(count, self._size)),
                    )
                self._done.put((first, outcomes))
        except BaseException as error:  # handed on to the caller's thread
            self._done.put(error)
        else:
            self._done.put(None)

    def _next_chunk(self) -> tuple[int, int]:
        """First drop and size of the next chunk; size 0 if there is none."""
        with self._lock:
            self._lock.wait_for(
                lambda: (
                    self._stopped
                    or self._next < self._wanted
                    or self._next >= self._bound
                )
            )
            if self._stopped:
                return self._next, 0
            # Towards the end the chunks get smaller, so that all workers end together.
            left = self._wanted - self._next
            fair = -(-left // (2 * self._workers))
            count = min(self._size, max(fair, LAST_CHUNKS), left)
            self._next += count
            return self._next - count, count
