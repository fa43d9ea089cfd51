"""The directory of a run: made, locked, found gone, and described to rosbag2."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path

from ..directory_lock import DirectoryLock
from ..durable import make_directories, replace_file, sync_directory
from ..repair.removal import remove_empty
from ..run_names import METADATA, being_made
from .bag_metadata import Files, metadata_yaml


class BagDirectory:
    """A directory that is locked from the moment it has its name.

    Another node that starts at this moment sees no directory, or one that is locked. It may
    remove what has not got its name yet; then this fails and is tried again.

    Parameters
    ----------
    path : Path
        Must not exist yet.

    Raises
    ------
    OSError
        It could not be made; nothing is left of it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
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
        self._lock = lock

    def is_gone(self) -> bool:
        """Whether the directory, or the lock in it, was deleted, moved or replaced."""
        return not self._lock.holds(self.path)

    def describe(self, files: Files) -> None:
        """Write `metadata.yaml` anew."""
        replace_file(self.path / METADATA, metadata_yaml(files).encode())

    def release(self) -> None:
        """Let others have the directory; without a bag in it, it goes."""
        with suppress(OSError):
            if not self.is_gone():
                remove_empty(self.path)
        self._lock.release()
