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

"""The folder in which work grows, so that a run that was cut off can go on."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ...base import errors, files, version


class WorkFolder:
    """A folder, locked while in use, with a file that says what work lies in it.

    `request`: all that the work depends on, besides the program: plain values, for
    JSON; `has_work`: whether anything is there that depends on it; `title`: of the
    work: `a dataset`.
    """

    def __init__(
        self,
        directory: Path,
        claim: str,
        request: dict[str, Any],
        has_work: Callable[[], bool],
        title: str,
    ) -> None:
        self.directory = directory
        self._has_work = has_work
        self._claimed = directory / claim
        try:
            directory.mkdir(parents=True, exist_ok=True)
            lock = files.DirectoryLock.take(directory)
        except OSError as error:
            raise errors.BatchError(
                "a directory that can be written to",
                f"{directory} ({errors.reason(error)})",
                "name another one with -o",
            ) from error
        if lock is None:
            raise errors.BatchError(
                f"{title} that nobody else is making",
                f"{directory} in use",
                "wait for the other run or name another one with -o",
            )
        self._lock = lock
        try:
            self._claim(request, title)
        except BaseException:
            self.release()
            raise

    def __enter__(self) -> "WorkFolder":
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def release(self) -> None:
        """Let others have it; without any work in it, for whatever they do."""
        if not self._has_work():
            with suppress(OSError):  # leftovers do no harm
                self._claimed.unlink(missing_ok=True)
                files.remove_empty(self.directory)
        self._lock.release()

    def _claim(self, request: dict[str, Any], title: str) -> None:
        """Write what is asked for, or find the same there."""
        path = self._claimed
        our_claim = {"written_by": f"ros_pose_stats {version.VERSION}", **request}
        try:
            their_claim = json.loads(files.read_file(path))
        except (OSError, ValueError, RecursionError):
            their_claim = None
        if their_claim == our_claim:
            return
        if self._has_work():
            obstacle = f"files without a readable {path.name} in {self.directory}"
            if isinstance(their_claim, dict):
                others = [
                    f"{name} {value}"
                    for name, value in their_claim.items()
                    if value != our_claim.get(name)
                ]
                obstacle = (
                    f"that on another one in {self.directory} ({', '.join(others)})"
                )
            raise errors.BatchError(
                f"work on the same {title.removeprefix('a ')}",
                obstacle,
                "name another one, or finish the work that is there",
            )
        write_durably(path, json.dumps(our_claim, indent=1).encode())


def write_durably(path: Path, content: bytes) -> None:
    """Write a file that appears whole or not at all, and survives a power cut."""
    with needing_room("what is made", path):
        files.replace_file(path, content)


@contextmanager
def needing_room(
    content: str, path: Path, kinds: tuple[type[Exception], ...] = (OSError,)
) -> Iterator[None]:
    """Refuse a disk that is full in the context; `kinds`: its errors."""
    try:
        yield
    except kinds as error:
        raise errors.BatchError(
            f"a disk that takes {content}",
            f"{path} ({errors.reason(error)})",
            "make room; the same command then goes on from here",
        ) from error
