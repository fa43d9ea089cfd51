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

"""The record of one run while it is kept: files are written, follow each other, go."""

import errno
import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

from ...base.errors import reason
from ...base.files import (
    DirectoryLock,
    make_directories,
    remove_empty,
    replace_file,
    sync_directory,
)
from . import indexing, runs
from .writer import bag_file, mcap_layout, message_types

_MIN_FILES = 8
"""Files that the bound of a log directory has room for, so that the oldest can go."""

LAST_BYTES = 16 * 2**20
"""Of a file that gets its index as the log is closed, when the node has little time."""


class RunLog:
    """One run's bag, `directory`, made with its first record; called by any thread.

    A file that cannot be gone on with is followed by another one, and a bag that was
    deleted or moved away by another bag. A file that would grow beyond `max_bag_bytes`
    is followed by the next, and is written anew with an index meanwhile. To keep all of
    the log directory, which nodes may share, below `max_log_bytes` (0: no bound) the
    oldest runs are deleted, then the oldest closed files of this bag, which are at most
    an eighth of the bound. `warn` is told of files that stay without an index.
    """

    def __init__(
        self,
        log_directory: Path,
        types: Mapping[str, message_types.MessageType],
        *,
        max_bag_bytes: int,
        max_log_bytes: int,
        node: str,
        warn: Callable[[str], object],
    ) -> None:
        self._warn = warn
        self.directory = runs.new_run(log_directory)
        self._open_file = partial(bag_file.BagFile, types=types, node=node)
        self._lengths = {
            topic: message_types.CdrLength(kind) for topic, kind in types.items()
        }
        topics = mcap_layout.describe_topics(types, node)
        start = len(mcap_layout.opening(topics))
        self._overhead = 3 * start
        self._max_bytes = max_bag_bytes
        if max_log_bytes:
            share = max(max_log_bytes // _MIN_FILES, 4 * start)
            self._max_bytes = min(max_bag_bytes, share)
        self.space = runs.SpaceBound(log_directory, max_log_bytes)
        self._lock = threading.RLock()
        self._bag: _Bag | None = None
        self.indexer = indexing.Indexer()
        self.last_bytes = LAST_BYTES
        self._rewriting = threading.RLock()  # one file after the other
        # for those of this bag
        self._rewrites = ThreadPoolExecutor(1, thread_name_prefix="index")
        self.is_closed = False
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
        """Finish the bag and let go of it; OSError: the next start has to finish it.

        Large files that have no index yet get it from the next start.
        """
        self.is_closed = True
        self._rewrites.shutdown(wait=False, cancel_futures=True)
        self.indexer.close()
        with self._refusals(), self._rewriting, self._lock:
            if self._bag is None:
                return
            try:
                path = self._bag.finish()
                # It is whole before the little time that is left goes to the index.
                if path is not None and path.stat().st_size <= self.last_bytes:
                    self._index(path, indexing.write_indexed)
            finally:
                self._bag.abandon()
                self._bag = None

    @contextmanager
    def room_for(self, size: int) -> Iterator[None]:
        """Have so many bytes free below the bound for one file that is written anew.

        OSError where there are not so many.
        """
        with self._rewriting:
            try:
                self._reserve(size)
                if self.space.is_exceeded:
                    raise OSError("no room below max_log_bytes")
                yield
            finally:
                self._reserve(0)

    def _reserve(self, size: int) -> None:
        with self._lock:
            self.space.reserved = size
            self._make_room(0)

    def _index(self, path: Path, write: Callable[[Path], indexing.Rewrite]) -> None:
        """Give a closed file of the bag an index, unless it goes meanwhile."""
        was_closed = self.is_closed
        try:
            with self.room_for(path.stat().st_size):
                rewrite = write(path)
            with self._lock:
                if self._bag is not None:
                    self._bag.put_in_place(path, rewrite)
        except OSError as error:
            if self.is_closed == was_closed:  # else it was abandoned
                self._warn(f"{path} stays without an index: {reason(error)}")

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
        if self.is_closed:
            raise OSError("the log is closed")
        self.leave_lost_bag()
        self._make_room(record)
        if self._bag is None:
            if self.directory.exists():
                self.directory = runs.new_run(self.directory.parent)
            self._bag = _Bag(
                self.directory,
                self._open_file,
                self._max_bytes,
                lambda path: self._rewrites.submit(
                    self._index, path, self.indexer.write
                ),
            )
        return self._bag

    def _make_room(self, record: int) -> None:
        """Keep the log directory below its bound with a record of so many bytes."""
        # Beside the record there may be the end of one file, a whole empty one, and for
        # a moment both the old and the new metadata.yaml.
        size = self._bag.size + 2 * self._bag.metadata_size if self._bag else 0
        self.space.enforce(
            self.directory,
            size + record + self._overhead,
            lambda: self._bag.drop_oldest() if self._bag else None,
        )


class _Bag:
    """The files of a run, in a locked directory; used by one thread at a time."""

    def __init__(
        self,
        path: Path,
        open_file: Callable[[Path], bag_file.BagFile],
        max_bytes: int,
        on_closed: Callable[[Path], object],
    ) -> None:
        self._path = path
        self._on_closed = on_closed
        self._lock = _locked_directory(path)
        self._open_file = open_file
        self._max_bytes = max_bytes
        self.file: bag_file.BagFile | None = None  # that is being written
        self.metadata_size = 0
        # bytes of the files before that one, oldest first
        self._closed_sizes: dict[str, int] = {}
        # what those hold that have an end
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
            self._on_closed(file.path)
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

    def put_in_place(self, path: Path, rewrite: indexing.Rewrite) -> None:
        """Have a closed file that was written anew take its place, if it is there."""
        if (
            path.parent == self._path
            and path.name in self._closed_sizes
            and path.exists()
        ):
            self._closed_sizes[path.name] = indexing.put_in_place(path, rewrite)
            self._finished_files[path.name] = rewrite.contents
        else:
            runs.remove_halves(path.parent)

    def finish(self) -> Path | None:
        """Finish and describe the last file and return it, if there is one.

        OSError: the next start has to finish it.
        """
        file = self.file
        if file is not None and not self._leave_broken(file):
            self._finish_file(file)
        self._describe()
        return file.path if file is not None else None

    def abandon(self) -> None:
        """Let go of the bag as it is; a directory without a file in it goes."""
        if self.file is not None:
            self._abandon_file(self.file)
        with suppress(OSError):
            if not self.is_gone():
                runs.remove_halves(self._path)
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
            name: self._finished_files[name]
            for name in self._closed_sizes
            if name in self._finished_files and (self._path / name).exists()
        }
        if self.file is not None:
            files[self.file.path.name] = self.file.contents
        if not files:
            return
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
