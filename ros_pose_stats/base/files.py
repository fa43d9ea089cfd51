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

"""Files that are whole, on the disk, and one process's own.

`write_whole` and `write_file`: all or nothing after a killed process. `replace_file`
and what it is made of: all or nothing after a power cut, too. `DirectoryLock`: one
writer a directory.
"""

import errno
import fcntl
import os
import shutil
import stat
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import BinaryIO, NoReturn

from .errors import RequestError, reason

PREFIX = ".unfinished-"
HALF = ".half"  # suffix of a file until it is whole and takes its name
LOCK = ".lock"  # file whose lock is that of its directory

_NO_SUCH_SYNC = frozenset((errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP))
"""What file systems answer that have nothing to sync for a directory."""

_GLANCES = 5  # tries for a taken lock: somebody may only have looked at it
_GLANCE = 0.002  # seconds between two tries; looking takes microseconds
LOCK_SECONDS = 10.0  # for which a writer waits for another one
_TAKEN = frozenset((errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES))

_KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


class NotAFileError(OSError):
    """A pipe, a socket or a device where a file was expected; `strerror` says which."""


def open_file(file: str | os.PathLike[str]) -> BinaryIO:
    """Open a regular file, or a link to one: a pipe or a device may never end."""
    # Opening may already do something.
    _refuse_others(os.stat(file).st_mode, file)  # noqa: PTH116
    # Another file may have taken its name since, and a pipe waits for whoever writes to
    # it.
    number = os.open(file, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
    try:
        _refuse_others(os.fstat(number).st_mode, file)
        return os.fdopen(number, "rb")
    except OSError:
        os.close(number)
        raise


def _refuse_others(mode: int, file: str | os.PathLike[str]) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(
            errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(file)
        )
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), "something else")
        raise NotAFileError(errno.EINVAL, f"{kind}, no file", os.fspath(file))


def refuse_irregular(file: Path) -> None:
    """Refuse a name of what is no file: whoever opens that may wait for ever."""
    with suppress(FileNotFoundError):
        _refuse_others(file.stat().st_mode, file)


def read_file(file: str | os.PathLike[str], limit: int | None = None) -> bytes:
    """Bytes of a regular file, one more than `limit` where there are more than that."""
    with open_file(file) as stream:
        return stream.read() if limit is None else stream.read(limit + 1)


