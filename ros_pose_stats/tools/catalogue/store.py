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

"""The rows of a catalogue: in a file of SQLite, counted, and as tables."""

import json
import os
import sqlite3
import time
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from ...base import errors, extras, files, text
from ...core.mesh.units import unit_in_words
from ...core.records.notes import Note, note_of_sentence
from ..batch.folder import needing_room
from .request import PartFile
from .rows import Described, Row

ROWS = "parts.sqlite3"
SYNC_SECONDS = 1.0
"""A power cut costs the rows of this time; anything else, as a kill, costs none."""

TABLE = """CREATE TABLE IF NOT EXISTS parts (
    name BLOB PRIMARY KEY, bytes INTEGER, mtime_ns INTEGER, picture TEXT,
    to_be_dropped INTEGER, refused INTEGER, seconds REAL, row TEXT) WITHOUT ROWID"""


SEAL = 8
"""Characters of the checksum before a row: SQLite looks at no content."""


class Entry(NamedTuple):
    """What is to be known about the row of a file without reading it."""

    part: PartFile
    picture: str  # file of its picture; empty where it has none
    to_be_dropped: bool
    refused: bool


class RowStore:
    """The latest row of each file, in a folder that the caller has locked."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / ROWS
        with self._refusing():
            files.refuse_irregular(self.path)
            # Nobody else has the folder, so that a file system need not share memory
            # for WAL.
            self._rows = sqlite3.connect(self.path, isolation_level=None)
            self._rows.executescript(
                "PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; "
                f"PRAGMA synchronous=NORMAL; {TABLE}"
            )
        self._synced = time.monotonic()

    def close(self) -> None:
        """Let go of the file, and of one without any row."""
        with self._refusing():
            empty = self._rows.execute("SELECT 1 FROM parts LIMIT 1").fetchone() is None
            self._rows.close()
        if empty:
            self.path.unlink()

    def keep(self, part: PartFile, described: Described, picture: str) -> None:
        """Add or replace the row of a file; `picture` as in `Entry`."""
        with self._refusing():
            self._rows.execute(
                "REPLACE INTO parts VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                (
                    os.fsencode(part.name),
                    part.bytes,
                    part.mtime_ns,
                    picture,
                    described.to_be_dropped,
                    bool(described.row["refusal"]),
                    round(described.seconds, 4),
                    _sealed(json.dumps(described.row)),
                ),
            )
        if time.monotonic() >= self._synced + SYNC_SECONDS:
            self.sync()

    def sync(self) -> None:
        """Wait until the disk has all rows."""
        with self._refusing():
            self._rows.execute("PRAGMA wal_checkpoint").fetchall()
        self._synced = time.monotonic()

    def entry(self, name: str) -> Entry | None:
        """What is known of a file; None where it has no row."""
        with self._refusing():
            rows = self._rows.execute(
                "SELECT bytes, mtime_ns, picture, to_be_dropped, refused FROM parts "
                "WHERE name = ?",
                (os.fsencode(name),),
            ).fetchall()
        if not rows:
            return None
        size, mtime, picture, to_be_dropped, refused = rows[0]
        return Entry(
            PartFile(name, size, mtime), picture, bool(to_be_dropped), bool(refused)
        )

    def row(self, name: str) -> Row:
        """The row of a file that has one."""
        with self._refusing():
            ((stored,),) = self._rows.execute(
                "SELECT row FROM parts WHERE name = ?", (os.fsencode(name),)
            ).fetchall()
            columns = str(stored)[SEAL:]
            if _sealed(columns) != stored:
                raise sqlite3.DatabaseError("a row is not as it was written")
        row: Row = json.loads(columns)
        return row

    @contextmanager
    def _refusing(self) -> Iterator[None]:
        try:
            with needing_room(
                "the rows", self.path, (OSError, sqlite3.OperationalError)
            ):
                yield
        except sqlite3.DatabaseError as error:
            raise errors.BatchError(
                "the rows of an earlier run",
                f"{self.path} ({error})",
                "delete it; all parts are then looked at again",
            ) from error


def _sealed(columns: str) -> str:
    return f"{zlib.crc32(columns.encode()):08x}{columns}"


ALIKE = 1.05
"""Factor up to which lengths of a part differ by how finely its files are cut."""

ONE_WAY = 0.9  # share of the best pose from which on a part is said to lie one way


@dataclass
class Tally:
    """Counts over rows."""

    answered: int = 0  # parts that were not refused
    one_way: int = 0  # those of them whose best pose has at least `ONE_WAY`
    # parts whose unit is a guess, by its name
    guessed: Counter[str] = field(default_factory=Counter)
    doubted: int = 0  # parts with other warnings
    # files by the code of these
    warnings: dict[str, list[str]] = field(default_factory=dict)
    # parts by the code of what asks for nothing
    notes: Counter[str] = field(default_factory=Counter)
    # reasons by the names of the files
    refused: dict[str, str] = field(default_factory=dict)
    # lengths by the names of files whose stem another file has, of a part that differs
    unlike: dict[str, str] = field(default_factory=dict)

    @property
    def codes(self) -> str:
        """The codes of warnings with their numbers, in words."""
        by_number = sorted(self.warnings.items(), key=lambda item: -len(item[1]))
        return ", ".join(f"{code} {len(files)}" for code, files in by_number)

    @property
    def guesses(self) -> str:
        """How many units are guessed, and as what, in words; empty for none."""
        return ", ".join(
            f"{text.several(count, 'unit')} guessed as {name}"
            for name, count in self.guessed.most_common()
        )


def doubts_of(row: Row) -> list[Note]:
    """What to act on, but a guessed unit, which a catalogue gives once for all."""
    return [
        warning
        for warning in notes_of(row)
        if warning.acts and warning.code != "UNIT_GUESSED"
    ]


def notes_of(row: Row) -> list[Note]:
    """The warnings of a row; version 0.2.0 wrote them as sentences."""
    return [
        note_of_sentence(warning) if isinstance(warning, str) else Note(**warning)
        for warning in row.get("warnings", ())
    ]


def tally(rows: Iterable[Row]) -> Tally:
    """Count what rows say."""
    counts = Tally()
    first: dict[Path, tuple[str, float]] = {}
    for row in rows:
        if row["refusal"]:
            counts.refused[row["file"]] = row["refusal"]
            continue
        counts.answered += 1
        share = row["best_share"]
        counts.one_way += share is not None and share >= ONE_WAY
        if row["unit_guessed"]:
            counts.guessed[unit_in_words(row["unit_m"])] += 1
        codes = {warning.code for warning in doubts_of(row)}
        counts.doubted += bool(codes)
        for code in sorted(codes):
            counts.warnings.setdefault(code, []).append(row["file"])
        counts.notes.update({note.code for note in notes_of(row) if not note.acts})
        # However the part is turned in its file.
        length = max(pose["footprint_length_m"] for pose in row["poses"])
        file, first_length = first.setdefault(
            Path(row["file"]).with_suffix(""), (row["file"], length)
        )
        if not 1.0 / ALIKE <= length / first_length <= ALIKE:
            counts.unlike[row["file"]] = (
                f"{text.length_in_words(length)} long, {file} "
                f"{text.length_in_words(first_length)}"
            )
    return counts


COLUMNS: dict[str, type] = {
    "file": str,
    "part_digest": str,
    "unit_m": float,
    "unit_guessed": bool,
    "triangles": int,
    "size_x_m": float,
    "size_y_m": float,
    "size_z_m": float,
    "stable_poses": int,
    "distinct_poses": int,
    "method": str,
    "drops": int,
    "expected_error": float,
    "largest_error": float,
    "best_pose": int,
    "best_share": float,
    "best_share_low": float,
    "best_share_high": float,
    "entropy_bits": float,
    "passes": float,
    "passes_low": float,
    "passes_high": float,
    "footprint_length_m": float,
    "footprint_width_m": float,
    "top_m": float,
    "warnings": str,
    "notes": str,
    "refusal": str,
}
"""Of `catalogue.csv`, with the kind of their values. Shares and errors are
fractions."""

POSE_COLUMNS: dict[str, type] = {
    "file": str,
    "part_digest": str,
    "pose": int,
    "group": int,
    "group_size": int,
    "group_share": float,
    "group_share_low": float,
    "group_share_high": float,
    "probability": float,
    "probability_low": float,
    "probability_high": float,
    "standard_error": float,
    "count": int,
    "footprint_length_m": float,
    "footprint_width_m": float,
    "top_m": float,
    "height_m": float,
    "margin_rad": float,
    "barrier_m": float,
    "rolls": bool,
}
"""Of `poses.csv`."""

PARTS = "catalogue"
POSES = "poses"
TABLES = tuple(
    f"{name}.{kind}" for name in (PARTS, POSES) for kind in ("csv", "parquet")
)
BETWEEN = " | "  # between the warnings and notes of a part
AT_ONCE = 20_000  # rows of a Parquet table in memory
Table = tuple[dict[str, type], Iterator[Sequence[Any]]]


def load_parquet() -> None:
    """Import what Parquet files need."""
    extras.require_modules("pyarrow", "pyarrow.parquet")


def write_tables(
    folder: Path, rows: Callable[[], Iterable[Row]], parquet: bool
) -> list[Path]:
    """Write all tables, each whole or not at all; Parquet of an earlier run goes.

    `rows`: gives all rows from the first one, each time anew.
    """

    def write(temporary: Path) -> None:
        for name, (columns, values) in _tables(rows).items():
            # Names of files need not be UTF-8.
            with (temporary / f"{name}.csv").open(
                "w", encoding="utf-8", errors="surrogateescape", newline=""
            ) as stream:
                stream.writelines(text.csv_lines(columns, values))
        if parquet:
            for name, (columns, values) in _tables(rows).items():
                _write_parquet(temporary / f"{name}.parquet", columns, values)

    with needing_room("the tables", folder):
        written = files.write_whole(folder, write)
        for name in set(TABLES) - {file.name for file in written}:
            (folder / name).unlink(missing_ok=True)
    return written


def _tables(rows: Callable[[], Iterable[Row]]) -> dict[str, Table]:
    parts = (
        {
            **row,
            **{
                name: BETWEEN.join(
                    str(warning) for warning in notes_of(row) if warning.acts is acts
                )
                for name, acts in (("warnings", True), ("notes", False))
            },
        }
        for row in rows()
    )
    poses = ({**row, **pose} for row in rows() for pose in row.get("poses", ()))
    return {
        PARTS: (COLUMNS, ([row.get(name) for name in COLUMNS] for row in parts)),
        POSES: (
            POSE_COLUMNS,
            ([row.get(name) for name in POSE_COLUMNS] for row in poses),
        ),
    }


def _write_parquet(
    file: Path, columns: dict[str, type], rows: Iterator[Sequence[Any]]
) -> None:
    import pyarrow
    from pyarrow import parquet

    kinds = {
        str: pyarrow.string(),
        int: pyarrow.int64(),
        float: pyarrow.float64(),
        bool: pyarrow.bool_(),
    }
    schema = pyarrow.schema([(name, kinds[kind]) for name, kind in columns.items()])
    with parquet.ParquetWriter(file, schema) as writer:
        while portion := list(islice(rows, AT_ONCE)):
            # Names that are not UTF-8 have what is none of it replaced.
            columns_of = [
                [
                    value.encode(errors="replace").decode()
                    if isinstance(value, str)
                    else value
                    for value in column
                ]
                for column in zip(*portion, strict=True)
            ]
            writer.write_table(
                pyarrow.table(dict(zip(columns, columns_of, strict=True)), schema)
            )
