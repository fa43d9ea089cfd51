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

"""What is kept below the user's cache: compiled kernels, and meshes of STEP files.

It is used as it lies there, and some of it is code. So every folder and file is root's
or one's own, and writable by nobody else; it is opened without following links, and
looked at once it is open. In the folders on the way to it nobody else can put another
one in its place.
"""

import errno
import hashlib
import os
import shutil
import stat
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from .files import write_whole

NAME = "ros_pose_stats"
SEAL = 32
"""Bytes of the digest at the head of a file."""

_LONGEST_WRITE = 3600.0
"""Seconds; hundreds of megabytes take some."""

OTHERS = stat.S_IWGRP | stat.S_IWOTH
UNTRUSTED = "others can write there"


def cache_folders() -> Iterator[Path]:
    """Where a cache may be: below `$NUMBA_CACHE_DIR`, else below the user's cache."""
    for root in (
        os.environ.get("NUMBA_CACHE_DIR"),
        os.environ.get("XDG_CACHE_HOME"),
        "~/.cache",
    ):
        if root:
            with suppress(RuntimeError):  # a user without a home
                yield Path(root).expanduser() / NAME


def make_folder(folder: Path) -> None:
    """Make a folder of a cache, which nobody else may look into."""
    folder.parent.parent.mkdir(parents=True, exist_ok=True)
    folder.parent.mkdir(mode=0o700, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)


def _open_trusted(name: str | Path, flags: int, folder: int | None = None) -> int:
    """Open what is root's or one's own and nobody else can write; raises OSError.

    A folder of one's own is closed to others: of what they put there nothing is theirs
    to be trusted. A file that they could write may already be changed.
    """
    flags |= os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK
    is_folder = bool(flags & os.O_DIRECTORY)
    number = os.open(name, flags, dir_fd=folder)
    try:
        status = os.fstat(number)
        mode = status.st_mode
        if is_folder and status.st_uid == os.getuid() and mode & OTHERS:
            os.fchmod(number, stat.S_IMODE(mode) & ~OTHERS)
            mode &= ~OTHERS
        is_kind = stat.S_ISDIR(mode) if is_folder else stat.S_ISREG(mode)
        if status.st_uid not in (0, os.getuid()) or mode & OTHERS or not is_kind:
            raise PermissionError(errno.EPERM, UNTRUSTED, os.fspath(name))
    except OSError:
        os.close(number)
        raise
    return number


def _open_below(folder: Path, names: list[str], flags: int) -> int:
    """Open what lies in folders of a cache, each of them looked at; raises OSError."""
    number = _open_trusted(folder, os.O_DIRECTORY)
    for position, name in enumerate(names, 1):
        kind = flags if position == len(names) else os.O_DIRECTORY
        try:
            below = _open_trusted(name, kind, number)
        finally:
            os.close(number)
        number = below
    return number


def refuse_untrusted(folder: Path) -> None:
    """Refuse a folder of a cache that others could have filled; raises OSError."""
    cache = folder.parent
    for path in {*cache.absolute().parents, *Path(os.path.realpath(cache)).parents}:
        for status in (path.lstat(), path.stat()):
            # Where the sticky bit is set, as in /tmp, others rename what is theirs.
            is_open = status.st_mode & OTHERS and not status.st_mode & stat.S_ISVTX
            if status.st_uid not in (0, os.getuid()) or (
                is_open and not stat.S_ISLNK(status.st_mode)
            ):
                raise PermissionError(errno.EPERM, UNTRUSTED, os.fspath(path))
    os.close(_open_below(cache, [folder.name], os.O_DIRECTORY))


def open_to_all(folder: Path) -> None:
    """Let everybody read what is in a folder, and nobody else write there."""
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)


class DamagedError(Exception):
    """A file that is not as it was written."""


def read_sealed(folder: Path, name: str) -> bytes:
    """Content of a file by its path in a folder; raises OSError, DamagedError."""
    number = _open_below(folder, name.split("/"), 0)
    with os.fdopen(number, "rb") as stream:
        stored = stream.read()
    if hashlib.sha256(stored[SEAL:]).digest() != stored[:SEAL]:
        raise DamagedError("its digest is not that of its content")
    return stored[SEAL:]


def write_sealed(file: Path, content: bytes) -> None:
    """Write a file, whole or not at all, that nobody else can read."""

    def write(temporary: Path) -> None:
        part = temporary / file.name
        part.touch(mode=0o600)
        part.write_bytes(hashlib.sha256(content).digest() + content)

    file.parent.mkdir(mode=0o700, exist_ok=True)
    write_whole(file.parent, write)


def _remove_unfinished(folder: Path) -> None:
    """Remove what killed writers had begun; others may be writing just now."""
    for entry in os.scandir(folder):
        is_folder = entry.is_dir(follow_symlinks=False)
        if is_folder and time.time() - entry.stat().st_mtime > _LONGEST_WRITE:
            shutil.rmtree(entry.path, ignore_errors=True)


class BoundedCache:
    """Files by name in a folder of the cache; the least recently used ones go."""

    def __init__(self, name: str, most_bytes: int) -> None:
        self._name = name
        self._most_bytes = most_bytes

    def find(self, key: str) -> bytes | None:
        """What is kept under a key; None where there is nothing that is sound."""
        folder = self._folder()
        if folder is None:
            return None
        try:
            stored_key, _, content = read_sealed(folder, key).partition(b"\n")
            os.utime(folder / key, follow_symlinks=False)
        except (OSError, DamagedError):
            return None
        # A copy under another name would be taken for what it is not.
        return content if stored_key == key.encode() else None

    def keep(self, key: str, content: bytes) -> None:
        """Keep something, where that can be done."""
        folder = self._folder()
        if folder is None or len(content) > self._most_bytes:
            return
        with suppress(OSError):
            write_sealed(folder / key, key.encode() + b"\n" + content)
            _remove_unfinished(folder)
            self._remove_oldest(folder)

    def _folder(self) -> Path | None:
        for cache in cache_folders():
            folder = cache / self._name
            with suppress(OSError):
                make_folder(folder)
                refuse_untrusted(folder)
                if os.access(folder, os.W_OK):
                    return folder
        return None

    def _remove_oldest(self, folder: Path) -> None:
        entries = [
            (entry.stat(follow_symlinks=False), entry.path)
            for entry in os.scandir(folder)
            if entry.is_file(follow_symlinks=False)
        ]
        total = sum(status.st_size for status, _ in entries)
        for status, path in sorted(entries, key=lambda entry: entry[0].st_mtime_ns):
            if total <= self._most_bytes:
                break
            Path(path).unlink(missing_ok=True)
            total -= status.st_size
