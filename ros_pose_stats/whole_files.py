"""Files that appear whole or not at all, and those of users that are files indeed."""

from __future__ import annotations

import errno
import json
import os
import shutil
import stat
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, BinaryIO

from .errors import RequestError

PREFIX = ".unfinished-"

_KINDS = {stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device",
          stat.S_IFBLK: "a device"}


class NotAFileError(OSError):
    """A pipe, a socket or a device where a file was expected; `strerror` says which."""


def open_file(file: str | os.PathLike[str]) -> BinaryIO:
    """Open a regular file, or a link to one, for reading: a pipe or a device may never end.

    Raises NotAFileError if it is something else. Raises OSError if it cannot be opened.
    """
    _refuse_others(os.stat(file).st_mode, file)  # noqa: PTH116 - opening may already do something
    # Another file may have taken its name since, and a pipe waits for whoever writes to it.
    number = os.open(file, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
    try:
        _refuse_others(os.fstat(number).st_mode, file)
        return os.fdopen(number, "rb")
    except OSError:
        os.close(number)
        raise


def _refuse_others(mode: int, file: str | os.PathLike[str]) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(file))
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), "something else")
        raise NotAFileError(errno.EINVAL, f"{kind}, no file", os.fspath(file))


def read_file(file: str | os.PathLike[str], most: int | None = None) -> bytes:
    """Bytes of a regular file, one more than `most` where there are more than that.

    Raises NotAFileError, OSError as `open_file` does.
    """
    with open_file(file) as stream:
        return stream.read() if most is None else stream.read(most + 1)


def write_whole(folder: Path, write: Callable[[Path], object]) -> list[Path]:
    """Write files in a temporary folder, then move them into their folder.

    `folder`: created where it does not exist; `write`: given an empty folder on the same file
    system, writes files into it. If that fails or is interrupted, nothing has changed. Returns the
    files where they are now, in the order of their names.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(prefix=PREFIX, dir=folder) as name:
        aside = Path(name)
        write(aside)
        files = sorted(one for one in aside.rglob("*") if one.is_file())
        targets = [folder / one.relative_to(aside) for one in files]
        for target in targets:
            target.parent.mkdir(parents=True, exist_ok=True)
        for file, target in zip(files, targets, strict=True):
            file.replace(target)
    return targets


def write_file(file: Path, data: bytes) -> None:
    """Write one file, whole or not at all, and create its folder."""
    write_whole(file.parent, lambda aside: (aside / file.name).write_bytes(data))


def remove_unfinished(folder: Path) -> None:
    """Remove what `write_whole` had begun there when its process was killed.

    Only for whoever knows that nobody else is writing there.
    """
    for left in folder.glob(f"{PREFIX}*"):
        shutil.rmtree(left, ignore_errors=True)  # leftovers do no harm


def write_json(file: Path, values: Any) -> None:
    """Plain values as indented JSON; the folder is created. NaN and infinity are refused."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(values, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def refuse_unwritable(folder: Path) -> None:
    """Check, before anything is measured, that files can be written to a folder.

    Raises RequestError if they cannot. The folder need not exist, and is not created.
    """
    path = folder.absolute()
    try:
        there = next(one for one in (path, *path.parents) if one.exists())
        with TemporaryDirectory(prefix=PREFIX, dir=there):
            pass
    except OSError as error:
        raise RequestError("a folder that can be written to",
                           f"{folder} ({error.strerror or error})",
                           "name another one with -o") from error
