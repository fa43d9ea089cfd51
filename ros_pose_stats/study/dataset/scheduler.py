"""A client of a dask.distributed scheduler: refused in time, and quiet when that goes away.

The only module that imports dask.distributed as it is loaded.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from distributed import Client, Security, TimeoutError, rpc

from ...errors import DatasetError
from .archive import reason
from .making import POLL_SECONDS

CONNECT_SECONDS = 10.0
CLOSE_SECONDS = 5.0
ANSWER_SECONDS = 5.0


@contextmanager
def client_of(address: str, should_stop: Callable[[], bool]) -> Iterator[Client | None]:
    """A client while the context lasts; None if stopped before there was one.

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
    """Keep its log, tracebacks of a lost connection, off the terminal; the errors say it all."""
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
    # A client that finds no scheduler complains at length as it ends: ask for one first.
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


def has_workers(client: Client) -> bool:
    """Whether the scheduler has a worker; not, if it does not answer."""
    try:
        return bool(client.nthreads(callback_timeout=ANSWER_SECONDS))
    except (TimeoutError, OSError):
        return False


async def _identity(address: str, should_stop: Callable[[], bool]) -> dict[str, Any] | None:
    """What answers at an address; None if stopped before."""
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
