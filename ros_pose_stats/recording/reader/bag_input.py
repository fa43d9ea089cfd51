"""The files of a bag, opened for reading; what is compressed, unpacked."""

from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path
from typing import Any, BinaryIO, Final, cast

import zstandard
from mcap.exceptions import McapError
from mcap.records import Chunk, McapRecord
from mcap.stream_reader import breakup_chunk

_PACKED: Final = ".zstd"


def files_of_bag(bag: Path) -> list[Path]:
    """The MCAP files of a bag directory in the order of their numbers; a file is its own bag.

    Raises
    ------
    OSError
        There is no such bag.
    """
    if not bag.is_dir():
        return [bag]
    return sorted((path for path in bag.iterdir() if re.search(r"\.mcap(\.zstd)?$", path.name)),
                  key=_by_numbers)


def _by_numbers(path: Path) -> list[tuple[int, str]]:
    """Sort key that puts `bag_10` behind `bag_9`."""
    return [(int(part), "") if part.isdigit() else (0, part)
            for part in re.split(r"(\d+)", path.name)]


def opened(path: Path) -> BinaryIO:
    """A bag's file, seekable; one that was compressed as a whole is unpacked for that.

    Raises
    ------
    OSError
        It cannot be read.
    """
    if path.suffix != _PACKED:
        return path.open("rb")
    unpacked = cast(BinaryIO, tempfile.TemporaryFile())  # noqa: SIM115  closed by the caller
    try:
        with path.open("rb") as file, zstandard.ZstdDecompressor().stream_reader(
                file, read_across_frames=True) as reader:
            shutil.copyfileobj(cast(Any, reader), unpacked)
    except zstandard.ZstdError:
        pass  # what came out before is as good as a file that was cut
    except OSError:
        unpacked.close()
        raise
    unpacked.seek(0)
    return unpacked


def unpacked_chunk(chunk: Chunk) -> list[McapRecord]:
    """The records of a chunk.

    Raises
    ------
    McapError
        It is damaged, or compressed in an unknown way.
    """
    try:
        return breakup_chunk(chunk, validate_crc=True)
    except Exception as error:  # each compression has errors of its own
        raise McapError(f"unreadable chunk: {error}") from error
