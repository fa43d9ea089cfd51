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

"""Which files of bags lie under paths, and their messages, of MCAP or SQLite."""

import os
import re
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from ...base.errors import BagError
from ...base.files import folders_below, open_file
from ...base.text import listed
from ...node.recording import decoding
from ...node.recording.reader import RawMessage, files_of_bag, read_messages

SQLITE = ".db3"
PACKED_SQLITE = ".db3.zstd"
ENDINGS = (".mcap", ".mcap.zstd", SQLITE, PACKED_SQLITE)

# A view, a virtual table and a generated column compute what they like.
COMPUTED = """
SELECT name FROM pragma_table_list AS list
WHERE name COLLATE NOCASE IN ('topics', 'message_definitions', 'messages') AND (
    type != 'table' OR EXISTS (SELECT 1 FROM pragma_table_xinfo(list.name) WHERE hidden)
)
"""
# SQLite keeps any kind of value in any column.
TOPICS = """
SELECT id, name, type FROM topics
WHERE serialization_format = 'cdr' AND typeof(name) = 'text' AND typeof(type) = 'text'
"""
DEFINITIONS = """
SELECT topic_type, encoded_message_definition FROM message_definitions
WHERE typeof(encoded_message_definition) = 'text'
"""
MESSAGES = """
SELECT topic_id, timestamp, data FROM messages
WHERE topic_id IN ({}) AND typeof(timestamp) = 'integer' AND typeof(data) = 'blob'
ORDER BY timestamp, id
"""

_STATE = re.compile(r"\.(sqlite3|meshes)\b")
"""In names of the node's state, which lies beside bags: `bag DIR/*` names it too."""

OnRead = Callable[[float], None]  # takes the fraction of a file that has been read


def find_bags(paths: Iterable[Path]) -> dict[Path, list[Path]]:
    """Files of all bags under the paths, each file once, in the order of recording.

    The keys are directories, or the file itself where a file was named.
    """
    bags: dict[Path, list[Path]] = {}
    resolved_files: set[Path] = set()
    for path in paths:
        if _STATE.search(path.name):
            continue
        for bag, files in _bags_under(path):
            new_files = [file for file in files if file.resolve() not in resolved_files]
            resolved_files.update(file.resolve() for file in new_files)
            if new_files:
                bags.setdefault(bag, []).extend(new_files)
    if not bags:
        raise BagError(
            "at least one bag", "none", "name a bag directory or a directory of bags"
        )
    return bags


def _bags_under(path: Path) -> list[tuple[Path, list[Path]]]:
    try:
        if not path.exists():
            raise BagError(
                "a bag directory or file",
                f"{path}, which does not exist",
                "check the path",
            )
        if path.is_file():
            return [(path, [_readable(path)])]
        # A hidden directory is a run on its way in or out.
        folders = sorted(
            {
                _readable(folder / name).parent
                for folder, names in folders_below(path)
                for name in names
                if name.endswith(ENDINGS)
            }
        )
        bags = [
            (
                folder,
                [
                    file
                    for file in (*files_of_bag(folder), *files_of_bag(folder, SQLITE))
                    if file.is_file()
                ],
            )
            for folder in folders
        ]
    except OSError as error:
        raise BagError(
            "a readable directory",
            f"{path}: {error.strerror or error}",
            "check its permissions",
        ) from error
    if not any(files for _, files in bags):
        raise BagError(
            "a directory with *.mcap files",
            f"none under {path}",
            "name a bag directory or a directory of bags",
        )
    return bags


def _readable(file: Path) -> Path:
    """The same file; compressed SQLite is refused."""
    if file.name.endswith(PACKED_SQLITE):
        raise BagError(
            "an MCAP bag, or SQLite that is not compressed", str(file), decoding.CONVERT
        )
    return file


class FileMessages:
    """Goes through a file, MCAP or SQLite in rosbag2's layout, once.

    `state`, which is right at the end: `whole`, `open` (never closed, with whole
    records), `cut` inside a record, `damaged` or `unreadable`. `note`: the same for
    people.
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
                yield from read_messages(self._file, self._damaged, self._on_read)
        except OSError as error:
            raise BagError(
                "a readable bag file",
                f"{self._file}: {error.strerror or error}",
                "check its permissions and the disk",
            ) from error

    def _set(self, state: str, note: str) -> None:
        """Set the state; damage after the first makes it `damaged`."""
        if self.state == "whole":
            self.state = state
            self.note = note
        elif state != "open":
            self.state = "damaged"
            self.note = "is damaged in several places: what is whole was read"

    def _damaged(self, start: int, end: int, size: int, reason: str) -> None:
        if start == end:
            if size:
                self._set(
                    "open",
                    "was never closed: its recorder is still running or was stopped "
                    "hard; all its records are whole",
                )
            else:
                self._set("cut", "is empty")
        elif start == 0 and end >= size:
            self._set("unreadable", "is not an MCAP file")
        elif end >= size:
            self._set(
                "cut",
                f"is cut off or damaged from byte {start} on: what stands "
                "before it was read",
            )
        else:
            self._set(
                "damaged",
                f"is damaged in bytes {start} to {end} ({reason}): the rest was read",
            )

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
            computed = [name for (name,) in base.execute(COMPUTED)]
            if computed:
                self._set("unreadable", f"has no plain table {listed(computed)}")
                return
            topics = {
                number: (name, kind)
                for number, name, kind in base.execute(TOPICS)
                if decoding.kind_of(kind)
            }
            try:
                texts = dict(base.execute(DEFINITIONS)) if topics else {}
            except sqlite3.OperationalError as error:  # from before ROS 2 Iron
                raise BagError(
                    "a bag that holds its message definitions",
                    f"{self._file}, which does not",
                    decoding.CONVERT,
                ) from error
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