def write_whole(folder: Path, write: Callable[[Path], object]) -> list[Path]:
    """Write files in a temporary folder, then move them into their folder.

    `write`: given an empty folder on the same file system, writes files into it. If
    that fails or is interrupted, nothing has changed. Returns the files in the order of
    their names.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(prefix=PREFIX, dir=folder) as name:
        temporary = Path(name)
        write(temporary)
        files = sorted(path for path in temporary.rglob("*") if path.is_file())
        targets = [folder / path.relative_to(temporary) for path in files]
        for target in targets:
            target.parent.mkdir(parents=True, exist_ok=True)
        for file, target in zip(files, targets, strict=True):
            file.replace(target)
    return targets


def write_file(file: Path, data: bytes) -> None:
    """Write one file, whole or not at all, and create its folder."""
    write_whole(file.parent, lambda folder: (folder / file.name).write_bytes(data))


def remove_unfinished(folder: Path) -> None:
    """Remove what a killed `write_whole` had begun, where nobody else is writing."""
    for unfinished in folder.glob(f"{PREFIX}*"):
        shutil.rmtree(unfinished, ignore_errors=True)  # leftovers do no harm


def refuse_unwritable(folder: Path) -> None:
    """Check, before any work, that files can be written to a folder to be."""
    path = folder.absolute()
    try:
        parent = next(
            folder_above
            for folder_above in (path, *path.parents)
            if folder_above.exists()
        )
        with TemporaryDirectory(prefix=PREFIX, dir=parent):
            pass
    except OSError as error:
        raise RequestError(
            "a folder that can be written to",
            f"{folder} ({reason(error)})",
            "name another one",
        ) from error


def folders_below(top: Path) -> Iterator[tuple[Path, list[str]]]:
    """Folders with the names of their files, each once; nothing hidden.

    Links, which may go in circles, come last, so that what lies below the top by itself
    is named by that path.
    """
    identities: set[tuple[int, int]] = set()
    roots = deque([str(top)])
    while roots:
        for folder, subfolders, names in os.walk(
            roots.popleft(), onerror=_refuse_folder
        ):
            try:
                status = Path(folder).stat()
            except OSError as error:  # removed just now
                _refuse_folder(error)
            identity = status.st_dev, status.st_ino
            if identity in identities:
                subfolders.clear()
                continue
            identities.add(identity)
            subfolders[:] = sorted(
                name for name in subfolders if not name.startswith(".")
            )
            paths = (Path(folder, name) for name in subfolders)
            roots.extend(str(path) for path in paths if path.is_symlink())
            yield Path(folder), [name for name in names if not name.startswith(".")]


def _refuse_folder(error: OSError) -> NoReturn:
    raise RequestError(
        "a folder that can be read",
        f"{error.filename} ({reason(error)})",
        "check its permissions",
    ) from error


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
    """Write buffers in a row from `offset` on; return the offset behind them."""
    views = [memoryview(buffer).cast("B") for buffer in buffers]
    while views:
        written = os.pwritev(number, views, offset)
        if written == 0:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        offset += written
        while views and written >= len(views[0]):
            written -= len(views.pop(0))
        if views:
            views[0] = views[0][written:]
    return offset


def write_new(path: Path, content: bytes) -> None:
    """Write a file that is not there yet; its bytes, not its name, are on the disk."""
    number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        write_all(number, [content], 0)
        os.fsync(number)
    finally:
        os.close(number)


def replace_file(path: Path, content: bytes) -> None:
    """Write a whole file under another name, then rename it."""
    half = path.with_name(path.name + HALF)
    try:
        half.unlink(missing_ok=True)  # it may be a pipe
        write_new(half, content)
        half.replace(path)
    except OSError:
        with suppress(OSError):
            half.unlink()
        raise
    sync_directory(path.parent)


def remove_empty(directory: Path) -> None:
    """Delete a directory that holds nothing, or only the caller's lock."""
    if all(entry.name == LOCK for entry in directory.iterdir()):
        (directory / LOCK).unlink(missing_ok=True)
        directory.rmdir()


class DirectoryLock:
    """The kernel's lock (flock) of one directory, until its process ends."""

    def __init__(self, number: int) -> None:
        self._number = number

    @classmethod
    def take(cls, directory: Path) -> "DirectoryLock | None":
        """The directory's lock; None where another process, or another log, has it."""
        for _ in range(_GLANCES):
            number = os.open(directory / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
            lock = cls(number)
            try:
                if _try(number, fcntl.LOCK_EX) and lock.holds(directory):
                    return lock
            except OSError:
                lock.release()
                raise
            lock.release()
            time.sleep(_GLANCE)
        return None

    def holds(self, directory: Path) -> bool:
        """Whether it is this directory's: not when that was deleted or moved away."""
        return is_file_at(self._number, directory / LOCK)

    def release(self) -> None:
        """Let go of the directory; the file stays, so nobody locks a deleted one."""
        if self._number >= 0:
            os.close(self._number)
        self._number = -1

    def __enter__(self) -> "DirectoryLock":
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


@contextmanager
def locked_directory(directory: Path) -> Iterator[None]:
    """Have what is written into a directory meanwhile follow what others write so."""
    number = os.open(directory, os.O_RDONLY)
    try:
        deadline = time.monotonic() + LOCK_SECONDS
        with suppress(OSError):  # of file systems that lock no directories
            while not _try(number, fcntl.LOCK_EX):
                if time.monotonic() > deadline:
                    raise RequestError(
                        f"to write in {directory} within {LOCK_SECONDS:g} s",
                        "another process that writes there",
                        "end that one, or try again",
                    )
                time.sleep(0.02)
        yield
    finally:
        os.close(number)


def is_file_at(number: int, path: Path) -> bool:
    """Whether an open file is still to be found at a path."""
    try:
        return os.path.samestat(os.fstat(number), path.stat())
    except (FileNotFoundError, NotADirectoryError):
        return False


def _try(number: int, kind: int) -> bool:
    try:
        fcntl.flock(number, kind | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in _TAKEN:
            return False
        raise
    return True
