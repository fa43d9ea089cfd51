"""Makes the parts of a catalogue on a dask.distributed cluster."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

from ..batch.cluster import WORKER_SECONDS, ClusterWork, work_on_cluster
from ..batch.worker import ProcessDiedError, WorkerProcess
from ..errors import PoseStatsError
from .making import Maker, Piece
from .processes import describe_within_limit, died
from .request import CatalogueRequest
from .rows import Described, content_of, describe_part

MOST_TOGETHER, FEWEST_BUNDLES = 8, 50
"""Estimates that are handed out in a bundle, since a scheduler takes milliseconds for each; fewer
where there would be too few bundles to share out."""

FEWEST_IN_HAND, IN_HAND_A_THREAD = 4, 4
"""Bundles handed out at a time: what files hold is sent along, into the scheduler's memory."""

Bundle = tuple[Piece, ...]


def on_cluster(address: str, worker_seconds: float = WORKER_SECONDS) -> Maker:
    """Parts made by the workers of a scheduler; lost workers' parts are made by others.

    The files are read here and sent, so that workers need not see them. Parts whose workers
    died again and again are made in a process of this machine, where that harms nobody.

    Raises BatchError: while running: if the scheduler cannot be reached or goes away, or no worker
    comes.
    """
    def make(request: CatalogueRequest, pieces: Sequence[Piece],
             should_stop: Callable[[], bool]) -> Generator[tuple[Piece, Described], None, None]:
        work: ClusterWork[Bundle, list[Described]] = ClusterWork(
            describe_bundle, lambda bundle: (_contents(bundle), request),
            lambda threads: max(FEWEST_IN_HAND, IN_HAND_A_THREAD * threads),
            lambda bundle: [_make_here(request, piece) for piece in bundle])
        for bundle, made in work_on_cluster(address, work, bundles(pieces), should_stop,
                                            worker_seconds):
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
