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

"""A file that is saved again and again, and when what it holds is worth reading."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

POLL_SECONDS = 0.02

REST_SECONDS = 0.06
"""For which a file must stay as it is before it is read: programs write large files in
pieces, and two saves within a tick of the file system's clock look alike."""

BUSY_SECONDS = 0.3  # after which a file is read that never rests


class Stamp(NamedTuple):
    """What of a file differs after a save."""

    nanoseconds: int  # of the last change
    size: int  # bytes
    inode: int  # another one after a rename


class FollowedFile:
    """A file, and which of its saves was read last."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._read_stamp: Stamp | None = None

    def stamp(self) -> Stamp | None:
        """What the file is like now; None where there is none."""
        try:
            status = self.path.stat()
        except OSError:
            return None
        return Stamp(status.st_mtime_ns, status.st_size, status.st_ino)

    def take(self) -> bool:
        """Take the file as it is for what was read last; whether there is one."""
        self._read_stamp = self.stamp()
        return self._read_stamp is not None

    def is_saved_anew(self) -> bool:
        """Whether the file differs from what was read last."""
        return self.stamp() != self._read_stamp

    def wait_for_save(self, should_stop: Callable[[], bool]) -> bool:
        """Wait until another save is there and rests; False where the caller stops.

        A file that is gone is no save: programs delete one before they write it anew.
        """
        latest = self._read_stamp
        begin = last_change = time.monotonic()
        while not should_stop():
            now = time.monotonic()
            stamp = self.stamp()
            if stamp is None or stamp == self._read_stamp:
                begin = now
            if stamp != latest:
                latest = stamp
                last_change = now
            is_resting = now - last_change >= REST_SECONDS
            if (is_resting or now - begin >= BUSY_SECONDS) and (
                stamp not in (None, self._read_stamp)
            ):
                self._read_stamp = stamp
                return True
            time.sleep(POLL_SECONDS)
        return False
