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

"""The directory in which a dataset grows, so that a run that was cut off can go on."""

from __future__ import annotations

import io
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from ros_pose_stats.base.errors import BatchError, reason
from ros_pose_stats.base.files import HALF, LOCK
from ros_pose_stats.tools.batch.folder import WorkFolder, write_durably

from .archive import FIELDS, Arrays, check_arrays
from .spec import DatasetError, DatasetSpec

SPEC = "spec.json"
PIECES = "bodies_*.npz"


class Unfinished:
    """Pieces of a dataset beside the file that it will be, `<file>.unfinished`.

    The directory is locked while in use, and each piece appears whole or not at all. A
    directory that is left without a piece is deleted.

    Parameters
    ----------
    file : Path
        Of the whole dataset.
    spec : DatasetSpec

    Raises
    ------
    BatchError
        If the directory holds pieces of another dataset, is in use, or cannot be
        written.
    """

    def __init__(self, file: Path, spec: DatasetSpec) -> None:
        self.directory = directory_of(file)
        self._spec = spec
        self._folder = WorkFolder(
            self.directory, SPEC, spec.as_dict(), self._any_piece, "a dataset"
        )

    def __enter__(self) -> Unfinished:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if not self._any_piece():
            self.remove()
        self._folder.release()

    def sound_pieces(self) -> list[tuple[int, int]]:
        """Sound pieces in the directory, as (first body, number of bodies)."""
        return [
            piece for piece in self._spec.chunks if self._read_piece(piece) is not None
        ]

    def store_piece(self, piece: tuple[int, int], arrays: Arrays) -> None:
        """Keep a piece."""
        stream = io.BytesIO()
        fields: dict[str, Any] = dict(arrays)
        np.savez(stream, **fields)
        write_durably(self._path(piece), stream.getvalue())

    def pieces(self) -> list[Arrays]:
        """All pieces in the order of their bodies.

        Raises
        ------
        DatasetError
            If one has gone, or has been damaged since it was written.
        """
        chunks = [self._read_piece(piece) for piece in self._spec.chunks]
        whole = [arrays for arrays in chunks if arrays is not None]
        if len(whole) < len(chunks):
            raise DatasetError(
                f"{len(chunks)} whole pieces in {self.directory}",
                f"{len(whole)}",
                "run the same command again",
            )
        return whole

    def remove(self) -> None:
        """Delete the pieces, and the directory if nothing else is in it."""
        with suppress(OSError):  # leftovers do no harm
            for pattern in (PIECES, PIECES + HALF, SPEC + "*", LOCK):
                for path in self.directory.glob(pattern):
                    path.unlink()
            self.directory.rmdir()

    def _read_piece(self, piece: tuple[int, int]) -> Arrays | None:
        """Read a piece; None where it is missing or damaged."""
        path = self._path(piece)
        try:
            with np.load(path, allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in FIELDS}
            check_arrays(arrays, self._spec, piece[1])
        except FileNotFoundError:
            return None
        except OSError as error:
            raise DatasetError(
                "pieces that can be read", f"{path} ({reason(error)})", "check the disk"
            ) from error
        except Exception:  # damaged, in one of a dozen ways
            return None
        return arrays

    def _path(self, piece: tuple[int, int]) -> Path:
        first, count = piece
        return self.directory / f"bodies_{first:07d}_{first + count - 1:07d}.npz"

    def _any_piece(self) -> bool:
        return any(self.directory.glob(PIECES))


def clear_leftovers(file: Path, spec: DatasetSpec) -> None:
    """Delete the pieces of a dataset whose run wrote the file but was cut off before
    their end.
    """
    if directory_of(file).is_dir():
        with suppress(BatchError), Unfinished(file, spec) as unfinished:
            unfinished.remove()


def directory_of(file: Path) -> Path:
    """Where the pieces of a dataset lie."""
    return file.with_name(f"{file.name}.unfinished")
