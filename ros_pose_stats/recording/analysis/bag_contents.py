"""Everything of this package's messages that lies in a number of bags."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from .camera_counts import CameraCounts
from .jobs import DropLog, Job
from .results import ResultHistory

Paths: TypeAlias = "str | os.PathLike[str] | Iterable[str | os.PathLike[str]]"


@dataclass(frozen=True)
class BagFile:
    """One file of a bag, and how whole it was."""

    bag: Path
    path: Path
    state: str  # `whole`, `open`, `cut`, `damaged` or `unreadable`
    note: str  # the same for people; empty where it is whole
    messages: int  # of this package's types that were read


@dataclass(frozen=True, eq=False)
class PartRecord:
    """What the bags hold about one part; equal names with several digests are several parts."""

    part_id: str
    part_digest: str
    radius: float  # metres; NaN where no result tells it
    histories: tuple[ResultHistory, ...]  # one a numbering, the one with most results first
    jobs: tuple[Job, ...]  # by time
    forgotten: tuple[int, ...]  # when the node forgot the part, nanoseconds since 1970
    warnings: tuple[str, ...]  # of all results, each once
    plates: tuple[str, ...]  # named by results
    drop_log: DropLog  # drops recorded one by one


@dataclass(frozen=True, eq=False)
class BagContents:
    """All of it."""

    files: tuple[BagFile, ...]
    messages: dict[str, int]  # how many of each type were read, copies included
    begin: int  # times of recording of the first and the last of them, nanoseconds since 1970
    end: int
    parts: tuple[PartRecord, ...]  # in the order of first appearance
    counts: tuple[CameraCounts, ...]
    notes: tuple[str, ...]  # what could not be read or used, one sentence each

    @property
    def bags(self) -> tuple[Path, ...]:
        """The bags that were read."""
        return tuple(dict.fromkeys(file.bag for file in self.files))
