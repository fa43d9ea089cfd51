"""Messages of a rosbag2 bag in SQLite, as `ros2 bag record -s sqlite3` writes it."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from ...errors import BagError
from ..reader.raw_reader import RawMessage
from .bag_files import CONVERT
from .decoding import is_ours

TOPICS: Final = "SELECT id, name, type FROM topics WHERE serialization_format = 'cdr'"
DEFINITIONS: Final = "SELECT topic_type, encoded_message_definition FROM message_definitions"
MESSAGES: Final = "SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({}) " \
                  "ORDER BY timestamp, id"


def sqlite_messages(file: Path, tell: Callable[[str, str], None]) -> Iterator[RawMessage]:
    """Messages of this package's types, by the time of recording.

    Parameters
    ----------
    file : Path
    tell : callable
        Told state and note of a file that is not whole.

    Raises
    ------
    BagError
        If the file is from before ROS 2 Iron, when bags did not hold message definitions.
    OSError
        If it cannot be read.
    """
    with file.open("rb") as stream:
        if not stream.read(1):
            tell("cut", "is empty")
            return
    base = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)
    try:
        topics = {number: (name, kind) for number, name, kind in base.execute(TOPICS)
                  if is_ours(kind)}
        texts = _definitions(base, file) if topics else {}
        query = MESSAGES.format(", ".join("?" * len(topics)))
        for number, time, data in base.execute(query, tuple(topics)):
            name, kind = topics[number]
            yield RawMessage(name, kind, bytes(data), time, texts.get(kind, ""))
    except sqlite3.DatabaseError as error:
        tell("damaged", f"is damaged ({error}): what could be read was")
    finally:
        base.close()


def _definitions(base: sqlite3.Connection, file: Path) -> dict[str, str]:
    try:
        return dict(base.execute(DEFINITIONS))
    except sqlite3.OperationalError as error:
        raise BagError("a bag that holds its message definitions", f"{file}, which does not",
                       CONVERT) from error
