"""The record of one run, as the node keeps it."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from .bag import Bag
from .repair.removal import SpaceBound
from .run_names import new_run_name
from .writer.mcap_layout import message_size, opening
from .writer.message_types import CdrLength, MessageType

_FILES: Final = 8
"""Files that the bound of a log directory has room for at least, so that the oldest can go."""


class RecordingError(OSError):
    """A record, or what belongs to it, could not be made safe.

    Nothing is broken for good: the next write tries again.

    `directory`: the bag that was written to; `cause`: what the operating system said, or what was
    wrong.
    """

    def __init__(self, directory: Path, cause: Exception | str) -> None:
        self.directory = directory
        self.cause = cause
        reason = getattr(cause, "strerror", None) or str(cause) or type(cause).__name__
        super().__init__(f"cannot record to {directory}: {reason}")
        self.errno = getattr(cause, "errno", None)

    def __reduce__(self) -> tuple[type[RecordingError], tuple[Path, str]]:
        reason = getattr(self.cause, "strerror", None) or str(self.cause)
        return type(self), (self.directory, reason)


class RunLog:
    """One run's bag: `<log_directory>/pose_stats_<time>_<microseconds>_<pid>/`.

    Nothing is made before the first record is written. All methods may be called from any
    thread. A file that cannot be gone on with is followed by another one, and a bag that was
    deleted or moved away by another bag.

    `log_directory`: made when it is needed; `types`: type of each topic that may be written;
    `max_bag_bytes`: a file that would grow beyond it is finished and followed by the next;
    `max_log_bytes`: bound of the log directory, this bag included; 0 for no bound. To stay below
    it the oldest finished runs are deleted, then the oldest closed files of this bag, which are at
    most an eighth of the bound; `name`: of the directory, in place of one made from time and
    process; `node`: name of the node that records; several may share a log directory. Attributes
    `directory`: where the bag is, or will be once something is written. It changes when the bag is
    lost; `space`: the bound.
    """

    def __init__(self, log_directory: Path, types: Mapping[str, MessageType], *,
                 max_bag_bytes: int, max_log_bytes: int = 0, name: str | None = None,
                 node: str = "") -> None:
        self.directory = log_directory / (name or new_run_name(log_directory))
        self._times_lost = 0
        self._types = dict(types)
        self._node = node
        self._lengths = {topic: CdrLength(kind) for topic, kind in types.items()}
        start = len(opening("", self._types, 0, node)[0])
        self._overhead = 3 * start
        self._max_bytes = min(max_bag_bytes, max(max_log_bytes // _FILES, 4 * start)
                              if max_log_bytes else max_bag_bytes)
        self.space = SpaceBound(log_directory, max_log_bytes)
        self._lock = threading.Lock()
        self._bag: Bag | None = None
        self._closed = False
        self._last_time = 0

    def write(self, topic: str, data: bytes) -> None:
        """Record a message: it outlives this process, whatever becomes of that.

        `data`: CDR with its header of 4 bytes. What follows the message in it is left out. Raises
        RecordingError: it is not recorded; the next write tries again.
        """
        message = self._lengths[topic].trimmed(data)
        try:
            with self._lock:
                bag = self._bag_for(message_size(message))
                self._last_time = max(time.time_ns(), self._last_time + 1)
                bag.append(topic, message, self._last_time)
        except OSError as error:
            raise RecordingError(self.directory, error) from error

    def sync(self) -> None:
        """Have everything written so far on the disk, where a power cut leaves it.

        Raises RecordingError: nobody knows whether it is.
        """
        with self._lock:
            file = self._bag.file if self._bag else None
        try:
            if file is not None:
                file.sync()
        except OSError as error:
            raise RecordingError(self.directory, error) from error

    def close(self) -> None:
        """Write summary, footer and final metadata, and let go of the bag.

        Raises RecordingError: the bag is not finished; `repair_bags` does that at the next start.
        """
        with self._lock:
            self._closed = True
            bag, self._bag = self._bag, None
            try:
                if bag is not None:
                    bag.finish()
            except OSError as error:
                raise RecordingError(self.directory, error) from error

    @property
    def times_lost(self) -> int:
        """How often the bag was found deleted or moved away; also by this look.

        Raises OSError: nobody knows whether it is there.
        """
        with self._lock:
            self._leave_lost_bag()
            return self._times_lost

    @property
    def place(self) -> tuple[Path, int] | None:
        """The file that is being written, and its bytes; None before the first record."""
        with self._lock:
            file = self._bag.file if self._bag else None
            return None if file is None else (file.path, file.size)

    @property
    def bytes_written(self) -> int:
        """Bytes of the bag's files."""
        with self._lock:
            return self._bag.size if self._bag else 0

    @property
    def bytes_left(self) -> int | None:
        """Bytes by which the log directory may still grow; None without a bound."""
        return self.space.left(self.bytes_written)

    def _bag_for(self, record: int) -> Bag:
        """The bag for a record of so many bytes."""
        if self._closed:
            raise OSError("the log is closed")
        self._leave_lost_bag()
        self._make_room(record)
        if self._bag is None:
            if self.directory.exists():
                self.directory = self.directory.with_name(new_run_name(self.directory.parent))
            self._bag = Bag(self.directory, self._types, self._max_bytes, self._node)
        return self._bag

    def _leave_lost_bag(self) -> None:
        if self._bag is not None and self._bag.is_gone():
            self._bag.abandon()
            self._bag = None
            self._times_lost += 1
            self.directory = self.directory.with_name(new_run_name(self.directory.parent))

    def _make_room(self, record: int) -> None:
        """Delete what must go before a record of so many bytes is written.

        Beside the record there may be the end of one file, a whole empty one, and for a moment
        both the old and the new metadata.yaml.
        """
        size = self._bag.size + 2 * self._bag.metadata_size if self._bag else 0
        self.space.enforce(self.directory, size + record + self._overhead,
                           lambda: self._bag.drop_oldest() if self._bag else None)
