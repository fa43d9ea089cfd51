"""Where a message lies in the bags of earlier runs, and reading it there again."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ...errors import BagError
from ...recording.reader.raw_reader import RawMessage, messages_from, raw_messages
from ...recording.reader.run_identity import bags_in, identity_of

_NEAR = 1 << 16
"""Bytes before a message's place where it is looked for: mending may have moved it."""


class Place(NamedTuple):
    """What finds a message, also once its run was mended, copied or renamed."""

    run: str  # as in `RunIdentity`
    time: int  # when it was recorded [ns since 1970]; no two messages of a run have the same
    check: int  # CRC-32 of its bytes
    file: str  # name of the file that it was in
    offset: int  # where in that file its record began; -1 where that is not known


def place_of(run: str, message: RawMessage) -> Place:
    """The place of a message that was read."""
    return Place(run, message.log_time, zlib.crc32(message.data), message.file, message.offset)


def place_text(place: Place) -> str:
    """A place as it is recorded."""
    return json.dumps(place._asdict())


def place_from(text: str) -> Place:
    """A place as it was recorded; ValueError, TypeError or KeyError for other texts."""
    found = json.loads(text)
    return Place(str(found["run"]), int(found["time"]), int(found["check"]),
                 str(found["file"]), int(found["offset"]))


def read_at(log_directory: Path, place: Place) -> bytes:
    """The bytes of a message.

    Raises BagError: the run is gone, or does not hold these bytes any more.
    """
    for bag in _bags_of(log_directory, place.run):
        with suppress(OSError):
            for data in _candidates(bag, place):
                if zlib.crc32(data) == place.check:
                    return data
    raise BagError(f"the mesh that run {place.run} recorded",
                   "no bag that still holds it", "send the part again")


def _bags_of(log_directory: Path, run: str) -> Iterator[Path]:
    """The run's directory and its copies, whatever they are called."""
    usual = log_directory / run
    if usual.is_dir():
        yield usual
    with suppress(OSError):
        for bag in bags_in(log_directory):
            with suppress(OSError):
                found = identity_of(bag) if bag != usual else None
                if found is not None and found.run == run:
                    yield bag


def _candidates(bag: Path, place: Place) -> Iterator[bytes]:
    """What was recorded at that time: near its place, or else anywhere in the bag."""
    if place.offset >= 0 and (bag / place.file).is_file():
        for time, data in messages_from(bag / place.file, max(0, place.offset - _NEAR)):
            if time == place.time:
                yield data
            if time >= place.time:
                break
    for message in raw_messages(bag):
        if message.log_time == place.time:
            yield message.data
