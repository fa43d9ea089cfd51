"""Makes the pieces of a dataset on a dask.distributed cluster; no other module imports that."""

from __future__ import annotations

import asyncio
import logging
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

from distributed import Client, Security, TimeoutError, rpc
from distributed.scheduler import KilledWorker

from ...errors import DatasetError
from ...version import VERSION
from .archive import Arrays, reason
from .making import POLL_SECONDS, Made, Maker, Piece, in_flight, make_chunk
from .spec import DatasetSpec

WORKER_SECONDS = 60.0
"""Time that a run waits while there is no worker at all."""

LOOK_SECONDS = 1.0
"""Time between two checks for workers."""

CONNECT_SECONDS, ANSWER_SECONDS, CLOSE_SECONDS = 10.0, 5.0, 5.0

IN_HAND = 2000
"""Pieces handed out at a time."""

LOSSES = 3
"""Times that a piece whose workers died is handed out anew.

The scheduler itself gives it to another worker three times before it counts as failed, and
it counts the pieces that a lost worker had not begun.
"""


def on_cluster(address: str, worker_seconds: float = WORKER_SECONDS) -> Maker:
    """Pieces made by the workers of a scheduler; lost workers' pieces are made by others.

    Parameters
    ----------
    address : str
        Of the scheduler, such as `tcp://10.0.0.1:8786`. It and the workers need this package
        in this version; on machines of one kind they give the same numbers as this one.
    worker_seconds : float
        How long to wait while there is no worker at all.

    Raises
    ------
    DatasetError
        While running: if the scheduler cannot be reached or goes away, no worker comes, or a
        piece fails.
    """
    def make(spec: DatasetSpec, pieces: Sequence[Piece],
             should_stop: Callable[[], bool]) -> Generator[Made, None, None]:
        if not pieces:
            return
        with client_of(address, should_stop) as client:
            if client is not None:
                run = _Run(client, address, worker_seconds)
                executor = client.get_executor(pure=False)
                yield from in_flight(
                    lambda piece: executor.submit(chunk_there, VERSION, spec, *piece),
                    run.receive, pieces, partial(run.is_over, should_stop), IN_HAND)

    return make


class _Run:
    """The state of a run on a cluster: lost pieces, and the time without workers."""

    def __init__(self, client: Client, address: str, worker_seconds: float) -> None:
        self._client = client
        self._address = address
        self._worker_seconds = worker_seconds
        self._losses: Counter[Piece] = Counter()
        self._seen = self._looked = time.monotonic()

    def receive(self, future: Future[Arrays], piece: Piece) -> Arrays | None:
        """Take the arrays of a piece; None where they were lost with their worker."""
        try:
            return future.result()
        except KilledWorker as error:
            self._losses[piece] += 1
            if self._losses[piece] > LOSSES:
                raise _failed(error) from error
            return None
        except CancelledError as error:
            raise DatasetError("a scheduler that stays", f"{self._address} gone",
                               "start it again; the same command then goes on from here"
                               ) from error
        except Exception as error:
            raise _failed(error) from error

    def is_over(self, should_stop: Callable[[], bool]) -> bool:
        """Ask whether to stop, and give up where there is no worker for too long."""
        now = time.monotonic()
        if now >= self._looked + LOOK_SECONDS:
            self._looked = now
            if _has_workers(self._client):
                self._seen = now
            elif now > self._seen + self._worker_seconds:
                raise DatasetError(
                    "a worker at the scheduler", f"none at {self._address}",
                    f"start one with `dask worker {self._address}` where this package is "
                    "installed; the same command then goes on from here")
        return should_stop()


def chunk_there(version: str, spec: DatasetSpec, first: int, count: int) -> Arrays:
    """Make a piece on a worker that has the caller's version."""
    if version != VERSION:
        raise DatasetError(f"ros_pose_stats {version} on the worker", VERSION,
                           "install the same version everywhere")
    return make_chunk(spec, first, count)


def _failed(error: Exception) -> DatasetError:
    return DatasetError("a piece from the cluster", f"{type(error).__name__}: {reason(error)}",
                        "see the logs of scheduler and workers, which need this package in the "
                        "same version; the same command goes on from here")


@contextmanager
def client_of(address: str, should_stop: Callable[[], bool]) -> Iterator[Client | None]:
    """Yield a client while the context lasts; None if stopped before there was one.

    Raises
    ------
    DatasetError
        If no scheduler answers there.
    """
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
    """Keep tracebacks of lost connections off the terminal, since the errors say the same."""
    loggers = [logging.getLogger(name) for name in tuple(logging.root.manager.loggerDict)
               if name.partition(".")[0] == "distributed"]
    levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL)
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _client(address: str, should_stop: Callable[[], bool]) -> Client | None:
    # A client without a scheduler prints long complaints at its end, so ask for one first.
    try:
        found = asyncio.run(_identity(address, should_stop))
        if found is None:
            return None
        if found.get("type") != "Scheduler":
            raise TypeError(f"a {found.get('type')} answers")
        return Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except Exception as error:  # whatever is behind the address may answer anything
        raise DatasetError("a scheduler that answers", f"none at {address!r} ({reason(error)})",
                           "start one with `dask scheduler` and give its address, such as "
                           "tcp://10.0.0.1:8786") from error


def _has_workers(client: Client) -> bool:
    """Whether the scheduler answers and has a worker."""
    try:
        return bool(client.nthreads(callback_timeout=ANSWER_SECONDS))
    except (TimeoutError, OSError):
        return False


async def _identity(address: str, should_stop: Callable[[], bool]) -> dict[str, Any] | None:
    """Identity of what answers at an address; None if stopped before."""
    asked = asyncio.ensure_future(_ask(address))
    begin = time.monotonic()
    while not asked.done():
        if should_stop() or time.monotonic() > begin + CONNECT_SECONDS:
            asked.cancel()
        await asyncio.wait([asked], timeout=POLL_SECONDS)
    if asked.cancelled():
        if should_stop():
            return None
        raise TimeoutError(f"no answer in {CONNECT_SECONDS:g} s")
    return asked.result()


async def _ask(address: str) -> dict[str, Any]:
    arguments = Security().get_connection_args("client")
    async with rpc(address, connection_args=arguments) as scheduler:
        answer: dict[str, Any] = await scheduler.identity()
        return answer
