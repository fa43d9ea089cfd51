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

"""Work in processes of this machine; any may die without harm to others."""

import threading
from collections.abc import Callable, Generator, Hashable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from ...base.errors import BatchError
from ...base.worker import ProcessDiedError, TookLongError, WorkerProcess

Piece = TypeVar("Piece", bound=Hashable)
Made = TypeVar("Made")

POLL_SECONDS = 0.05

TRIES = 2
"""A process may have died for want of memory, while another was at a large piece."""


def in_flight(
    submit: Callable[[Piece], Future[Made]],
    receive: Callable[[Future[Made], Piece], Made | None],
    pieces: Sequence[Piece],
    should_stop: Callable[[], bool],
    limit: Callable[[], int],
) -> Generator[tuple[Piece, Made], None, None]:
    """Hand out pieces, at `limit` so many at a time, and give each as it is done.

    `receive` gives None where a piece is to be handed out anew.
    """
    queue = list(reversed(pieces))
    futures: dict[Future[Made], Piece] = {}
    while (queue or futures) and not should_stop():
        while queue and len(futures) < limit():
            piece = queue.pop()
            futures[submit(piece)] = piece
        for future in wait(futures, POLL_SECONDS, FIRST_COMPLETED).done:
            piece = futures.pop(future)
            answer = receive(future, piece)
            if answer is None:
                queue.append(piece)
            else:
                yield piece, answer


def work_in_processes(
    workers: int,
    call: Callable[[WorkerProcess, Piece], Made],
    stand_in: Callable[[Piece, ProcessDiedError], Made],
    pieces: Sequence[Piece],
    should_stop: Callable[[], bool],
) -> Generator[tuple[Piece, Made], None, None]:
    """Have several processes do work; the death of one costs nobody else anything.

    `stand_in`: of a piece whose process died twice, or once for taking too long.
    """
    threads = min(workers, len(pieces))
    if not threads:
        return
    lanes = _Lanes(call, stand_in)
    pool = ThreadPoolExecutor(threads)
    try:
        yield from in_flight(
            lambda piece: pool.submit(lanes.do, piece),
            lambda future, _: future.result(),
            pieces,
            should_stop,
            lambda: 2 * threads,
        )
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        lanes.end()
        pool.shutdown()


@dataclass
class _Lanes(Generic[Piece, Made]):
    """A process for each thread that asks."""

    call: Callable[[WorkerProcess, Piece], Made]
    stand_in: Callable[[Piece, ProcessDiedError], Made]
    processes: dict[int, WorkerProcess] = field(default_factory=dict)
    has_ended: bool = False
    lock: threading.Lock = field(default_factory=threading.Lock)

    def do(self, piece: Piece) -> Made:
        """Have a piece done, in a new process if the first one died."""
        died = ProcessDiedError()
        for _ in range(TRIES):
            try:
                return self.call(self._process(), piece)
            except ProcessDiedError as error:
                died = error
                self.processes.pop(threading.get_ident()).kill()
                if self.has_ended or isinstance(error, TookLongError):
                    break
        return self.stand_in(piece, died)

    def end(self) -> None:
        """Kill all processes; no others are started."""
        with self.lock:
            self.has_ended = True
            for process in list(self.processes.values()):
                process.kill()

    def _process(self) -> WorkerProcess:
        process = self.processes.get(threading.get_ident())
        if process is None:
            process = WorkerProcess()
            self.processes[threading.get_ident()] = process
        with self.lock:
            if self.has_ended:
                process.kill()
                raise BatchError("work that goes on", "the end of it", "start it again")
        return process
