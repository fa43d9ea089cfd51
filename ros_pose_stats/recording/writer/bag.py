"""A bag while it is being written: one file after the other in one directory."""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from pathlib import Path

from ..repair.mending import mend
from ..run_names import bag_file
from .bag_directory import BagDirectory
from .bag_file import BagFile
from .contents import Contents
from .mcap_layout import message_size
from .message_types import MessageType


class Bag:
    """The files of a run. Used by one thread at a time.

    Parameters
    ----------
    path : Path
        The directory to be made.
    types : mapping
        Type of each topic.
    max_bytes : int
        A file that would grow beyond it is finished and followed by the next.
    node : str
        Name of the node that records.

    Raises
    ------
    OSError
        The directory cannot be made.
    """

    def __init__(self, path: Path, types: Mapping[str, MessageType], max_bytes: int,
                 node: str = "") -> None:
        self._directory = BagDirectory(path)
        self._types = types
        self._node = node
        self._max_bytes = max_bytes
        self._file: BagFile | None = None
        self._finished: dict[str, Contents] = {}
        self._finished_bytes = 0
        self._next_number = 0
        self._described = False
        self._abandoned = False

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return self._finished_bytes + (self._file.size if self._file else 0)

    @property
    def file(self) -> BagFile | None:
        """The file that is being written, if any."""
        return self._file

    def is_gone(self) -> bool:
        """Whether the directory was deleted or moved away."""
        return self._directory.is_gone()

    def append(self, topic: str, data: memoryview, log_time: int) -> tuple[BagFile, int]:
        """Write a message; return the file and the number that its `sync` takes.

        Raises
        ------
        OSError
            It is not in the bag, or the bag is not described; the next call tries again.
        """
        file = self._file_for(message_size(data))
        number = file.append(topic, data, log_time)
        if not self._described:
            self._describe()
        return file, number

    def finish(self) -> None:
        """Finish the last file, describe the bag for good, and let go of it.

        Raises
        ------
        OSError
            It is not finished; the directory is let go of all the same.
        """
        try:
            if self._file is not None and not self._drop_broken():
                self._finish_file()
            if self._abandoned:
                mend(self._directory.path)
            else:
                self._describe()
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Let go of the bag as it is."""
        if self._file is not None:
            self._file.abandon(OSError(errno.ENOENT, os.strerror(errno.ENOENT)))
            self._file = None
        self._directory.release()

    def _file_for(self, record: int) -> BagFile:
        """The file for a record of so many bytes."""
        self._drop_broken()
        file = self._file
        if file is not None and file.written and file.size_with(record) > self._max_bytes:
            self._finish_file()
        if self._file is None:
            while bag_file(self._directory.path, self._next_number).exists():
                self._next_number += 1
            path = bag_file(self._directory.path, self._next_number)
            self._file = BagFile(path, self._types, self._node)
            self._described = False
        return self._file

    def _drop_broken(self) -> bool:
        """Leave a file that cannot be gone on with; return whether there was one."""
        file = self._file
        if file is None or not (file.broken or file.is_gone()):
            return False
        file.abandon(OSError(errno.ENOENT, os.strerror(errno.ENOENT)))
        self._file = None
        self._finished_bytes += file.size
        self._abandoned = True
        return True

    def _finish_file(self) -> None:
        file = self._file
        assert file is not None
        file.finish()
        self._file = None
        self._finished[file.path.name] = file.contents
        self._finished_bytes += file.size

    def _describe(self) -> None:
        files = {name: contents for name, contents in self._finished.items()
                 if (self._directory.path / name).exists()}
        if self._file is not None:
            files[self._file.path.name] = self._file.contents
        if files:
            self._directory.describe(files)
        self._described = True
