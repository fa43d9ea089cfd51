"""Who makes the parts of a catalogue: processes of this machine, or a dask.distributed cluster."""

from collections.abc import Callable, Generator, Sequence

from ..batch.processes import check_workers, work_in_processes
from ..batch.worker import ProcessDiedError, TookLongError, WorkerProcess
from ..errors import PoseStatsError, RequestError
from .making import Maker, Piece
from .request import CatalogueRequest
from .rows import Described, content_of, describe_part, refused

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


MOST_TOGETHER, FEWEST_BUNDLES = 8, 50
"""Estimates that are handed out in a bundle, since a scheduler takes milliseconds for each; fewer
where there would be too few bundles to share out."""

FEWEST_IN_HAND, IN_HAND_A_THREAD = 4, 4
"""Bundles handed out at a time: what files hold is sent along, into the scheduler's memory."""

Bundle = tuple[Piece, ...]


def on_cluster(address: str) -> Maker:
    """Parts made by the workers of a scheduler; lost workers' parts are made by others.

    The files are read here and sent, so that workers need not see them. Parts whose workers
    died again and again are made in a process of this machine, where that harms nobody.

    Raises BatchError while running if the scheduler cannot be reached or goes away, or no worker
    comes; ImportError at once where distributed is not installed.
    """
    from ..batch.cluster import ClusterWork, work_on_cluster

    def make(request: CatalogueRequest, pieces: Sequence[Piece],
             should_stop: Callable[[], bool]) -> Generator[tuple[Piece, Described], None, None]:
        work: ClusterWork[Bundle, list[Described]] = ClusterWork(
            describe_bundle, lambda bundle: (_contents(bundle), request),
            lambda threads: max(FEWEST_IN_HAND, IN_HAND_A_THREAD * threads),
            lambda bundle: [_make_here(request, piece) for piece in bundle])
        for bundle, made in work_on_cluster(address, work, bundles(pieces), should_stop):
            yield from zip(bundle, made, strict=True)

    return make


def bundles(pieces: Sequence[Piece]) -> list[Bundle]:
    """Pieces as they are handed out: those to be dropped, which take long, one by one."""
    dropping = any(drop for _, drop in pieces)
    size = 1 if dropping else max(1, min(MOST_TOGETHER, len(pieces) // FEWEST_BUNDLES))
    return [tuple(pieces[first:first + size]) for first in range(0, len(pieces), size)]


Contents = list[tuple[str, "bytes | PoseStatsError", bool]]


def _contents(bundle: Bundle) -> Contents:
    return [(part.name, content_of(part.name), drop) for part, drop in bundle]


def describe_bundle(contents: Contents, request: CatalogueRequest) -> list[Described]:
    """Look at the parts of a bundle, one after the other."""
    return [describe_part(name, content, request, drop) for name, content, drop in contents]


def _make_here(request: CatalogueRequest, piece: Piece) -> Described:
    process = WorkerProcess()
    try:
        return describe_within_limit(process, request, piece)
    except ProcessDiedError as error:
        return died(piece, error)
    finally:
        process.kill()
