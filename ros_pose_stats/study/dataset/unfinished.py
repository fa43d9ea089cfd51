"""The directory in which a dataset grows, so that a run that was cut off can go on."""

from __future__ import annotations

import io
import json
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from ...errors import DatasetError
from ...recording.directory_lock import DirectoryLock
from ...recording.run_names import HALF, LOCK
from ...version import VERSION
from .archive import FIELDS, Arrays, check_arrays, reason, write_whole
from .spec import DatasetSpec

SPEC = "spec.json"
PIECES = "bodies_*.npz"


class Unfinished:
    """Pieces of a dataset beside the file that it will be, `<file>.unfinished`.

    The directory is locked while in use, and each piece appears whole or not at all. A directory
    that is left without a piece is deleted.

    Parameters
    ----------
    file : Path
        Of the whole dataset.
    spec : DatasetSpec

    Raises
    ------
    DatasetError
        If the directory holds pieces of another dataset, is in use, or cannot be written.
    """

    def __init__(self, file: Path, spec: DatasetSpec) -> None:
        self.directory = directory_of(file)
        self._spec = spec
        try:
            self.directory.mkdir(parents=True, exist_ok=True)
            lock = DirectoryLock.take(self.directory)
        except OSError as error:
            raise DatasetError("a directory that can be written to",
                               f"{self.directory} ({reason(error)})",
                               "name another file with -o") from error
        if lock is None:
            raise DatasetError("a dataset that nobody else is making", f"{self.directory} in use",
                               "wait for the other run or name another file with -o")
        self._lock = lock
        try:
            self._claim()
        except BaseException:
            self.__exit__(None, None, None)
            raise

    def __enter__(self) -> Unfinished:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        if not any(self.directory.glob(PIECES)):
            self.remove()
        self._lock.release()

    def done(self) -> list[tuple[int, int]]:
        """Sound pieces in the directory, as (first body, number of bodies)."""
        return [piece for piece in self._spec.chunks if self._read(piece) is not None]

    def put(self, piece: tuple[int, int], arrays: Arrays) -> None:
        """Keep a piece."""
        stream = io.BytesIO()
        fields: dict[str, Any] = dict(arrays)
        np.savez(stream, **fields)
        write_whole(self._path(piece), stream.getvalue())

    def pieces(self) -> list[Arrays]:
        """All pieces in the order of their bodies.

        Raises
        ------
        DatasetError
            If one has gone, or has been damaged since it was written.
        """
        found = [self._read(piece) for piece in self._spec.chunks]
        whole = [arrays for arrays in found if arrays is not None]
        if len(whole) < len(found):
            raise DatasetError(f"{len(found)} whole pieces in {self.directory}",
                               f"{len(whole)}", "run the same command again")
        return whole

    def remove(self) -> None:
        """Delete the pieces, and the directory if nothing else is in it."""
        with suppress(OSError):  # leftovers do no harm
            for pattern in (PIECES, PIECES + HALF, SPEC + "*", LOCK):
                for path in self.directory.glob(pattern):
                    path.unlink()
            self.directory.rmdir()

    def _read(self, piece: tuple[int, int]) -> Arrays | None:
        """Read a piece; None where it is missing or damaged."""
        path = self._path(piece)
        try:
            with np.load(path, allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in FIELDS}
            check_arrays(arrays, self._spec, piece[1])
        except FileNotFoundError:
            return None
        except OSError as error:
            raise DatasetError("pieces that can be read", f"{path} ({reason(error)})",
                               "check the disk") from error
        except Exception:  # damaged, in one of a dozen ways
            return None
        return arrays

    def _path(self, piece: tuple[int, int]) -> Path:
        first, count = piece
        return self.directory / f"bodies_{first:07d}_{first + count - 1:07d}.npz"

    def _claim(self) -> None:
        """Write the specification, or find the same one there."""
        path = self.directory / SPEC
        mine = _told(self._spec)
        try:
            theirs = json.loads(path.read_bytes())
        except (OSError, ValueError):
            theirs = None
        if theirs == mine:
            return
        if any(self.directory.glob(PIECES)):
            told = theirs if isinstance(theirs, dict) else {SPEC: "unreadable"}
            others = [f"{name} {value}" for name, value in told.items()
                      if value != mine.get(name)]
            raise DatasetError("pieces of the same dataset",
                               f"those of another one in {self.directory} ({', '.join(others)})",
                               "finish that one, delete the directory, or name another file")
        write_whole(path, json.dumps(mine, indent=1).encode())


def clear_leftovers(file: Path, spec: DatasetSpec) -> None:
    """Delete the pieces of a dataset whose run wrote the file but was cut off before their end."""
    if directory_of(file).is_dir():
        with suppress(DatasetError), Unfinished(file, spec) as unfinished:
            unfinished.remove()


def directory_of(file: Path) -> Path:
    """Where the pieces of a dataset lie."""
    return file.with_name(f"{file.name}.unfinished")


def _told(spec: DatasetSpec) -> dict[str, Any]:
    return {"written_by": f"ros_pose_stats {VERSION}", **spec.as_dict()}
