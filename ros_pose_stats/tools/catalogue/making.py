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

"""Makes a catalogue: all parts with some drops first, then those that need more.

Parts are made by processes of this machine, or by a dask.distributed cluster.
"""

import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from ...base import errors, files, worker
from ...core.simulation.request import check_workers
from ..batch import processes
from ..batch.folder import WorkFolder, needing_room
from .page import CHUNKS, PAGE, PageState, common_folder, write_page
from .request import CatalogueRequest, PartFile
from .rows import Described, Row, content_of, describe_part, refused
from .store import ROWS, TABLES, Entry, RowStore, Tally, tally, write_tables

CLAIM = "request.json"
PICTURES = "pictures"

Piece = tuple[PartFile, bool]
"""A file, and whether the part is dropped until it is as sure as was asked for."""

Answers = Generator[tuple[Piece, Described], None, None]
Maker = Callable[[CatalogueRequest, Sequence[Piece], Callable[[], bool]], Answers]
"""Makes pieces and yields each when it is done, until told to stop."""


@dataclass(frozen=True)
class CatalogueProgress:
    """State of a run."""

    parts: int  # done in all
    bound: int  # parts to be done
    earlier_parts: int  # done before this run began
    dropping: bool  # whether parts get more drops, after the rows of all
    seconds: float  # since this stage began


@dataclass(frozen=True)
class Catalogue:
    """What was made."""

    folder: Path
    page: Path
    tables: list[Path]
    row_count: int  # in the tables
    bound: int  # parts that there are
    earlier_rows: int  # made by an earlier run
    # rows that are not as sure as the target error asks, as the run was stopped
    to_be_dropped: int
    tally: Tally  # what the rows come to: those that were refused, and warnings
    rows: list[Row] | None  # where they were to be kept

    @property
    def complete(self) -> bool:
        """Whether every part has the row that was asked for."""
        return self.row_count == self.bound and not self.to_be_dropped


def make_catalogue(
    folder: Path,
    parts: Sequence[PartFile],
    request: CatalogueRequest,
    maker: Maker,
    *,
    parquet: bool,
    keep_rows: bool,
    on_progress: Callable[[CatalogueProgress], object],
    should_stop: Callable[[], bool],
) -> Catalogue:
    """Make a catalogue, or go on where an earlier run was cut off.

    Rows of files that have not changed since are kept; so a folder to which parts were
    added costs the new ones alone. The same files and request give the same tables, by
    whichever `maker`. `keep_rows`: whether to return the rows; hundreds of thousands
    fill the memory.
    """
    work_files = [folder / name for name in (ROWS, PAGE, *TABLES)]
    with (
        WorkFolder(
            folder,
            CLAIM,
            request.as_dict(),
            lambda: any(file.exists() for file in work_files),
            "a catalogue",
        ),
        closing(RowStore(folder)) as store,
    ):
        for written_to in (folder, folder / CHUNKS):
            files.remove_unfinished(written_to)
        run = _Run(folder, parts, request, store, maker, on_progress, should_stop)
        new_parts = run.parts_without_row()
        run.collect(new_parts, dropping=False)
        if run.unsure_parts() and not should_stop():
            run.write(parquet)  # to be looked at while parts are dropped
            run.collect(run.unsure_parts(), dropping=True)
        tables, tally_of_rows = run.write(parquet)
        names = run.names_with_row()
        return Catalogue(
            folder,
            folder / PAGE,
            tables,
            len(names),
            len(parts),
            len(parts) - len(new_parts),
            len(run.unsure_parts()),
            tally_of_rows,
            [store.row(name) for name in names] if keep_rows else None,
        )


class _Run(NamedTuple):
    """A run in a folder."""

    folder: Path
    parts: Sequence[PartFile]
    request: CatalogueRequest
    store: RowStore
    maker: Maker
    on_progress: Callable[[CatalogueProgress], object]
    should_stop: Callable[[], bool]

    def parts_without_row(self) -> list[PartFile]:
        """Files without a row of what they hold now, or refused: that may go well."""
        return [
            part
            for part in self.parts
            if (entry := self._entry(part)) is None or entry.refused
        ]

    def unsure_parts(self) -> list[PartFile]:
        """Files whose rows are not sure enough."""
        return [
            part
            for part in self.parts
            if (entry := self._entry(part)) is not None and entry.to_be_dropped
        ]

    def collect(self, parts: Sequence[PartFile], dropping: bool) -> None:
        """Have parts made and keep them as they come."""
        begin = time.monotonic()
        bound = len(self.parts)
        earlier = bound - len(parts)
        self.on_progress(CatalogueProgress(earlier, bound, earlier, dropping, 0.0))
        pieces = [(part, dropping) for part in parts]
        with closing(self.maker(self.request, pieces, self.should_stop)) as answers:
            for done, ((part, _), described) in enumerate(answers, start=earlier + 1):
                self.store.keep(part, described, self._keep_picture(described))
                seconds = time.monotonic() - begin
                self.on_progress(
                    CatalogueProgress(done, bound, earlier, dropping, seconds)
                )
        self.store.sync()

    def names_with_row(self) -> list[str]:
        """Names of the files that have a row."""
        return [part.name for part in self.parts if self._entry(part) is not None]

    def write(self, parquet: bool) -> tuple[list[Path], Tally]:
        """Write tables and page of what is there, and count what it comes to."""
        names = self.names_with_row()

        def rows() -> Iterator[Row]:
            return map(self.store.row, names)

        tables = write_tables(self.folder, rows, parquet)
        tally_of_rows = tally(rows())
        state = PageState(
            len(names),
            len(self.parts),
            len(self.unsure_parts()),
            tally_of_rows,
            common_folder(part.name for part in self.parts),
        )
        pictures = (
            entry.picture
            for name in names
            if (entry := self.store.entry(name)) is not None
        )
        write_page(self.folder, self.request, state, zip(rows(), pictures, strict=True))
        return tables, tally_of_rows

    def _entry(self, part: PartFile) -> Entry | None:
        """The entry of a file as it is now; None without a row or its picture."""
        entry = self.store.entry(part.name)
        if entry is None or entry.part != part:
            return None
        try:
            picture = self.folder / entry.picture
            if entry.picture and not (picture.is_file() and picture.stat().st_size):
                return None
        except OSError:
            return None
        return entry

    def _keep_picture(self, described: Described) -> str:
        """Write the picture under a name that equal parts share."""
        if described.picture is None:
            return ""
        digest = described.row["part_digest"]
        name = f"{PICTURES}/{digest[:2]}/{digest[:16]}.png"
        file = self.folder / name
        with needing_room("the pictures", file):
            file.parent.mkdir(parents=True, exist_ok=True)
            file.unlink(missing_ok=True)  # it may be a pipe, or a link to elsewhere
            file.write_bytes(described.picture)
        return name


