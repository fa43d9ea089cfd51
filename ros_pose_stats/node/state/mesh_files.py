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

"""Large meshes in files of their own, named by the SHA-256 of what is in them.

Others may have files in the same folder. Which are the node's own is known to the state
alone, and so it asks for a removal only of what it has written.
"""

import hashlib
import re
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

from ...base import files

LEAST_BYTES = 64 * 2**10
"""Of a mesh that lies in a file: SQLite would write it twice."""

ReadMesh = Callable[[], bytes | None]
"""Reads a mesh; None where it is gone, or damaged."""

_NAME = re.compile("[0-9a-f]{64}")


def name_of(message: bytes) -> str:
    """Name of the file of a mesh."""
    return hashlib.sha256(message).hexdigest()


class MeshFiles:
    """Meshes in a folder, to be read also where they lie in older folders.

    What lies behind a symbolic link in place of the folder is read only: another state
    may have its meshes there.
    """

    def __init__(self, folder: Path, older_folders: Iterable[Path]) -> None:
        self.folder = folder
        self.older_folders = set(older_folders) - {folder}

    def read(self, name: str) -> bytes | None:
        """A mesh as its name says; None where it is gone, or damaged."""
        for folder in (self.folder, *self.older_folders):
            message = _sound_content(folder, name)
            if message is not None:
                return message
        return None

    def open(self, name: str) -> ReadMesh:
        """What reads a mesh as `read` does, also once its file is removed."""
        opened = []
        if _NAME.fullmatch(name):
            for folder in (self.folder, *self.older_folders):
                with suppress(OSError):
                    opened.append(files.open_file(folder / name))
        lock = threading.Lock()  # of their places

        def read() -> bytes | None:
            with lock:
                for file in opened:
                    with suppress(OSError):
                        file.seek(0)
                        message = file.read()
                        if name_of(message) == name:
                            return message
            return None

        return read

    def has(self, name: str) -> bool:
        """Whether there is anything under a name in the folder itself."""
        path = self.folder / name
        return path.exists() or path.is_symlink()

    def is_sound(self, name: str) -> bool:
        """Whether a mesh lies in the folder itself as its name says."""
        return _sound_content(self.folder, name) is not None

    def write(self, name: str, message: bytes) -> None:
        """Have a mesh on the disk, in place of what is under its name; OSError."""
        files.make_directories(self.folder)
        self._refuse_link()
        path = self.folder / name
        path.unlink(missing_ok=True)
        files.write_new(path, message)
        files.sync_directory(self.folder)

    def remove(self, name: str) -> bool:
        """Remove a file that the state has written; whether it is gone."""
        if not _NAME.fullmatch(name):
            return False
        try:
            self._refuse_link()
            (self.folder / name).unlink(missing_ok=True)
        except OSError:
            return False
        return True

    def _refuse_link(self) -> None:
        if self.folder.is_symlink():
            raise NotADirectoryError(f"{self.folder} is a symbolic link")


def _sound_content(folder: Path, name: str) -> bytes | None:
    if _NAME.fullmatch(name):
        with suppress(OSError):
            message = files.read_file(folder / name)
            if name_of(message) == name:
                return message
    return None
