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

"""Work on a dask.distributed cluster; no other module imports that."""

import asyncio
import logging
import math
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Generic

from ...base.errors import BatchError, reason
from ...base.extras import require_modules
from ...base.version import VERSION
from .processes import POLL_SECONDS, Made, Piece, in_flight

require_modules("distributed")

from distributed import Client, Security, TimeoutError, rpc  # noqa: E402
from distributed.scheduler import KilledWorker  # noqa: E402

WORKER_SECONDS = 60.0  # time that a run waits while there is no worker at all
LOOK_SECONDS = 1.0  # time between two checks for workers
CONNECT_SECONDS = 10.0
ANSWER_SECONDS = 5.0
CLOSE_SECONDS = 5.0

LOSSES = 3
"""Times that a piece whose workers died is handed out anew.

The scheduler itself gives it to another worker three times before it counts as failed,
and it counts the pieces that a lost worker had not begun.
"""


@dataclass(frozen=True)
class ClusterWork(Generic[Piece, Made]):
    """What is to be done with each piece."""

    function: Callable[..., Made]  # of a module, so that workers find it
    arguments: Callable[[Piece], tuple[Any, ...]]  # what it is called with for a piece
    # most pieces handed out at a time, for so many threads of all workers together
    in_hand: Callable[[int], int]
    # what comes of a piece whose workers died again and again; default: the run ends
    stand_in: Callable[[Piece], Made] | None = None


def work_on_cluster(
    address: str,
    work: ClusterWork[Piece, Made],
    pieces: Sequence[Piece],
    should_stop: Callable[[], bool],
    worker_seconds: float = WORKER_SECONDS,
) -> Generator[tuple[Piece, Made], None, None]:
    """Have a scheduler's workers do work; others do the pieces of lost ones.

    `address`: such as `tcp://10.0.0.1:8786`; `worker_seconds`: longest without any
    worker.
    """
    if not pieces:
        return
    with client_of(address, should_stop) as client:
        if client is not None:
            run = _Run(client, address, work, worker_seconds)
            executor = client.get_executor(pure=False)
            yield from in_flight(
                lambda piece: executor.submit(
                    call_on_worker, VERSION, work.function, *work.arguments(piece)
                ),
                run.receive,
                pieces,
                partial(run.is_over, should_stop),
                run.in_hand,
            )


@dataclass
class _Run(Generic[Piece, Made]):
    """The state of a run on a cluster: lost pieces, and the time without workers."""

    client: Client
    address: str
    work: ClusterWork[Piece, Made]
    worker_seconds: float  # longest without any worker
    losses: Counter[Piece] = field(default_factory=Counter)
    last_worker: float = field(default_factory=time.monotonic)
    last_look: float = -math.inf
    threads: int = 0  # of all workers, at the last look

    def receive(self, future: Future[Made], piece: Piece) -> Made | None:
        """Take what was made of a piece; None where it was lost with its worker."""
        try:
            return future.result()
        except KilledWorker as error:
            self.losses[piece] += 1
            if self.losses[piece] <= LOSSES:
                return None
            if self.work.stand_in is None:
                raise _failed(error) from error
            return self.work.stand_in(piece)
        except CancelledError as error:
            raise BatchError(
                "a scheduler that stays",
                f"{self.address} gone",
                "start it again; the same command then goes on from here",
            ) from error
        except Exception as error:
            raise _failed(error) from error

    def in_hand(self) -> int:
        """Most pieces that are handed out at a time."""
        return self.work.in_hand(self.threads)

    def is_over(self, should_stop: Callable[[], bool]) -> bool:
        """Ask whether to stop, and give up where there is no worker for too long."""
        instant = time.monotonic()
        if instant >= self.last_look + LOOK_SECONDS:
            self.last_look = instant
            self.threads = _count_threads(self.client)
            if self.threads:
                self.last_worker = instant
            elif instant > self.last_worker + self.worker_seconds:
                raise BatchError(
                    "a worker at the scheduler",
                    f"none at {self.address}",
                    f"start one with `dask worker {self.address}` where this package "
                    "is installed; the same command then goes on from here",
                )
        return should_stop()


def call_on_worker(
    version: str, function: Callable[..., Made], *arguments: Any
) -> Made:
    """Do a piece on a worker that has the caller's version."""
    if version != VERSION:
        raise BatchError(
            f"ros_pose_stats {version} on the worker",
            VERSION,
            "install the same version everywhere",
        )
    return function(*arguments)


def _failed(error: Exception) -> BatchError:
    return BatchError(
        "a piece from the cluster",
        f"{type(error).__name__}: {reason(error)}",
        "see the logs of scheduler and workers, which need this package in the "
        "same version; the same command goes on from here",
    )


@contextmanager
def client_of(address: str, should_stop: Callable[[], bool]) -> Iterator[Client | None]:
    """Yield a client while the context lasts; None if stopped before there was one."""
    with _quiet():
        client = _client(address, should_stop)
        try:
            yield client
        finally:
            if client is not None:
                with suppress(TimeoutError, OSError):
                    client.close(timeout=CLOSE_SECONDS)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep tracebacks of lost connections off the terminal: errors say as much."""
    loggers = [
        logging.getLogger(name)
        for name in tuple(logging.root.manager.loggerDict)
        if name.partition(".")[0] == "distributed"
    ]
    levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL)
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _client(address: str, should_stop: Callable[[], bool]) -> Client | None:
    # A client without a scheduler prints long complaints at its end, so ask for one
    # first.
    try:
        identity = asyncio.run(_identity(address, should_stop))
        if identity is None:
            return None
        if identity.get("type") != "Scheduler":
            raise TypeError(f"a {identity.get('type')} answers")
        return Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except Exception as error:  # whatever is behind the address may answer anything
        raise BatchError(
            "a scheduler that answers",
            f"none at {address!r} ({reason(error)})",
            "start one with `dask scheduler` and give its address, such as "
            "tcp://10.0.0.1:8786",
        ) from error


def _count_threads(client: Client) -> int:
    """Threads of all workers together; 0 too where the scheduler does not answer."""
    try:
        return sum(client.nthreads(callback_timeout=ANSWER_SECONDS).values())
    except (TimeoutError, OSError):
        return 0


async def _identity(
    address: str, should_stop: Callable[[], bool]
) -> dict[str, Any] | None:
    """Identity of what answers at an address; None if stopped before."""
    request = asyncio.ensure_future(_ask(address))
    begin = time.monotonic()
    while not request.done():
        if should_stop() or time.monotonic() > begin + CONNECT_SECONDS:
            request.cancel()
        await asyncio.wait([request], timeout=POLL_SECONDS)
    if request.cancelled():
        if should_stop():
            return None
        raise TimeoutError(f"no answer in {CONNECT_SECONDS:g} s")
    return request.result()


async def _ask(address: str) -> dict[str, Any]:
    arguments = Security().get_connection_args("client")
    async with rpc(address, connection_args=arguments) as scheduler:
        answer: dict[str, Any] = await scheduler.identity()
        return answer