MOST_THREADS = 8
"""Of a process for the drops of its part: the last part, which may be the longest, has
the cores that the others have left."""

SECONDS = (600.0, 3 * 3600.0)
"""Of a first row, and of more drops. What takes longer is refused: it would hold back
all tables.

First rows take a second, rarely a minute. Ten million drops, the most that a target
error costs, take nine parts of ten an hour and a half on one core; tables of the
first rows are there meanwhile.
"""


def on_processes(workers: int | None) -> Maker:
    """Parts made by processes of this machine; a death costs one part alone."""
    count = check_workers(workers)

    def make(
        request: CatalogueRequest,
        pieces: Sequence[Piece],
        should_stop: Callable[[], bool],
    ) -> Answers:
        return processes.work_in_processes(
            count,
            lambda process, piece: describe_within_limit(
                process, request, piece, min(count, MOST_THREADS)
            ),
            refuse_dead,
            pieces,
            should_stop,
        )

    return make


def describe_within_limit(
    process: worker.WorkerProcess,
    request: CatalogueRequest,
    piece: Piece,
    threads: int = 1,
) -> Described:
    """Look at a part in a process, which is ended if that never ends."""
    part, drop = piece
    return process.call_within(
        SECONDS[drop], describe_part, part.name, None, request, drop, threads
    )


def refuse_dead(piece: Piece, death: worker.ProcessDiedError) -> Described:
    """What comes of a part whose process died, from how it ended."""
    part, drop = piece
    reason = (
        f"the process that looked at it {death}, and so did a second one; export the "
        "part anew, or in fewer faces"
    )
    if isinstance(death, worker.TookLongError):
        task = "dropped" if drop else "looked at"
        remedy = "ask for a larger target error" if drop else "export it in fewer faces"
        refusal = errors.RequestError(
            f"a part that is {task} within {SECONDS[drop]:g} s",
            "one that takes longer",
            remedy,
        )
        reason = str(refusal)
    return Described(refused(part.name, reason), None, False, 0.0)


MOST_TOGETHER = 8  # estimates that are handed out in a bundle

FEWEST_BUNDLES = 50
"""A scheduler takes milliseconds for each bundle, and there should be enough to share
out."""

FEWEST_BUNDLES_OUT = 4
BUNDLES_A_THREAD = 4
"""Bundles handed out at a time: their files go along, into the scheduler's memory."""

Bundle = tuple[Piece, ...]


def on_cluster(address: str) -> Maker:
    """Parts made by the workers of a scheduler; lost workers' parts are made by others.

    The files are read here and sent, so that workers need not see them. Parts whose
    workers died again and again are made in a process of this machine, where that harms
    nobody.
    """
    from ..batch.cluster import ClusterWork, work_on_cluster

    def make(
        request: CatalogueRequest,
        pieces: Sequence[Piece],
        should_stop: Callable[[], bool],
    ) -> Answers:
        work: ClusterWork[Bundle, list[Described]] = ClusterWork(
            describe_bundle,
            lambda bundle: (
                [(part.name, content_of(part.name), drop) for part, drop in bundle],
                request,
            ),
            lambda threads: max(FEWEST_BUNDLES_OUT, BUNDLES_A_THREAD * threads),
            lambda bundle: [_describe_locally(request, piece) for piece in bundle],
        )
        for bundle, answers in work_on_cluster(
            address, work, bundles(pieces), should_stop
        ):
            yield from zip(bundle, answers, strict=True)

    return make


def bundles(pieces: Sequence[Piece]) -> list[Bundle]:
    """Pieces as they are handed out: those to be dropped one by one."""
    dropping = any(drop for _, drop in pieces)
    size = 1 if dropping else max(1, min(MOST_TOGETHER, len(pieces) // FEWEST_BUNDLES))
    return [
        tuple(pieces[first : first + size]) for first in range(0, len(pieces), size)
    ]


def describe_bundle(
    contents: list[tuple[str, bytes | errors.PoseStatsError, bool]],
    request: CatalogueRequest,
) -> list[Described]:
    """Look at the parts of a bundle, one after the other."""
    return [
        describe_part(name, content, request, drop) for name, content, drop in contents
    ]


def _describe_locally(request: CatalogueRequest, piece: Piece) -> Described:
    process = worker.WorkerProcess()
    try:
        return describe_within_limit(process, request, piece)
    except worker.ProcessDiedError as error:
        return refuse_dead(piece, error)
    finally:
        process.kill()
