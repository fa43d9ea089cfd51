"""Inputs tried in a process of their own, so that one that hangs or crashes is caught and named.

A thread or an alarm would not do: compiled code is not interrupted, and a crash takes the whole
process.
"""

from __future__ import annotations

import multiprocessing
import os
import warnings
from collections.abc import Callable, Iterable, Iterator
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, NamedTuple

from .meshes import KINDS
from .trial import Outcome, attempt

LIMIT = 30.0
"""Seconds that one small input may take, drops included, on a machine with a lot else to do.

Most take 10 ms. The longest are drops of bodies with almost no inertia, which lose energy by
little in very many steps until they are given up: three of them take eight seconds.
"""

IN_OTHER_WAYS = 5.0
"""How many times longer an input may take that is given in other ways too."""

STARTING = 900.0
"""Seconds to start and to compile what is not in the cache."""


class Job(NamedTuple):
    """An input to try."""

    kind: str
    seed: int
    thorough: bool = False


def serve(connection: Connection) -> None:
    """Try the small inputs that are asked for."""
    warnings.simplefilter("error")  # a warning is a fault, as in the tests
    for kind in KINDS:
        attempt(kind, 0, thorough=True)
    answer(connection, attempt)


def answer(connection: Connection, trial: Callable[..., Outcome]) -> None:
    """Say that all is ready, then try what is asked for until the other side closes."""
    connection.send(None)
    while True:
        try:
            job = connection.recv()
        except EOFError:
            return
        connection.send(trial(*job))


class Watched:
    """A process that tries inputs, started anew after one that it did not survive.

    Parameters
    ----------
    limit : float
        Seconds an input may take.
    target : callable
        What the process runs, `serve` or a stand-in for it.
    """

    def __init__(self, limit: float = LIMIT, target: Any = serve) -> None:
        self.limit = limit
        self.target = target
        self._process: Any = None
        self._connection: Connection | None = None

    def __enter__(self) -> Watched:
        self._start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._stop()

    def outcomes(self, jobs: Iterable[Job]) -> Iterator[Outcome]:
        """Try one input after the other."""
        for job in jobs:
            yield self.outcome(job)

    def outcome(self, job: Job) -> Outcome:
        """Try one input; a fault where it takes too long or ends the process."""
        connection = self._connection or self._start()
        connection.send(job)
        fault = f"no answer within {self.limit:g} s"
        try:
            if connection.poll(self.limit * (IN_OTHER_WAYS if job.thorough else 1.0)):
                return connection.recv()
        except EOFError:
            self._process.join()
            fault = f"the process ended with status {self._process.exitcode}"
        self._stop()
        return Outcome(job.kind, job.seed, faults=(fault,), seconds=self.limit)

    def _start(self) -> Connection:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=self.target, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()
        if not self._connection.poll(STARTING):
            raise TimeoutError(f"no start within {STARTING:g} s")
        self._connection.recv()
        return self._connection

    def _stop(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None


def give_way(niceness: int = 10) -> None:
    """Let other programs of this machine go first."""
    os.nice(niceness)
