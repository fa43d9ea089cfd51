"""The rows of a catalogue as they come, in a file of SQLite, and what they come to."""

import json
import os
import sqlite3
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from ..errors import BatchError
from ..files import refuse_irregular
from ..text import code_of
from .request import PartFile
from .rows import Described, Row

ROWS = "parts.sqlite3"
SYNC_SECONDS = 1.0  # a power cut costs the rows of this time; anything else, as a kill, costs none

TABLE = """CREATE TABLE IF NOT EXISTS parts (
    name BLOB PRIMARY KEY, bytes INTEGER, mtime_ns INTEGER, picture TEXT, to_be_dropped INTEGER,
    refused INTEGER, seconds REAL, row TEXT) WITHOUT ROWID"""


class Entry(NamedTuple):
    """What is to be known about the row of a file without reading it."""

    part: PartFile
    picture: str  # file of its picture; empty where it has none
    to_be_dropped: bool
    refused: bool


class RowStore:
    """The latest row of each file, in a folder that is locked by whoever makes the catalogue."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / ROWS
        with self._refusing():
            refuse_irregular(self.path)
            # Nobody else has the folder, so that a file system need not share memory for WAL.
            self._rows = sqlite3.connect(self.path, isolation_level=None)
            self._rows.executescript(
                "PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; "
                f"PRAGMA synchronous=NORMAL; {TABLE}")
        self._synced = time.monotonic()

    def close(self) -> None:
        """Let go of the file."""
        self._rows.close()

    def keep(self, part: PartFile, made: Described, picture: str) -> None:
        """Add or replace the row of a file; `picture` as in `Entry`."""
        with self._refusing():
            self._rows.execute("REPLACE INTO parts VALUES (?, ?, ?, ?, ?, ?, ?, ?)", (
                os.fsencode(part.name), part.bytes, part.mtime_ns, picture, made.to_be_dropped,
                bool(made.row["refusal"]), round(made.seconds, 4), json.dumps(made.row)))
        if time.monotonic() >= self._synced + SYNC_SECONDS:
            self.sync()

    def sync(self) -> None:
        """Wait until the disk has all rows."""
        with self._refusing():
            self._rows.execute("PRAGMA wal_checkpoint").fetchall()
        self._synced = time.monotonic()

    def entry(self, name: str) -> Entry | None:
        """What is known of a file; None where it has no row."""
        with self._refusing(), closing(self._rows.execute(
                "SELECT bytes, mtime_ns, picture, to_be_dropped, refused FROM parts "
                "WHERE name = ?", (os.fsencode(name),))) as rows:
            found = rows.fetchone()
        if found is None:
            return None
        size, mtime, picture, to_be_dropped, refused = found
        return Entry(PartFile(name, size, mtime), picture, bool(to_be_dropped), bool(refused))

    def row(self, name: str) -> Row:
        """The row of a file that has one."""
        with self._refusing(), closing(self._rows.execute(
                "SELECT row FROM parts WHERE name = ?", (os.fsencode(name),))) as rows:
            row: Row = json.loads(rows.fetchone()[0])
        return row

    @contextmanager
    def _refusing(self) -> Iterator[None]:
        try:
            yield
        except (sqlite3.OperationalError, OSError) as error:
            raise BatchError("a disk that takes the rows", f"{self.path} ({error})",
                             "make room; the same command then goes on from here") from error
        except sqlite3.DatabaseError as error:
            raise BatchError("the rows of an earlier run", f"{self.path} ({error})",
                             "delete it; all parts are then looked at again") from error


ONE_WAY = 0.9  # share of the best pose from which on a part is said to lie one way


@dataclass
class Tally:
    """Counts over rows."""

    # parts that were not refused, and those of them whose best pose has at least `ONE_WAY`
    answered: int = 0
    one_way: int = 0
    doubted: int = 0  # parts with warnings
    # parts by the code of a warning, the most frequent first when listed
    warnings: Counter[str] = field(default_factory=Counter)
    refused: dict[str, str] = field(default_factory=dict)  # reasons by the names of the files

    @property
    def codes(self) -> str:
        """The codes of warnings with their numbers, in words."""
        return ", ".join(f"{code} {count}" for code, count in self.warnings.most_common())


def tally(rows: Iterable[Row]) -> Tally:
    """Count what rows say."""
    counted = Tally()
    for row in rows:
        if row["refusal"]:
            counted.refused[row["file"]] = row["refusal"]
            continue
        counted.answered += 1
        share = row["best_share"]
        counted.one_way += share is not None and share >= ONE_WAY
        codes = set(map(code_of, row["warnings"]))
        counted.doubted += bool(codes)
        counted.warnings.update(sorted(codes))
    return counted
