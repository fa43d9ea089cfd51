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

"""One file of a bag while it is being written."""

import errno
import os
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from ....base.files import is_file_at, sync_directory, write_all
from . import mcap_layout, message_types


class BagFile:
    """An MCAP file that ends with a whole record whenever a call returns or raises.

    `append` and `finish` are called by one thread at a time, `sync` meanwhile by
    another one. `size`: bytes of whole records; `broken`: why the file cannot be gone
    on with.
    """

    def __init__(
        self, path: Path, types: Mapping[str, message_types.MessageType], node: str = ""
    ) -> None:
        self.path = path
        self.written = 0
        self.broken: OSError | None = None
        self.contents = mcap_layout.describe_topics(types, node)
        self._channels = {
            channel.topic: number for number, channel in self.contents.channels.items()
        }
        self._syncing = threading.Lock()
        self._number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        try:
            self.size = write_all(self._number, [mcap_layout.opening(self.contents)], 0)
            os.fsync(self._number)
            sync_directory(path.parent)
        except OSError:
            os.close(self._number)
            with suppress(OSError):
                path.unlink()
            raise

    def size_with(self, record: int) -> int:
        """The finished file's size with one more record, in bytes."""
        return self.size + record + len(mcap_layout.END)

    def is_gone(self) -> bool:
        """Whether the file was deleted, moved or replaced; OSError if unknown."""
        return not is_file_at(self._number, self.path)

    def append(self, topic: str, data: memoryview, log_time: int) -> None:
        """Hand a message to the operating system; OSError: it is not in the file."""
        channel = self._channels[topic]
        number = self.contents.counts[channel]
        end = self._write(
            [mcap_layout.message_head(channel, number, log_time, data), data]
        )
        self.contents.count(channel, log_time)
        self.size = end
        self.written += 1

    def sync(self) -> None:
        """Have all that was appended on the disk; an OSError breaks the file.

        The kernel forgets what it could not write: a second try would succeed with
        nothing done.
        """
        with self._syncing, self._breaking():
            if self._number >= 0:  # else it was finished meanwhile, and is durable
                os.fdatasync(self._number)

    def finish(self) -> None:
        """Write the end, durably, and close.

        After an OSError the file ends with its last message.
        """
        with self._syncing:
            if self.broken is not None:
                raise self.broken
            end = self._write([mcap_layout.END])
            with self._breaking():
                os.fsync(self._number)
            self.size = end
            self._close()

    def abandon(self) -> None:
        """Close without a footer; a further sync raises that it is gone, or broken."""
        with self._syncing:
            self.broken = self.broken or OSError(
                errno.ENOENT, os.strerror(errno.ENOENT)
            )
            self._close()

    @contextmanager
    def _breaking(self) -> Iterator[None]:
        """Have an error break the file, for good."""
        if self.broken is not None:
            raise self.broken
        try:
            yield
        except OSError as error:
            self.broken = error
            raise

    def _close(self) -> None:
        number = self._number
        self._number = -1
        with suppress(OSError):
            os.close(number)

    def _write(self, buffers: list[bytes | memoryview]) -> int:
        """Write behind the last whole record; return the new end."""
        try:
            return write_all(self._number, buffers, self.size)
        except OSError:
            try:
                os.ftruncate(self._number, self.size)  # half a record goes
            except OSError as error:
                self.broken = error
            raise
