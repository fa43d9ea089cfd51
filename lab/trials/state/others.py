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

"""Files of other people beside a state, as somebody may put them there."""

import hashlib
import sqlite3
from contextlib import closing


class FilesOfOthers:
    """Files and links in both folders that are named after a state, and beside it."""

    def __init__(self, state_file):
        self._state_file = state_file
        self._meshes = state_file.with_name(f"{state_file.name}.meshes")
        self._paths = []
        for folder in (self._meshes, state_file.with_name(f"{state_file.stem}.meshes")):
            (folder / "drawings").mkdir(parents=True)
            for name in (
                "bracket.stl",
                "drawings/bracket.pdf",
                "0" * 64,
                hashlib.sha256(b"theirs").hexdigest(),
                f"{'0' * 64}.half",
            ):
                self._write(folder / name)
            link = folder / ("1" * 64)
            link.symlink_to(folder / "bracket.stl")
            self._paths.append(link)
        for end in (".half", ".csv"):
            self._write(state_file.with_name(state_file.name + end))
        self._before = self._picture()

    def _write(self, path):
        path.write_bytes(b"theirs")
        self._paths.append(path)

    def __len__(self):
        return len(self._paths)

    def _picture(self):
        """What a change would show in: content, age, identity; None if it is gone."""
        return {
            path: (
                path.readlink() if path.is_symlink() else path.read_bytes(),
                path.lstat().st_mtime_ns,
                path.lstat().st_ino,
            )
            if path.is_symlink() or path.exists()
            else None
            for path in self._paths
        }

    def touched(self):
        """A line for each that is not as it was."""
        present = self._picture()
        return [
            f"{path} of somebody else is {'changed' if present[path] else 'gone'}"
            for path, before in self._before.items()
            if present[path] != before
        ]

    def leftovers(self):
        """A line for each other file among the meshes that no part has."""
        with closing(sqlite3.connect(self._state_file)) as link:
            rows = link.execute("SELECT file FROM meshes").fetchall()
        used = {self._meshes / name for (name,) in rows}
        return [
            f"{path.name} is left over of a kill"
            for path in self._meshes.iterdir()
            if path not in {*used, *self._paths} and path.is_file()
        ]
