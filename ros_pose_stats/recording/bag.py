"""A bag while it is being written: one file after the other in one directory."""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ..files import DirectoryLock, make_directories, replace_file, sync_directory
from .repair.removal import remove_empty
from .repair.repair import mend
from .run_names import METADATA, bag_file, being_made
from .writer.bag_file import BagFile
from .writer.contents import Contents, metadata_yaml
from .writer.mcap_layout import message_size
from .writer.message_types import MessageType


class ClosedFile(NamedTuple):
    """A file that is not written any more: its name and bytes."""

    name: str
    size: int


class Bag:
    """The files of a run. Used by one thread at a time.

    `path`: the directory to be made; `max_bytes`: a file that would grow beyond it is finished and
    followed by the next; `node`: name of the node that records. Attributes `closed`: files before
    the one that is being written, the oldest first; `metadata_size`: bytes of `metadata.yaml`.
    Raises OSError: the directory cannot be made.
    """

    def __init__(self, path: Path, types: Mapping[str, MessageType], max_bytes: int,
                 node: str = "") -> None:
        self._path = path
        self._lock = _locked_directory(path)
        self._types = types
        self._node = node
        self._max_bytes = max_bytes
        self._file: BagFile | None = None
        self._finished: dict[str, Contents] = {}
        self.closed: list[ClosedFile] = []
        self.metadata_size = 0
        self._next_number = 0
        self._described = False
        self._abandoned = False

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return self.closed_size + (self._file.size if self._file else 0)

    @property
    def closed_size(self) -> int:
        """Bytes of the files that are not written any more."""
        return sum(file.size for file in self.closed)

    @property
    def file(self) -> BagFile | None:
        """The file that is being written, if any."""
        return self._file

    def is_gone(self) -> bool:
        """Whether the directory, or the lock in it, was deleted, moved or replaced."""
        return not self._lock.holds(self._path)

    def append(self, topic: str, data: memoryview, log_time: int) -> None:
        """Write a message.

        Raises OSError: it is not in the bag, or the bag is not described; the next call tries
        again.
        """
        file = self._file_for(message_size(data))
        file.append(topic, data, log_time)
        if not self._described:
            self._describe()

    def drop_oldest(self) -> ClosedFile | None:
        """Delete the oldest file that is closed and return what it was, if there is one.

        The bag is described without it first, so that no reader looks for what is gone. That
        fails where the disk is full; the file goes all the same.
        """
        if not self.closed:
            return None
        oldest = self.closed[0]
        contents = self._finished.pop(oldest.name, None)
        self._described = False  # the next append tries again
        with suppress(OSError):
            self._describe()
        try:
            (self._path / oldest.name).unlink(missing_ok=True)
        except OSError:
            if contents is not None:
                self._finished = {oldest.name: contents, **self._finished}
            self._described = False
            return None
        return self.closed.pop(0)

    def finish(self) -> None:
        """Finish the last file, describe the bag for good, and let go of it.

        Raises OSError: it is not finished; the directory is let go of all the same.
        """
        try:
            if self._file is not None and not self._drop_broken():
                self._finish_file()
            if self._abandoned:
                mend(self._path)
            else:
                self._describe()
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Let go of the bag as it is; a directory without a file in it goes."""
        if self._file is not None:
            with suppress(OSError):  # where it was moved to it is whole
                self._file.finish()
            self._file.abandon(OSError(errno.ENOENT, os.strerror(errno.ENOENT)))
            self._file = None
        with suppress(OSError):
            if not self.is_gone():
                remove_empty(self._path)
        self._lock.release()

    def _file_for(self, record: int) -> BagFile:
        """The file for a record of so many bytes."""
        self._drop_broken()
        file = self._file
        if file is not None and file.written and file.size_with(record) > self._max_bytes:
            self._finish_file()
        if self._file is None:
            while bag_file(self._path, self._next_number).exists():
                self._next_number += 1
            path = bag_file(self._path, self._next_number)
            self._file = BagFile(path, self._types, self._node)
            self._next_number += 1
            self._described = False
        return self._file

    def _drop_broken(self) -> bool:
        """Leave a file that cannot be gone on with; return whether there was one."""
        file = self._file
        if file is None or not (file.broken or file.is_gone()):
            return False
        file.abandon(OSError(errno.ENOENT, os.strerror(errno.ENOENT)))
        self._close(file)
        self._abandoned = True
        return True

    def _finish_file(self) -> None:
        file = self._file
        assert file is not None
        file.finish()
        self._finished[file.path.name] = file.contents
        self._close(file)

    def _close(self, file: BagFile) -> None:
        self._file = None
        self.closed.append(ClosedFile(file.path.name, file.size))

    def _describe(self) -> None:
        files = {name: contents for name, contents in self._finished.items()
                 if (self._path / name).exists()}
        if self._file is not None:
            files[self._file.path.name] = self._file.contents
        if files:
            text = metadata_yaml(files).encode()
            replace_file(self._path / METADATA, text)
            self.metadata_size = len(text)
        self._described = True


def _locked_directory(path: Path) -> DirectoryLock:
    """Make a directory that is locked from the moment it has its name.

    Another node that starts at this moment sees no directory, or one that is locked. It may
    remove what has not got its name yet; then this fails and is tried again.

    Raises OSError: it could not be made; nothing is left of it.
    """
    make_directories(path.parent)
    made = being_made(path)
    made.mkdir(exist_ok=True)
    lock = None
    try:
        lock = DirectoryLock.take(made)
        if lock is None:
            raise OSError(errno.EBUSY, os.strerror(errno.EBUSY))
        made.rename(path)
        made = path
        sync_directory(path.parent)
    except OSError:
        remove_empty(made)
        if lock is not None:
            lock.release()
        raise
    return lock
