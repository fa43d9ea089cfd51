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
    """One file of a bag, and how whole it was.

    Attributes
    ----------
    bag, path : Path
    state : str
        `whole`, `open`, `cut`, `damaged` or `unreadable`.
    note : str
        The same for people; empty where it is whole.
    messages : int
        Of this package's types that were read.
    """

    bag: Path
    path: Path
    state: str
    note: str
    messages: int


@dataclass(frozen=True, eq=False)
class PartRecord:
    """What the bags hold about one part; equal names with several digests are several parts.

    Attributes
    ----------
    part_id, part_digest : str
    radius : float
        Metres; NaN where no result tells it.
    histories : tuple of ResultHistory
        One a numbering, the one with most results first.
    jobs : tuple of Job
        By time.
    forgotten : tuple of int
        When the node forgot the part, nanoseconds since 1970.
    warnings : tuple of str
        Of all results, each once.
    plates : tuple of str
        Named by results.
    drop_log : DropLog
        Drops recorded one by one.
    """

    part_id: str
    part_digest: str
    radius: float
    histories: tuple[ResultHistory, ...]
    jobs: tuple[Job, ...]
    forgotten: tuple[int, ...]
    warnings: tuple[str, ...]
    plates: tuple[str, ...]
    drop_log: DropLog


@dataclass(frozen=True, eq=False)
class BagContents:
    """All of it.

    Attributes
    ----------
    files : tuple of BagFile
    messages : dict
        How many of each type were read, copies included.
    begin, end : int
        Times of recording of the first and the last of them, nanoseconds since 1970.
    parts : tuple of PartRecord
        In the order of first appearance.
    counts : tuple of CameraCounts
    notes : tuple of str
        What could not be read or used, one sentence each.
    """

    files: tuple[BagFile, ...]
    messages: dict[str, int]
    begin: int
    end: int
    parts: tuple[PartRecord, ...]
    counts: tuple[CameraCounts, ...]
    notes: tuple[str, ...]

    @property
    def bags(self) -> tuple[Path, ...]:
        """The bags that were read."""
        return tuple(dict.fromkeys(file.bag for file in self.files))
