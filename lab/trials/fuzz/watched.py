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

"""Inputs tried in a process of their own, so that one that hangs or crashes is caught
and named.

A thread or an alarm would not do: compiled code is not interrupted, and a crash takes
the whole process.
"""

from __future__ import annotations

import multiprocessing
import os
import time
import traceback
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ros_pose_stats import PoseStatsError, part_from_mesh

from .judge import faults
from .kinds import KINDS, case
from .sameness import differences, undecided

LIMIT = 30.0
"""Seconds of the processor that one small input may take, drops included.

Most take 10 ms. The longest are drops of bodies with almost no inertia, which lose
energy by little in very many steps until they are given up: three of them take eight
seconds.
"""

STANDING = 10.0
"""How many times longer it may take on a machine with a lot else to do, before it
counts as one that stands still.
"""

LOOK = 1.0
"""Seconds between looks at the time of the processor."""

IN_OTHER_WAYS = 5.0
"""How many times longer an input may take that is given in other ways too."""

STARTING = 900.0
"""Seconds to start and to compile what is not in the cache."""


class Tried(NamedTuple):
    """What became of an input: why it was refused, what must not be, and how long it
    took.

    `compared` says `same` where the body was given in other ways too, or why rounding
    decides there; of a large input it says what it is.
    """

    seed: int
    refusal: str = ""
    faults: tuple[str, ...] = ()
    compared: str = ""
    seconds: float = 0.0


def attempt(kind: str, seed: int, thorough: bool) -> Tried:
    """Make an input, hand it over, and judge what comes of it."""
    begin = time.perf_counter()
    refusal = ""
    compared = ""
    wrong = []
    try:
        vertices, triangles, options = case(kind, seed)
        begin = time.perf_counter()
        part = part_from_mesh(vertices, triangles, **options)
        wrong = list(faults(part, seed, thorough))
        if thorough and KINDS[kind].same:
            compared = undecided(part) or "same"
            if compared == "same":
                wrong += differences(part, np.random.default_rng(seed))
    except PoseStatsError as error:
        refusal = str(error)
        if len(refusal.splitlines()) != 1:
            wrong.append("a refusal of several lines")
    except Exception as error:  # whatever it is, it is a fault
        frame = traceback.extract_tb(error.__traceback__)[-1]
        wrong.append(
            f"{type(error).__name__}: {error} ({frame.name}, line {frame.lineno})"
        )
    fate = KINDS[kind].fate
    if refusal and fate == "taken":
        wrong.append(f"refused: {refusal}")
    if not refusal and not wrong and fate == "refused":
        wrong.append("taken")
    return Tried(
        seed,
        refusal,
        tuple(dict.fromkeys(wrong)),
        compared,
        time.perf_counter() - begin,
    )


def serve(connection: Connection, trial: Callable[..., Tried]) -> None:
    """Try what is asked for until the other side closes; a warning is a fault."""
    warnings.simplefilter("error")
    attempt(
        "polyhedron", 0, True
    )  # compiles what is not compiled yet, in nobody's time
    connection.send(None)
    while True:
        try:
            job = connection.recv()
        except EOFError:
            return
        connection.send(trial(*job))


def _processor_seconds(pid: int) -> float:
    """What a process has taken of the processor until now; 0 of one that has ended."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text("utf-8")
    except FileNotFoundError:
        return 0.0
    _, _, fields = text.rpartition(") ")
    user, system = map(int, fields.split()[11:13])
    return (user + system) / os.sysconf("SC_CLK_TCK")


class Watched:
    """A process that tries inputs, started anew after one that it did not survive."""

    def __init__(
        self, trial: Callable[..., Tried] = attempt, limit: float = LIMIT
    ) -> None:
        self._trial = trial
        self._limit = limit  # seconds of the processor that an input may take
        self._process: Any = None
        self._connection: Connection | None = None

    def __enter__(self) -> Watched:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop()

    def tried(self, name: str, seed: int, thorough: bool = False) -> Tried:
        """Try one input; a fault where it takes too long or ends the process."""
        connection = self._connection or self._start()
        connection.send((name, seed, thorough))
        limit = self._limit * (IN_OTHER_WAYS if thorough else 1.0)
        fault = f"no answer within {limit:g} s of the processor"
        try:
            if self._answers(connection, limit):
                return connection.recv()
        except EOFError:
            self._process.join()
            fault = f"the process ended with status {self._process.exitcode}"
        self._stop()
        return Tried(seed, faults=(fault,), seconds=self._limit)

    def _answers(self, connection: Connection, limit: float) -> bool:
        """Wait for an answer; whether it came in time."""
        usage = _processor_seconds(self._process.pid) + limit
        end = time.monotonic() + STANDING * limit
        while not connection.poll(LOOK):
            if time.monotonic() > end or _processor_seconds(self._process.pid) > usage:
                return False
        return True

    def _start(self) -> Connection:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(
            target=serve, args=(theirs, self._trial), daemon=True
        )
        self._process.start()
        theirs.close()
        if not self._connection.poll(STARTING):
            raise TimeoutError(f"no start within {STARTING:g} s")
        self._connection.recv()
        return self._connection

    def _stop(self) -> None:
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            self._process.kill()
            self._process.join()
        self._connection = self._process = None
