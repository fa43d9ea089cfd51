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

"""The worker threads of one simulation, which compute its drops in chunks on all cores.

The kernel releases the interpreter's lock while it runs. A chunk is sized to take about
25 ms, so that progress is smooth and a stop is quick. The outcomes come back in the
order of the drops and without gaps, so that nothing depends on which worker computed
which chunk, and when.
"""

import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator

from .drops import DropOutcomes

CHUNK_SECONDS = 0.025
"""Time that a chunk is sized for; a single drop that is given up takes as long, or
longer."""

FIRST_CHUNK = 1
LAST_CHUNKS = 16  # least number of drops in the chunks near the end, which get smaller
GROWTH = 8  # factor by which a chunk may have more drops than the largest one before
POLL_SECONDS = 0.01
"""Time between two questions whether to stop, while workers are busy."""
NICENESS = 10  # of workers in the background


class DropWorkers:
    """Threads that compute the drops of one simulation.

    `drop`: from the first drop and a count to their outcomes; `requested_drops`: see
    `request_drops`.
    """

    def __init__(
        self,
        drop: Callable[[int, int], DropOutcomes],
        drops: int,
        workers: int,
        should_stop: Callable[[], bool],
        background: bool = False,
        requested_drops: int | None = None,
    ) -> None:
        self._drop = drop
        self._drop_bound = drops
        self._workers = workers
        self._should_stop = should_stop
        self._background = background
        self._requested_drops = drops if requested_drops is None else requested_drops
        self._condition = threading.Condition()
        self._next_drop = 0
        self._chunk_size = FIRST_CHUNK
        self._is_stopped = False
        # outcomes with the number of the first drop among them; how a worker ended
        self._results: queue.SimpleQueue[
            tuple[int, DropOutcomes] | BaseException | None
        ] = queue.SimpleQueue()

    def stop(self) -> None:
        """Hand out no more chunks."""
        with self._condition:
            self._is_stopped = True
            self._condition.notify_all()

    def request_drops(self, drops: int) -> None:
        """Let the workers compute up to that many drops, so that none is in vain."""
        with self._condition:
            self._requested_drops = drops
            self._condition.notify_all()

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
        early_outcomes: dict[int, DropOutcomes] = {}
        next_drop = 0
        busy_workers = self._workers
        while busy_workers:
            if self._should_stop():
                self.stop()
            try:
                result = self._results.get(timeout=POLL_SECONDS)
            except queue.Empty:
                continue
            if result is None:
                busy_workers -= 1
            elif isinstance(result, BaseException):
                raise result
            else:
                first, outcomes = result
                early_outcomes[first] = outcomes
            while next_drop in early_outcomes:
                outcomes = early_outcomes.pop(next_drop)
                next_drop += outcomes.pose.shape[0]
                yield outcomes

    def _compute_chunks(self) -> None:
        try:
            # Elsewhere threads have no priorities.
            if self._background and sys.platform == "linux":
                os.nice(NICENESS)  # of this thread alone, and above its caller's
            while True:
                first, count = self._next_chunk()
                if count == 0:
                    break
                begin = time.perf_counter()
                outcomes = self._drop(first, count)
                pace = count / max(time.perf_counter() - begin, 1e-9)
                with self._condition:
                    self._chunk_size = max(
                        1,
                        min(
                            int(pace * CHUNK_SECONDS),
                            GROWTH * max(count, self._chunk_size),
                        ),
                    )
                self._results.put((first, outcomes))
        except BaseException as error:  # handed on to the caller's thread
            self._results.put(error)
        else:
            self._results.put(None)

    def _next_chunk(self) -> tuple[int, int]:
        """First drop and size of the next chunk; size 0 if there is none."""
        with self._condition:
            self._condition.wait_for(
                lambda: (
                    self._is_stopped
                    or self._next_drop < self._requested_drops
                    or self._next_drop >= self._drop_bound
                )
            )
            if self._is_stopped:
                return self._next_drop, 0
            # Towards the end the chunks get smaller, so that all workers end together.
            remaining_drops = self._requested_drops - self._next_drop
            fair_share = -(-remaining_drops // (2 * self._workers))
            count = min(self._chunk_size, max(fair_share, LAST_CHUNKS), remaining_drops)
            self._next_drop += count
            return self._next_drop - count, count
