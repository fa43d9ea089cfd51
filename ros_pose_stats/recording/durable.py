"""Getting names and whole files onto the disk, so that they survive a power cut."""

from __future__ import annotations

import errno
import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from .run_names import HALF

_NO_SUCH_SYNC = frozenset((errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP))
"""What file systems answer that have nothing to sync for a directory."""


def sync_directory(directory: Path) -> None:
    """Make the names in a directory durable: files made, renamed or removed in it."""
    number = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(number)
    except OSError as error:
        if error.errno not in _NO_SUCH_SYNC:
            raise
    finally:
        os.close(number)


def make_directories(directory: Path) -> None:
    """Make a directory and its parents; each new name is durable."""
    if directory.is_dir():
        return
    make_directories(directory.parent)
    directory.mkdir(exist_ok=True)
    sync_directory(directory.parent)


def write_all(number: int, buffers: Sequence[bytes | memoryview], offset: int) -> int:
    """Write buffers one after the other, whatever pieces the kernel takes.

    `offset`: where in the file the first byte goes. Returns offset behind the last byte. Raises
    OSError: not all of it could be written; some of it may be.
    """
    waiting = [memoryview(buffer).cast("B") for buffer in buffers]
    while waiting:
        written = os.pwritev(number, waiting, offset)
        if written == 0:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        offset += written
        while waiting and written >= len(waiting[0]):
            written -= len(waiting.pop(0))
        if waiting:
            waiting[0] = waiting[0][written:]
    return offset


def replace_file(path: Path, content: bytes) -> None:
    """Write a whole file under another name, then rename: there is the old one or the new one.

    Raises OSError: the old file is still there, unchanged.
    """
    half = path.with_name(path.name + HALF)
    try:
        half.unlink(missing_ok=True)  # it may be a pipe
        number = os.open(half, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        try:
            write_all(number, [content], 0)
            os.fsync(number)
        finally:
            os.close(number)
        half.replace(path)
    except OSError:
        with suppress(OSError):
            half.unlink()
        raise
    sync_directory(path.parent)
