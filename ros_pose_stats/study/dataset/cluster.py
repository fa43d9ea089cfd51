"""Makes the pieces of a dataset on a dask.distributed cluster."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from typing import TYPE_CHECKING

from ...errors import DatasetError
from ...version import VERSION
from .archive import Arrays, reason
from .making import POLL_SECONDS, Made, Maker, Piece, make_chunk
from .spec import DatasetSpec

if TYPE_CHECKING:
    from distributed import Client, Future

WORKER_SECONDS = 60.0
"""How long a run waits while there is no worker at all."""

LOOK_SECONDS = 1.0
"""Between two looks for workers."""

FETCH_SECONDS = 30.0
"""For fetching a piece that is done; longer means that its worker has gone."""

LOSSES = 3
"""A piece whose workers died is handed out anew this often.

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
        If dask.distributed is not installed; while running, if the scheduler cannot be
        reached or goes away, no worker comes, or a piece fails.
    """
    try:
        from .scheduler import client_of
    except ImportError as error:
        raise DatasetError("dask.distributed", f"none that can be imported ({reason(error)})",
                           "install it with `pip install distributed`") from error

    def make(spec: DatasetSpec, pieces: Sequence[Piece],
             should_stop: Callable[[], bool]) -> Generator[Made, None, None]:
        if not pieces:
            return
        with client_of(address, should_stop) as client:
            if client is not None:
                run = _Run(client, address, spec, worker_seconds)
                yield from run.made(pieces, should_stop)

    return make


class _Run:
    """Pieces in the hands of a cluster."""

    def __init__(self, client: Client, address: str, spec: DatasetSpec,
                 worker_seconds: float) -> None:
        self._client = client
        self._address = address
        self._spec = spec
        self._worker_seconds = worker_seconds
        self._pieces: dict[Future[Arrays], Piece] = {}
        self._losses: Counter[Piece] = Counter()
        self._seen = self._looked = time.monotonic()

    def made(self, pieces: Sequence[Piece],
             should_stop: Callable[[], bool]) -> Generator[Made, None, None]:
        """Pieces as they are done; a scheduler that goes away fails them all at once."""
        from distributed import as_completed

        waiting = as_completed([self._hand_out(piece) for piece in pieces], loop=self._client.loop)
        while self._pieces and not should_stop():
            if not waiting.has_ready():
                self._look_for_workers()
                time.sleep(POLL_SECONDS)
                continue
            future = next(waiting)
            piece = self._pieces.pop(future)
            arrays = self._result(future, piece)
            if arrays is None:
                waiting.add(self._hand_out(piece))
            else:
                yield piece, arrays

    def _hand_out(self, piece: Piece) -> Future[Arrays]:
        future = self._client.submit(chunk_there, VERSION, self._spec, *piece, pure=False)
        self._pieces[future] = piece
        return future

    def _result(self, future: Future[Arrays], piece: Piece) -> Arrays | None:
        """What a worker made; None where it was lost with its worker."""
        from distributed import TimeoutError as Late
        from distributed.scheduler import KilledWorker

        try:
            arrays: Arrays = future.result(timeout=FETCH_SECONDS)
            return arrays
        except (KilledWorker, Late) as error:
            self._losses[piece] += 1
            if self._losses[piece] > LOSSES:
                raise _failed(error) from error
            return None
        except Exception as error:
            if future.cancelled():
                raise DatasetError("a scheduler that stays", f"{self._address} gone",
                                   "start it again; the same command then goes on from "
                                   "here") from error
            raise _failed(error) from error

    def _look_for_workers(self) -> None:
        """Refuse to wait for ever where there is no worker."""
        now = time.monotonic()
        if now < self._looked + LOOK_SECONDS:
            return
        self._looked = now
        from .scheduler import has_workers

        if has_workers(self._client):
            self._seen = now
        elif now > self._seen + self._worker_seconds:
            raise DatasetError("a worker at the scheduler", f"none at {self._address}",
                               f"start one with `dask worker {self._address}` where this package "
                               "is installed; the same command then goes on from here")


def chunk_there(version: str, spec: DatasetSpec, first: int, count: int) -> Arrays:
    """Make a piece on a worker, if that has the caller's version."""
    if version != VERSION:
        raise DatasetError(f"ros_pose_stats {version} on the worker", VERSION,
                           "install the same version everywhere")
    return make_chunk(spec, first, count)


def _failed(error: Exception) -> DatasetError:
    return DatasetError("a piece from the cluster", f"{type(error).__name__}: {reason(error)}",
                        "see the logs of scheduler and workers, which need this package in the "
                        "same version; the same command goes on from here")
