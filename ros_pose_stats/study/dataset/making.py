"""Makes a dataset piece by piece, on this machine's cores or on a cluster's."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from threading import Event

from ...errors import DatasetError, RequestError
from ...simulation.request import MOST_WORKERS
from .archive import read_archive, write_archive
from .chunk import make_chunk
from .fields import Arrays
from .spec import DatasetSpec
from .unfinished import Unfinished, clear_leftovers

Piece = tuple[int, int]
Made = tuple[Piece, Arrays]
Maker = Callable[[DatasetSpec, Sequence[Piece], Callable[[], bool]],
                 Generator[Made, None, None]]
"""From a specification, pieces and a question whether to stop to pieces as they are done."""

POLL_SECONDS = 0.05


@dataclass(frozen=True)
class DatasetProgress:
    """State of a run.

    Attributes
    ----------
    bodies, bound : int
        Done in all, and wanted.
    found : int
        Of those done, how many were there when this run began.
    seconds : float
        Since this run began.
    """

    bodies: int
    bound: int
    found: int
    seconds: float


def make_dataset(file: Path, spec: DatasetSpec, maker: Maker, *,
                 on_progress: Callable[[DatasetProgress], object] = lambda _: None,
                 should_stop: Callable[[], bool] = lambda: False) -> bool:
    """Make a dataset, or go on where an earlier run was cut off.

    Parameters
    ----------
    file : Path
        Written when everything is done; until then the pieces lie in `<file>.unfinished`.
        If the same dataset stands there, nothing is done.
    spec : DatasetSpec
    maker : callable
        `on_threads(n)`, or `on_cluster(address)` of `cluster`; the results are the same.
    on_progress : callable, optional
        Told a `DatasetProgress` after each piece.
    should_stop : callable, optional
        Asked some twenty times a second; True ends the run with the pieces that are done.

    Returns
    -------
    bool
        Whether the dataset is complete.

    Raises
    ------
    DatasetError
        If another dataset or other pieces are in the way, or nothing can be written.
    """
    if _is_there(file, spec):
        clear_leftovers(file, spec)
        return True
    with Unfinished(file, spec) as unfinished:
        if _is_there(file, spec):  # another run finished just now
            unfinished.remove()
            return True
        done = unfinished.done()
        begin, found = time.monotonic(), sum(count for _, count in done)
        bodies = found
        on_progress(DatasetProgress(bodies, spec.bodies, found, 0.0))
        missing = [piece for piece in spec.chunks if piece not in set(done)]
        with closing(maker(spec, missing, should_stop)) as made:
            for piece, arrays in made:
                unfinished.put(piece, arrays)
                bodies += piece[1]
                on_progress(DatasetProgress(bodies, spec.bodies, found,
                                            time.monotonic() - begin))
        if bodies < spec.bodies:
            return False
        write_archive(file, spec, unfinished.pieces())
        unfinished.remove()
    return True


def _is_there(file: Path, spec: DatasetSpec) -> bool:
    """Whether the dataset is done; refuses a file that holds something else."""
    try:
        if not file.exists():
            return False
    except OSError as error:
        raise DatasetError("a file name that the file system takes",
                           f"{file} ({error.strerror})", "name another one with -o") from error
    there, _ = read_archive(file)
    if there != spec:
        others = ", ".join(f"{name} {value}" for name, value in there.as_dict().items()
                           if value != spec.as_dict()[name])
        raise DatasetError("a file that is not there yet, or the same dataset",
                           f"another one in {file} ({others})", "name another file with -o")
    return True


def on_threads(workers: int | None = None) -> Maker:
    """Pieces made by threads of this process; the kernels run without the interpreter's lock.

    Parameters
    ----------
    workers : int, optional
        Threads; default: all cores.
    """
    threads = len(os.sched_getaffinity(0)) if workers is None else workers
    if not 1 <= threads <= MOST_WORKERS:
        raise RequestError(f"1 to {MOST_WORKERS} workers", f"{workers}",
                           "leave it out for all cores")

    def make(spec: DatasetSpec, pieces: Sequence[Piece],
             should_stop: Callable[[], bool]) -> Generator[Made, None, None]:
        with ThreadPoolExecutor(threads) as pool:
            yield from _in_flight(pool, spec, pieces, should_stop, 2 * threads)

    return make


def _in_flight(pool: ThreadPoolExecutor, spec: DatasetSpec, pieces: Sequence[Piece],
               should_stop: Callable[[], bool], most: int) -> Generator[Made, None, None]:
    """Hand out a few pieces at a time; once stopped, those in hand are given up."""
    waiting = list(reversed(pieces))
    busy: dict[Future[Arrays], Piece] = {}
    ended = Event()
    try:
        while (waiting or busy) and not should_stop():
            while waiting and len(busy) < most:
                piece = waiting.pop()
                busy[pool.submit(make_chunk, spec, *piece, ended.is_set)] = piece
            for future in wait(busy, POLL_SECONDS, FIRST_COMPLETED).done:
                yield busy.pop(future), future.result()
    finally:
        ended.set()
        for future in busy:
            future.cancel()
