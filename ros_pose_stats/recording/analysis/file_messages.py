"""Messages of one file of a bag, and how whole the file was found."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...errors import BagError
from ..reader.raw_reader import Damage, RawMessage, raw_messages
from .bag_files import SQLITE
from .sqlite_messages import sqlite_messages


class FileMessages:
    """Goes through a file once.

    Parameters
    ----------
    file : Path
        MCAP, or SQLite in rosbag2's layout.

    Attributes
    ----------
    state : str
        `whole`; `open` (never closed, but every record is whole); `cut` (it ends inside a
        record); `damaged`; or `unreadable`. Known once the messages are through.
    note : str
        The same for people; empty where it is whole.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        self.state = "whole"
        self.note = ""

    def __iter__(self) -> Iterator[RawMessage]:
        """Messages in the order of the file.

        Raises
        ------
        BagError
            If the file cannot be read.
        """
        try:
            if self._file.suffix == SQLITE:
                yield from sqlite_messages(self._file, self._set)
            else:
                yield from raw_messages(self._file, self._damaged)
        except OSError as error:
            raise BagError("a readable bag file", f"{self._file}: {error.strerror or error}",
                           "check its permissions and the disk") from error

    def _set(self, state: str, note: str) -> None:
        """Remember what was found; what comes after the first only makes it `damaged`."""
        if self.state == "whole":
            self.state, self.note = state, note
        elif state != "open":
            self.state = "damaged"
            self.note = "is damaged in several places: what is whole was read"

    def _damaged(self, damage: Damage) -> None:
        size = self._file.stat().st_size
        if damage.start == damage.end:
            self._set(*(("open", "was never closed: its recorder is still running or was stopped "
                         "hard; all its records are whole") if size else ("cut", "is empty")))
        elif damage.start == 0 and damage.end >= size:
            self._set("unreadable", "is not an MCAP file")
        elif damage.end >= size:
            self._set("cut", f"is cut off or damaged from byte {damage.start} on: what stands "
                      "before it was read")
        else:
            self._set("damaged", f"is damaged in bytes {damage.start} to {damage.end} "
                      f"({damage.reason}): the rest was read")
