"""Work in processes of this machine, of which any may die without harm to the others."""

import threading
from collections.abc import Callable, Generator, Hashable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Generic, TypeVar

from ...base.errors import BatchError
from ...base.worker import ProcessDiedError, TookLongError, WorkerProcess

Piece = TypeVar("Piece", bound=Hashable)
Made = TypeVar("Made")

POLL_SECONDS = 0.05

TRIES = (
    2  # a process may have died for want of memory, while another was at a large piece
)


def in_flight(
    submit: Callable[[Piece], Future[Made]],
    receive: Callable[[Future[Made], Piece], Made | None],
    pieces: Sequence[Piece],
    should_stop: Callable[[], bool],
    most: Callable[[], int],
) -> Generator[tuple[Piece, Made], None, None]:
    """Hand out pieces, at `most` so many at a time, and give each as it is done.

    `receive` gives None where a piece is to be handed out anew.
    """
    waiting = list(reversed(pieces))
    busy: dict[Future[Made], Piece] = {}
    while (waiting or busy) and not should_stop():
        while waiting and len(busy) < most():
            piece = waiting.pop()
            busy[submit(piece)] = piece
        for future in wait(busy, POLL_SECONDS, FIRST_COMPLETED).done:
            piece = busy.pop(future)
            made = receive(future, piece)
            if made is None:
                waiting.append(piece)
            else:
                yield piece, made


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


class _Lanes(Generic[Piece, Made]):
    """A process for each thread that asks."""

    def __init__(
        self,
        call: Callable[[WorkerProcess, Piece], Made],
        stand_in: Callable[[Piece, ProcessDiedError], Made],
    ) -> None:
        self._call = call
        self._stand_in = stand_in
        self._processes: dict[int, WorkerProcess] = {}
        self._ended = False
        self._lock = threading.Lock()

    def do(self, piece: Piece) -> Made:
        """Have a piece done, in a new process if the first one died."""
        died = ProcessDiedError()
        for _ in range(TRIES):
            try:
                return self._call(self._process(), piece)
            except ProcessDiedError as error:
                died = error
                self._processes.pop(threading.get_ident()).kill()
                if self._ended or isinstance(error, TookLongError):
                    break
        return self._stand_in(piece, died)

    def end(self) -> None:
        """Kill all processes; no others are started."""
        with self._lock:
            self._ended = True
            for one in list(self._processes.values()):
                one.kill()

    def _process(self) -> WorkerProcess:
        found = self._processes.get(threading.get_ident())
        if found is None:
            found = WorkerProcess()
            self._processes[threading.get_ident()] = found
        with self._lock:
            if self._ended:
                found.kill()
                raise BatchError("work that goes on", "the end of it", "start it again")
        return found
