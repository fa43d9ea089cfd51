"""Which bags lie under the paths that a user names, and the messages in each of their files."""

import os
import re
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from ...errors import BagError
from ...files import open_file
from ..reader import RawMessage, files_of_bag, raw_messages
from .decoding import CONVERT, kind_of

SQLITE = ".db3"
PACKED_SQLITE = ".db3.zstd"
ENDINGS = (".mcap", ".mcap.zstd", SQLITE, PACKED_SQLITE)

TOPICS = "SELECT id, name, type FROM topics WHERE serialization_format = 'cdr'"
DEFINITIONS = "SELECT topic_type, encoded_message_definition FROM message_definitions"
MESSAGES = "SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({}) " \
           "ORDER BY timestamp, id"

_STATE = re.compile(r"\.(sqlite3|meshes)\b")
"""In names of what lies beside bags and is the node's state: `bag DIR/*` names it too."""

OnRead = Callable[[float], None]  # told which fraction of a file has been read


def find_bags(paths: Iterable[Path]) -> dict[Path, list[Path]]:
    """Files of all bags under the paths, each file once, in the order of recording.

    The keys are directories, or the file itself where a file was named.
    """
    bags: dict[Path, list[Path]] = {}
    known: set[Path] = set()
    for path in paths:
        if _STATE.search(path.name):
            continue
        for bag, files in _bags_under(path):
            new = [file for file in files if file.resolve() not in known]
            known.update(file.resolve() for file in new)
            if new:
                bags.setdefault(bag, []).extend(new)
    if not bags:
        raise BagError("at least one bag", "none", "name a bag directory or a directory of bags")
    return bags


def _bags_under(path: Path) -> list[tuple[Path, list[Path]]]:
    if not path.exists():
        raise BagError("a bag directory or file", f"{path}, which does not exist",
                       "check the path")
    if path.is_file():
        return [(path, [_readable(path)])]
    try:
        # A hidden directory is a run on its way in or out.
        folders = sorted({_readable(file).parent for file in path.rglob("*")
                          if file.name.endswith(ENDINGS) and not any(
                              part.startswith(".") for part in file.relative_to(path).parts)})
        bags = [(folder, [file for file in (*files_of_bag(folder),
                                            *sorted(folder.glob(f"*{SQLITE}"))) if file.is_file()])
                for folder in folders]
    except OSError as error:
        raise BagError("a readable directory", f"{path}: {error.strerror or error}",
                       "check its permissions") from error
    if not any(files for _, files in bags):
        raise BagError("a directory with *.mcap files", f"none under {path}",
                       "name a bag directory or a directory of bags")
    return bags


def _readable(file: Path) -> Path:
    """The same file; compressed SQLite is refused."""
    if file.name.endswith(PACKED_SQLITE):
        raise BagError("an MCAP bag, or SQLite that is not compressed", f"{file}", CONVERT)
    return file


class FileMessages:
    """Goes through a file, MCAP or SQLite in rosbag2's layout, once.

    `state`, known then: `whole`, `open` (never closed, with whole records), `cut` inside a record,
    `damaged` or `unreadable`. `note`: the same for people.
    """

    def __init__(self, file: Path, on_read: OnRead) -> None:
        self._file = file
        self._on_read = on_read
        self.state = "whole"
        self.note = ""

    def __iter__(self) -> Iterator[RawMessage]:
        """Messages in the order of the file; BagError where it cannot be read."""
        try:
            if self._file.suffix == SQLITE:
                yield from self._sqlite_messages()
            else:
                yield from raw_messages(self._file, self._damaged, self._on_read)
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

    def _damaged(self, start: int, end: int, reason: str) -> None:
        size = self._file.stat().st_size
        if start == end:
            self._set(*(("open", "was never closed: its recorder is still running or was stopped "
                         "hard; all its records are whole") if size else ("cut", "is empty")))
        elif start == 0 and end >= size:
            self._set("unreadable", "is not an MCAP file")
        elif end >= size:
            self._set("cut", f"is cut off or damaged from byte {start} on: what stands "
                      "before it was read")
        else:
            self._set("damaged", f"is damaged in bytes {start} to {end} "
                      f"({reason}): the rest was read")

    def _sqlite_messages(self) -> Iterator[RawMessage]:
        """Messages of this package's types, by the time of recording."""
        with open_file(self._file) as stream:
            size = stream.seek(0, os.SEEK_END)
        if not size:
            self._set("cut", "is empty")
            return
        base = sqlite3.connect(f"{self._file.resolve().as_uri()}?mode=ro", uri=True)
        read = 0
        try:
            topics = {number: (name, kind) for number, name, kind in base.execute(TOPICS)
                      if kind_of(kind)}
            try:
                texts = dict(base.execute(DEFINITIONS)) if topics else {}
            except sqlite3.OperationalError as error:  # from before ROS 2 Iron
                raise BagError("a bag that holds its message definitions",
                               f"{self._file}, which does not", CONVERT) from error
            query = MESSAGES.format(", ".join("?" * len(topics)))
            for number, time, data in base.execute(query, tuple(topics)):
                name, kind = topics[number]
                read += len(data)
                self._on_read(min(1.0, read / size))
                yield RawMessage(name, kind, bytes(data), time, texts.get(kind, ""))
        except sqlite3.DatabaseError as error:
            self._set("damaged", f"is damaged ({error}): what could be read was")
        finally:
            base.close()
