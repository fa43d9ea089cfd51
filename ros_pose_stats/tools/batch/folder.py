"""The folder in which work grows, so that a run that was cut off can go on."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ...base import errors, files, version


class WorkFolder:
    """A folder, locked while in use, with a file that says what work lies in it.

    `request`: all that the work depends on, besides the program: plain values, for JSON;
    `has_work`: whether anything is there that depends on it; `what`: the work, in words: `a
    dataset`.
    """

    def __init__(
        self,
        directory: Path,
        claim: str,
        request: dict[str, Any],
        has_work: Callable[[], bool],
        what: str,
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
                f"{what} that nobody else is making",
                f"{directory} in use",
                "wait for the other run or name another one with -o",
            )
        self._lock = lock
        try:
            self._claim(request, what)
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

    def _claim(self, request: dict[str, Any], what: str) -> None:
        """Write what is asked for, or find the same there."""
        path = self._claimed
        mine = {"written_by": f"ros_pose_stats {version.VERSION}", **request}
        try:
            theirs = json.loads(files.read_file(path))
        except (OSError, ValueError):
            theirs = None
        if theirs == mine:
            return
        if self._has_work():
            found = f"files without a readable {path.name} in {self.directory}"
            if isinstance(theirs, dict):
                others = [
                    f"{name} {value}"
                    for name, value in theirs.items()
                    if value != mine.get(name)
                ]
                found = f"that on another one in {self.directory} ({', '.join(others)})"
            raise errors.BatchError(
                f"work on the same {what.removeprefix('a ')}",
                found,
                "name another one, or finish the work that is there",
            )
        write_durably(path, json.dumps(mine, indent=1).encode())


def write_durably(path: Path, content: bytes) -> None:
    """Write a file that appears whole or not at all, and survives a power cut."""
    with needing_room("what is made", path):
        files.replace_file(path, content)


@contextmanager
def needing_room(
    what: str, place: Path, kinds: tuple[type[Exception], ...] = (OSError,)
) -> Iterator[None]:
    """Refuse a disk that does not take what is written in the context; `kinds`: its errors."""
    try:
        yield
    except kinds as error:
        raise errors.BatchError(
            f"a disk that takes {what}",
            f"{place} ({errors.reason(error)})",
            "make room; the same command then goes on from here",
        ) from error
