"""Who has a run's directory in hand: the node that writes it, or one that mends or removes it.

The lock is the kernel's (flock on a file in the directory), so that it ends with its process,
however that ends.
"""

from __future__ import annotations

import errno
import fcntl
import os
import time
from pathlib import Path
from types import TracebackType
from typing import Final

from .run_names import LOCK

_GLANCES: Final = 5
"""A lock found taken is tried again this often: somebody may only have looked at it."""

_GLANCE: Final = 0.002
"""Seconds between two tries; looking takes microseconds."""

_TAKEN = frozenset((errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES))


class DirectoryLock:
    """The lock of one directory, held until released or until the process ends."""

    def __init__(self, number: int) -> None:
        self._number = number

    @classmethod
    def take(cls, directory: Path) -> DirectoryLock | None:
        """The directory's lock; None where another process, or another log, has it.

        Raises OSError: there is no such directory, or no lock file can be made in it.
        """
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
        """Whether it is this directory's: not when that was deleted or moved away.

        Raises OSError: nobody knows.
        """
        return is_file_at(self._number, directory / LOCK)

    def release(self) -> None:
        """Let go of the directory; the lock file stays, so that nobody locks a deleted one."""
        if self._number >= 0:
            os.close(self._number)
        self._number = -1

    def __enter__(self) -> DirectoryLock:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.release()


def is_locked(directory: Path) -> bool:
    """Whether somebody has a directory in hand at this moment."""
    try:
        number = os.open(directory / LOCK, os.O_RDONLY | os.O_NONBLOCK)
    except OSError:
        return False
    try:
        return not _try(number, fcntl.LOCK_SH)
    finally:
        os.close(number)


def is_file_at(number: int, path: Path) -> bool:
    """Whether an open file is still to be found at a path.

    Raises OSError: nobody knows.
    """
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
