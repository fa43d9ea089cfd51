"""The record of one run, as the node keeps it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from itertools import count
from pathlib import Path

from ..repair.removal import SpaceBound
from ..run_names import new_run_name
from .bag import Bag
from .mcap_layout import message_size, opening
from .message_types import CdrLength, MessageType
from .own_files import OwnFiles


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
    thread; those that wait for the disk share one sync. A file that cannot be gone on with is
    followed by another one, and a bag that was deleted or moved away by another bag.

    `log_directory`: made when it is needed; `types`: type of each topic that may be written;
    `max_bag_bytes`: a file that would grow beyond it is finished and followed by the next;
    `max_log_bytes`: bound of the log directory, this bag included; 0 for no bound. To stay below
    it the oldest finished runs are deleted, then the oldest closed files of this bag, which are at
    most an eighth of the bound; `name`: of the directory, in place of one made from time and
    process; `node`: name of the node that records; several may share a log directory. Attributes
    `directory`: where the bag is, or will be once something is written. It changes when the bag is
    lost; `times_lost`: how often the bag was found deleted or moved away. What had been written is
    not written again; `own_files`: which files of this bag go to make room.
    """

    def __init__(self, log_directory: Path, types: Mapping[str, MessageType], *,
                 max_bag_bytes: int, max_log_bytes: int = 0, name: str | None = None,
                 node: str = "") -> None:
        self.directory = log_directory / (name or new_run_name(log_directory))
        self.times_lost = 0
        self._types = dict(types)
        self._node = node
        self._lengths = {topic: CdrLength(kind) for topic, kind in types.items()}
        self._marks = count(1)
        start = len(opening("", self._types, 0, node)[0])
        self._overhead = 3 * start
        self.own_files = OwnFiles(max_log_bytes, max_bag_bytes, start)
        self._space = SpaceBound(log_directory, max_log_bytes, self.own_files.margin)
        self._lock = threading.Lock()
        self._bag: Bag | None = None
        self._closed = False
        self._last_time = 0

    def write(self, topic: str, data: bytes, *, durable: bool) -> None:
        """Record a message.

        `data`: CDR with its header of 4 bytes. What follows the message in it is left out;
        `durable`: return only once this and everything before it are on the disk. Raises
        RecordingError: it is not recorded, or nobody knows; the next write tries again.
        """
        message = self._lengths[topic].trimmed(data)
        try:
            with self._lock:
                bag = self._bag_for(message_size(message))
                self._last_time = max(time.time_ns(), self._last_time + 1)
                before = bag.mark
                file, number = bag.append(topic, message, self._last_time)
                if bag.mark != before:
                    self.own_files.look_ahead(bag, self._space)
            if durable:
                file.sync(number)
        except OSError as error:
            raise RecordingError(self.directory, error) from error

    def sync(self) -> None:
        """Make everything written so far durable.

        Raises RecordingError: nobody knows whether it is.
        """
        with self._lock:
            file = self._bag.file if self._bag else None
        try:
            if file is not None:
                file.sync(file.written)
        except OSError as error:
            raise RecordingError(self.directory, error) from error

    def keep_runs(self, in_use: Callable[[Path], bool]) -> None:
        """Have runs asked for before they are deleted to make room, by their directories.

        That happens while this log is locked; nothing of it may be called meanwhile.
        """
        self._space.in_use = in_use

    def release_files(self, below: int) -> None:
        """Have files of this bag with a lower mark deleted, where there is need of room.

        Raises RecordingError: it cannot be seen what there is.
        """
        try:
            with self._lock:
                self.own_files.released = below
                self._space.look_again()
                if self._bag is not None:
                    self._make_room(0)
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
    def mark(self) -> int:
        """A number that rises with each file; what is written later has this one or more."""
        with self._lock:
            return self._bag.mark if self._bag else 0

    @property
    def room_to_keep(self) -> int | None:
        """Bytes that can be written again and again to be kept; None without a bound."""
        return self.own_files.room_to_keep(self._space)

    @property
    def bytes_written(self) -> int:
        """Bytes of the bag's files."""
        with self._lock:
            return self._bag.size if self._bag else 0

    @property
    def bytes_left(self) -> int | None:
        """Bytes by which the log directory may still grow; None without a bound."""
        return self._space.left(self.bytes_written)

    @property
    def over_bound(self) -> bool:
        """Whether the log directory is beyond its bound and nothing in it may be deleted now."""
        return self._space.exceeded

    @property
    def waits(self) -> bool:
        """Whether something is to be deleted once what counts in it has been recorded again."""
        return self._space.waits or self.own_files.waits

    @property
    def deleted_runs(self) -> list[Path]:
        """Runs that were deleted to make room, since this was last asked."""
        with self._lock:
            deleted, self._space.deleted = self._space.deleted, []
        return deleted

    def _bag_for(self, record: int) -> Bag:
        """The bag for a record of so many bytes."""
        if self._closed:
            raise OSError("the log is closed")
        if self._bag is not None and self._bag.is_gone():
            self._bag.abandon()
            self._bag = None
            self.times_lost += 1
            self.directory = self.directory.with_name(new_run_name(self.directory.parent))
        self._make_room(record)
        if self._bag is None:
            if self.directory.exists():
                self.directory = self.directory.with_name(new_run_name(self.directory.parent))
            self._bag = Bag(self.directory, self._types, self.own_files.max_bytes,
                            self._node, self._marks)
        return self._bag

    def _make_room(self, record: int) -> None:
        """Delete what must go before a record of so many bytes is written.

        Beside the record there may be the end of one file, a whole empty one, and for a moment
        both the old and the new metadata.yaml.
        """
        size = self._bag.size + 2 * self._bag.metadata_size if self._bag else 0
        self._space.enforce(self.directory, size + record + self._overhead,
                            lambda: self.own_files.drop_oldest(self._bag))
