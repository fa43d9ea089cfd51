"""Work in processes of this machine, of which any may die without harm to the others."""

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any, Generic

from ..errors import BatchError, RequestError
from . import worker
from .in_flight import Made, Piece, in_flight

MOST_WORKERS = 1024

STEP_SECONDS = 1.0
"""Most of a time limit that is lost each time a run is suspended."""

TRIES = 2
"""A process may have died for want of memory, while another was at a large piece."""


def command_of(main: Callable[[], None]) -> list[str]:
    """Command of a process that runs a function of a module, and finds modules as this one does.

    `-m` would search the current folder first, where somebody else's files may lie.
    """
    return [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!a}; "
            f"from {main.__module__} import main; main()"]


class ProcessDiedError(Exception):
    """A process ended in the middle of a piece; how, in words."""


class TookLongError(ProcessDiedError):
    """A process was ended because its piece took too long."""


class WorkerProcess:
    """A process that does one thing at a time.

    Raises BatchError if it cannot be started.
    """

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            command_of(worker.main), stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        try:
            ready = self._read()
        except ProcessDiedError as error:
            raise BatchError("a process to work in", str(error),
                             "see what it printed above") from error
        assert ready == worker.READY

    def call(self, function: Callable[..., Made], *arguments: Any) -> Made:
        """Have a function of a module called there.

        Raises ProcessDiedError if the process ended, by itself or by `kill`.
        """
        assert self._process.stdin is not None
        try:
            pickle.dump((function, arguments), self._process.stdin, pickle.HIGHEST_PROTOCOL)
            self._process.stdin.flush()
        except OSError as error:
            raise self._died() from error
        made: Made = self._read()
        return made

    def call_within(self, seconds: float, function: Callable[..., Made], *arguments: Any) -> Made:
        """Have a function of a module called there; the process ends if that takes longer.

        Time in which this process is suspended does not count.

        Raises TookLongError if it did. Raises ProcessDiedError if the process ended otherwise.
        """
        done, late = threading.Event(), threading.Event()

        def guard() -> None:
            left = seconds
            while left > 0.0:  # in steps, so that a run that is suspended does not grow old
                if done.wait(min(left, STEP_SECONDS)):
                    return
                left -= STEP_SECONDS
            late.set()
            self._process.kill()

        threading.Thread(target=guard, name="time limit", daemon=True).start()
        try:
            return self.call(function, *arguments)
        except ProcessDiedError as error:
            if late.is_set():
                raise TookLongError(f"took longer than {seconds:g} s") from error
            raise
        finally:
            done.set()

    def kill(self) -> None:
        """End it, whatever it is at."""
        self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            assert stream is not None
            with suppress(OSError):  # what was never read
                stream.close()

    def _read(self) -> Any:
        assert self._process.stdout is not None
        try:
            return pickle.load(self._process.stdout)
        except (EOFError, OSError, ValueError, pickle.UnpicklingError) as error:
            raise self._died() from error

    def _died(self) -> ProcessDiedError:
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(1.0)
        status = self._process.poll()
        if status is not None and status < 0:
            return ProcessDiedError(f"ended by {signal.Signals(-status).name}")
        return ProcessDiedError(f"ended with exit status {status}")


def work_in_processes(workers: int, call: Callable[[WorkerProcess, Piece], Made],
                      stand_in: Callable[[Piece, ProcessDiedError], Made], pieces: Sequence[Piece],
                      should_stop: Callable[[], bool]
                      ) -> Generator[tuple[Piece, Made], None, None]:
    """Have several processes do work; the death of one costs nobody else anything.

    `workers`: processes; no more are started than there are pieces; `call`: has a piece done in a
    process; `stand_in`: what comes of a piece whose process died twice, or once for taking too
    long; from the `ProcessDiedError`; `should_stop`: asked some twenty times a second; what is in
    hand then is given up. Raises BatchError if no process can be started.
    """
    threads = min(workers, len(pieces))
    if not threads:
        return
    lanes = _Lanes(call, stand_in)
    pool = ThreadPoolExecutor(threads)
    try:
        yield from in_flight(lambda piece: pool.submit(lanes.do, piece),
                             lambda future, _: future.result(), pieces, should_stop,
                             lambda: 2 * threads)
    finally:
        lanes.end()
        pool.shutdown(cancel_futures=True)


class _Lanes(Generic[Piece, Made]):
    """A process for each thread that asks."""

    def __init__(self, call: Callable[[WorkerProcess, Piece], Made],
                 stand_in: Callable[[Piece, ProcessDiedError], Made]) -> None:
        self._call, self._stand_in = call, stand_in
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
                if isinstance(error, TookLongError):
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


def check_workers(workers: int | None) -> int:
    """Number of processes; all cores where none is given.

    Raises RequestError if it is out of its range.
    """
    count = len(os.sched_getaffinity(0)) if workers is None else workers
    if not 1 <= count <= MOST_WORKERS:
        raise RequestError(f"1 to {MOST_WORKERS} workers", f"{workers}",
                           "leave it out for all cores")
    return count
