"""The rows of a catalogue as they come, appended to a file that survives whatever ends the run.

A row lies on a line of its own. The last line of a file is the one that holds; a line that was cut
off or damaged counts for nothing. Only places are kept in memory.
"""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

from ..errors import BatchError, reason
from ..files import open_file, sync_directory, write_all
from .request import PartFile
from .rows import Described, Row

ROWS = "parts.jsonl"

SYNC_SECONDS = 1.0
"""A power cut costs the rows of this time, anything else not one."""


class Entry(NamedTuple):
    """Where the row of a file is, and what is to be known about it without reading it."""

    part: PartFile
    picture: str
    to_be_dropped: bool
    refused: bool
    offset: int
    length: int


class RowLog:
    """The rows of a catalogue; `entries` has the place of the latest row of each file's name.

    `folder`: of the catalogue, locked by whoever makes it. Raises BatchError if the file cannot be
    read or written.
    """

    def __init__(self, folder: Path) -> None:
        path = folder / ROWS
        self.path = path
        self.entries: dict[str, Entry] = {}
        try:
            self._number = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
            self._end = self._read()
            os.ftruncate(self._number, self._end)
            sync_directory(folder)
        except OSError as error:
            raise self._failed(error) from error
        self._synced = time.monotonic()

    def __enter__(self) -> RowLog:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        os.close(self._number)

    def append(self, part: PartFile, made: Described, picture: str) -> None:
        """Add a row.

        `picture`: name of the file of its picture; empty where it has none.
        """
        line = json.dumps({**part._asdict(), "picture": picture,
                           "to_be_dropped": made.to_be_dropped,
                           "seconds": round(made.seconds, 4), "row": made.row}).encode() + b"\n"
        try:
            end = write_all(self._number, [line], self._end)
            if time.monotonic() >= self._synced + SYNC_SECONDS:
                self.sync()
        except OSError as error:
            raise self._failed(error) from error
        self.entries[part.name] = Entry(part, picture, made.to_be_dropped,
                                        bool(made.row["refusal"]), self._end, len(line))
        self._end = end

    def sync(self) -> None:
        """Wait until the disk has all rows."""
        os.fsync(self._number)
        self._synced = time.monotonic()

    def row(self, name: str) -> Row:
        """The latest row of a file."""
        entry = self.entries[name]
        row: Row = json.loads(os.pread(self._number, entry.length, entry.offset))["row"]
        return row

    def _read(self) -> int:
        """Find the rows that are there; returns the end of the last whole line."""
        offset = 0
        with open_file(self.path) as lines:
            for line in lines:
                if not line.endswith(b"\n"):
                    break
                entry = _entry(line, offset)
                if entry is not None:
                    self.entries[entry.part.name] = entry
                offset += len(line)
        return offset

    def _failed(self, error: OSError) -> BatchError:
        return BatchError("a disk that takes the rows", f"{self.path} ({reason(error)})",
                          "make room; the same command then goes on from here")


def _entry(line: bytes, offset: int) -> Entry | None:
    """What a line holds; None for one that is damaged or of an older version."""
    try:
        found: dict[str, Any] = json.loads(line)
        part = PartFile(*(found[name] for name in PartFile._fields))
        row = found["row"]
        assert row["file"] == part.name
        assert row["refusal"] or "unit_declared" in row  # as older versions did not say
        return Entry(part, found["picture"], found["to_be_dropped"], bool(row["refusal"]), offset,
                     len(line))
    except (ValueError, LookupError, TypeError, AssertionError):
        return None
