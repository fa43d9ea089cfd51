"""The record of one run while it is kept: files are written, follow each other, go."""

import errno
import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

from ...base.files import (
    DirectoryLock,
    make_directories,
    remove_empty,
    replace_file,
    sync_directory,
)
from . import repair, runs
from .writer import bag_file, mcap_layout, message_types

_MIN_FILES = 8
"""Files that the bound of a log directory has room for, so that the oldest can go."""


class RunLog:
    """One run's bag, `directory`, made with its first record; called by any thread.

    A file that cannot be gone on with is followed by another one, and a bag that was
    deleted or moved away by another bag. A file that would grow beyond `max_bag_bytes`
    is followed by the next. To keep all of the log directory, which nodes may share,
    below `max_log_bytes` (0: no bound) the oldest runs are deleted, then the oldest
    closed files of this bag, which are at most an eighth of the bound.
    """

    def __init__(
        self,
        log_directory: Path,
        types: Mapping[str, message_types.MessageType],
        *,
        max_bag_bytes: int,
        max_log_bytes: int,
        node: str,
    ) -> None:
        self.directory = runs.new_run(log_directory)
        self._open_file = partial(bag_file.BagFile, types=types, node=node)
        self._lengths = {
            topic: message_types.CdrLength(kind) for topic, kind in types.items()
        }
        start = len(mcap_layout.opening(types, 0, node)[0])
        self._overhead = 3 * start
        self._max_bytes = max_bag_bytes
        if max_log_bytes:
            share = max(max_log_bytes // _MIN_FILES, 4 * start)
            self._max_bytes = min(max_bag_bytes, share)
        self.space = runs.SpaceBound(log_directory, max_log_bytes)
        self._lock = threading.RLock()
        self._bag: _Bag | None = None
        self._is_closed = False
        self._last_time = 0

    def write(self, topic: str, data: bytes) -> None:
        """Record a message in CDR, which outlives this process.

        After an OSError the next message tries again.
        """
        message = self._lengths[topic].trimmed(data)
        with self._refusals(), self._lock:
            bag = self._bag_for(mcap_layout.message_size(message))
            self._last_time = max(time.time_ns(), self._last_time + 1)
            bag.append(topic, message, self._last_time)

    def sync(self) -> None:
        """Have all that was written on the disk; OSError: a power cut may take it."""
        with self._lock:
            file = self._bag.file if self._bag else None
        with self._refusals():
            if file is not None:
                file.sync()

    def close(self) -> None:
        """Finish the bag and let go of it; OSError: the next start has to finish it."""
        with self._refusals(), self._lock:
            self._is_closed = True
            bag = self._bag
            self._bag = None
            if bag is not None:
                bag.finish()

    @contextmanager
    def _refusals(self) -> Iterator[None]:
        """Have errors of the operating system say what they were in the way of."""
        try:
            yield
        except OSError as error:
            raise OSError(
                f"cannot record to {self.directory}: {error.strerror or error}"
            ) from error

    def leave_lost_bag(self) -> None:
        """Go on in another bag where this one was deleted or moved.

        OSError where that cannot be seen.
        """
        with self._lock:
            if self._bag is not None and self._bag.is_gone():
                self._bag.abandon()
                self._bag = None
                self.directory = runs.new_run(self.directory.parent)

    @property
    def bytes_written(self) -> int:
        """Bytes of the bag's files."""
        with self._lock:
            return self._bag.size if self._bag else 0

    @property
    def bytes_left(self) -> int | None:
        """Bytes by which the log directory may still grow; None without a bound."""
        return self.space.bytes_left(self.bytes_written)

    def _bag_for(self, record: int) -> "_Bag":
        """The bag for a record of so many bytes."""
        if self._is_closed:
            raise OSError("the log is closed")
        self.leave_lost_bag()
        # Beside the record there may be the end of one file, a whole empty one, and for
        # a moment both the old and the new metadata.yaml.
        size = self._bag.size + 2 * self._bag.metadata_size if self._bag else 0
        self.space.enforce(
            self.directory,
            size + record + self._overhead,
            lambda: self._bag.drop_oldest() if self._bag else None,
        )
        if self._bag is None:
            if self.directory.exists():
                self.directory = runs.new_run(self.directory.parent)
            self._bag = _Bag(self.directory, self._open_file, self._max_bytes)
        return self._bag


class _Bag:
    """The files of a run, in a locked directory; used by one thread at a time."""

    def __init__(
        self,
        path: Path,
        open_file: Callable[[Path], bag_file.BagFile],
        max_bytes: int,
    ) -> None:
        self._path = path
        self._lock = _locked_directory(path)
        self._open_file = open_file
        self._max_bytes = max_bytes
        self.file: bag_file.BagFile | None = None  # that is being written
        self.metadata_size = 0
        # bytes of the files before that one, oldest first
        self._closed_sizes: dict[str, int] = {}
        # what those hold that have a footer
        self._finished_files: dict[str, mcap_layout.Contents] = {}
        self._next_number = 0
        self._is_described = False

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return sum(self._closed_sizes.values()) + (self.file.size if self.file else 0)

    def is_gone(self) -> bool:
        """Whether the directory, or the lock in it, was deleted, moved or replaced."""
        return not self._lock.holds(self._path)

    def append(self, topic: str, data: memoryview, log_time: int) -> None:
        """Write a message; after an OSError it, or the description, is tried again."""
        file = self.file
        if (
            file is not None
            and not self._leave_broken(file)
            and file.written
            and (file.size_with(mcap_layout.message_size(data)) > self._max_bytes)
        ):
            self._finish_file(file)
        if self.file is None:
            while (path := runs.bag_file(self._path, self._next_number)).exists():
                self._next_number += 1
            self.file = self._open_file(path)
            self._next_number += 1
            self._is_described = False
        self.file.append(topic, data, log_time)
        if not self._is_described:
            self._describe()

    def drop_oldest(self) -> tuple[str, int] | None:
        """Delete the oldest closed file; its name and bytes, if there is one."""
        if not self._closed_sizes:
            return None
        name = next(iter(self._closed_sizes))
        with suppress(OSError):
            (self._path / name).unlink(missing_ok=True)
            self._is_described = False
            self._finished_files.pop(name, None)
            return name, self._closed_sizes.pop(name)
        return None

    def finish(self) -> None:
        """Finish all files, describe the bag for good, and let go of it in any case."""
        try:
            if self.file is not None and not self._leave_broken(self.file):
                self._finish_file(self.file)
            repair.mend(self._path)
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Let go of the bag as it is; a directory without a file in it goes."""
        if self.file is not None:
            self._abandon_file(self.file)
        with suppress(OSError):
            if not self.is_gone():
                remove_empty(self._path)
        self._lock.release()

    def _leave_broken(self, file: bag_file.BagFile) -> bool:
        """Leave a file that cannot be gone on with; return whether it was that."""
        if not (file.broken or file.is_gone()):
            return False
        self._abandon_file(file)
        return True

    def _abandon_file(self, file: bag_file.BagFile) -> None:
        with suppress(OSError):  # where it was moved to it is whole
            file.finish()
        file.abandon()
        self._close_file(file)

    def _finish_file(self, file: bag_file.BagFile) -> None:
        file.finish()
        self._finished_files[file.path.name] = file.contents
        self._close_file(file)

    def _close_file(self, file: bag_file.BagFile) -> None:
        self.file = None
        self._closed_sizes[file.path.name] = file.size

    def _describe(self) -> None:
        files = {
            name: contents
            for name, contents in self._finished_files.items()
            if (self._path / name).exists()
        }
        if self.file is not None:
            files[self.file.path.name] = self.file.contents
        text = mcap_layout.metadata_yaml(files).encode()
        replace_file(self._path / runs.METADATA, text)
        self.metadata_size = len(text)
        self._is_described = True


def _locked_directory(path: Path) -> DirectoryLock:
    """Make a directory and take its lock, or leave nothing of it and raise OSError."""
    make_directories(path.parent)
    path.mkdir()
    lock = None
    try:
        lock = DirectoryLock.take(path)
        if lock is None:
            raise OSError(errno.EBUSY, os.strerror(errno.EBUSY))
        sync_directory(path.parent)
    except OSError:
        with suppress(OSError):
            remove_empty(path)
        if lock is not None:
            lock.release()
        raise
    return lock
