"""Makes the parts of a catalogue in processes of this machine."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

from ..batch.processes import check_workers, work_in_processes
from ..batch.worker import ProcessDiedError, TookLongError, WorkerProcess
from ..errors import RequestError
from .making import Maker, Piece
from .request import CatalogueRequest
from .rows import Described, describe_part, refused

MOST_THREADS = 8
"""Of a process for the drops of its part: the last part, which may be the longest, has the cores
that the others have left."""

ESTIMATE_SECONDS, DROP_SECONDS = 600.0, 3 * 3600.0
"""A part that takes longer is refused, since one that never ends would hold back all tables.

Estimates take a second, rarely a minute. Ten million drops, the most that a target error costs,
take nine parts of ten an hour and a half on one core; tables of the estimates are there meanwhile.
"""


def on_processes(workers: int | None = None) -> Maker:
    """Parts made by processes of this machine; one that dies costs its own part alone."""
    processes = check_workers(workers)
    threads = min(processes, MOST_THREADS)

    def make(request: CatalogueRequest, pieces: Sequence[Piece],
             should_stop: Callable[[], bool]) -> Generator[tuple[Piece, Described], None, None]:
        def call(process: WorkerProcess, piece: Piece) -> Described:
            return describe_within_limit(process, request, piece, threads)

        yield from work_in_processes(processes, call, died, pieces, should_stop)

    return make


def describe_within_limit(process: WorkerProcess, request: CatalogueRequest, piece: Piece,
                          threads: int = 1) -> Described:
    """Look at a part in a process, which is ended if that never ends.

    Raises ProcessDiedError if the process ended; a `TookLongError` if it took too long.
    """
    part, drop = piece
    return process.call_within(_limit(drop), describe_part, part.name, None, request, drop,
                               threads)


def _limit(drop: bool) -> float:
    return DROP_SECONDS if drop else ESTIMATE_SECONDS


def died(piece: Piece, how: ProcessDiedError) -> Described:
    """What comes of a part whose process died, from how it ended."""
    part, drop = piece
    why = (f"the process that looked at it {how}, and so did a second one; export the part anew, "
           "or in fewer faces")
    if isinstance(how, TookLongError):
        done, remedy = (("dropped", "ask for a larger target error") if drop else
                        ("looked at", "export it in fewer faces"))
        why = str(RequestError(f"a part that is {done} within {_limit(drop):g} s",
                             "one that takes longer", remedy))
    return Described(refused(part.name, why), None, False, 0.0)
