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

"""The node's state: changes are handed in by anybody and written many at a time."""

import os
import sqlite3
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path

from ...base import errors, files
from . import mesh_files, tables
from .tables import Change, Row


class State:
    """Rows of the tables in `tables.COLUMNS`, in a file that one living node has.

    `problem` says why changes cannot be written now, which are kept and tried again;
    `set_aside` names a file that could not be read.
    """

    def __init__(
        self,
        file: Path,
        definitions: Mapping[str, str] | None = None,
        convert: tables.Convert = lambda kind, definition, data: None,
        say: Callable[[str], object] = lambda line: None,
        patience: float = tables.LOCK_SECONDS,
    ) -> None:
        self.file = Path(os.path.realpath(file))
        older_names = (
            path.with_name(f"{path.stem}.meshes") for path in (file, self.file)
        )
        self.meshes = mesh_files.MeshFiles(
            self.file.with_name(f"{self.file.name}.meshes"), older_names
        )
        self.problem = self.set_aside = ""
        self._definitions = dict(definitions or {})
        self._convert = convert
        self._say = say
        self._link: sqlite3.Connection | None = None
        self._link_stat: os.stat_result | None = None  # of the connection's file
        self._lock: int | None = None  # descriptor of the lock file
        # Each row in a tuple of its own, by which a later equal one is told from it.
        self._pending: dict[tuple[str, str | bytes], tuple[Row | None]] = {}
        self._number = 0  # of the last change
        self._committed_number = 0  # number of the last change that is on the disk
        self._tried_number = 0  # number of the last change that was to be written
        self.writes = 0  # times that the file was written, or was to be
        self._is_closed = False
        self._changing = threading.Lock()
        self.in_use = threading.Lock()  # held while the file is written or read
        self._filing = threading.Lock()  # held while files of meshes come or go
        self._replaced: set[str] = set()  # files whose mesh may be no part's any more
        self._adopted = 0  # meshes of an older version that were copied
        try:
            files.refuse_irregular(file)
            self._open(patience)
            self._remove_replaced()
        except (files.NotAFileError, IsADirectoryError) as error:
            raise errors.RequestError(
                "state_file to be a file",
                f"'{file}' ({error.strerror})",
                "name another one",
            ) from error
        except (sqlite3.Error, OSError) as error:
            self.problem = tables.problem_of(file, error)
            say(f"NOT_RECORDED: {self.problem}")
        except errors.RequestError:
            self._release()
            raise

    def put(self, *changes: Change) -> int:
        """Hand changes in that belong together; the number that `commit` takes."""
        with self._changing:
            for change in changes:
                self._pending[change.table, change.key] = (change.row,)
            self._number += 1
            return self._number

    def put_mesh(self, part_id: str, message: bytes, *changes: Change) -> int:
        """Hand in the mesh of a part, a large one as a file, and its changes."""
        if len(message) < mesh_files.LEAST_BYTES:
            return self.put(Change("meshes", part_id, (part_id, message, "")), *changes)
        name = mesh_files.name_of(message)
        with self._filing:
            row: Row = (part_id, b"", name)
            # Where there is no file it is tried as a row, which says what is wrong.
            if not self._have_file(name, message):
                row = (part_id, message, "")
            return self.put(Change("meshes", part_id, row), *changes)

    def _have_file(self, name: str, message: bytes) -> bool:
        """Have a mesh in a file, which the state knows as its own before it is made."""
        if self.meshes.is_sound(name):
            return True
        if self.get("files", name) is None:
            if self.meshes.has(name):  # somebody else's
                return False
            if not self.commit(self.put(Change("files", name, (name,)))):
                return False
        try:
            self.meshes.write(name, message)
        except OSError:
            return False
        return True

    def commit(self, number: int | None = None) -> bool:
        """Write a change and all before it, or all; whether they are on the disk.

        What comes while another thread writes is written together, by one of those who
        wait.
        """
        with self._changing:
            if number is None:
                number = self._number
            writes = self.writes
            if self._committed_number >= number:
                return True
        with self.in_use:
            with self._changing:
                is_tried = self.writes > writes and self._tried_number >= number
                if self._committed_number >= number or is_tried or self._is_closed:
                    return self._committed_number >= number
                batch = dict(self._pending)
                self._tried_number = self._number
            problem = ""
            try:
                self._write([Change(*key, row) for key, (row,) in batch.items()])
            except Exception as error:  # whoever waits hears of it
                problem = tables.problem_of(self.file, error)
            with self._changing:
                self.writes += 1
                if not problem:
                    self._committed_number = self._tried_number
                    self._pending = {
                        key: entry
                        for key, entry in self._pending.items()
                        if batch.get(key) is not entry
                    }
                is_news = bool(problem) != bool(self.problem)
                self.problem = problem
        if is_news and problem:
            self._say(f"NOT_RECORDED: {problem}")
        elif is_news:
            self._say(f"the state file {self.file} is written again")
        self._remove_replaced()
        return not problem

    def get(self, table: str, key: str | bytes) -> Row | None:
        """A row by its key, as it was handed in last; None where there is none."""
        with self._changing:
            pending = self._pending.get((table, key))
        if pending is not None:
            return pending[0]
        with self.in_use, suppress(sqlite3.Error):
            if self._link is not None:
                return tables.look_up(self._link, table, key)
        return None

    def rows(self, table: str) -> list[Row]:
        """All rows of a table that the file has, in the order of their making."""
        with self.in_use:
            return [] if self._link is None else tables.rows_of(self._link, table)

    def mesh(self, part_id: str) -> bytes | None:
        """The mesh of a part as it was handed in; None where it is gone, or damaged."""
        row = self.get("meshes", part_id)
        if row is None:
            return None
        _, message, name = row
        return self.meshes.read(name) if name else message

    def open_mesh(self, part_id: str) -> mesh_files.ReadMesh:
        """What reads the mesh of a part as `mesh` does, also once the state lost it."""
        row = self.get("meshes", part_id)
        if row is None:
            return lambda: None
        _, message, name = row
        return self.meshes.open(name) if name else lambda: message

    def close(self) -> bool:
        """Write what waits, and let go of the file; whether all of it is written."""
        written = self.commit()
        with self.in_use:
            self._is_closed = True
            self._release()
        return written

    def _release(self) -> None:
        self._use(None)
        self._unlock()

    def _unlock(self) -> None:
        lock = self._lock
        self._lock = None
        if lock is not None:
            os.close(lock)

    def _write(self, changes: list[Change]) -> None:
        if self._link is None:
            self._open(0.0)
        elif not self._is_file_of_link():
            self._make_anew(self._link)
        elif self.problem:
            self._use(tables.connect(self.file))
        link = self._link
        assert link is not None
        rows = [
            tables.look_up(link, table, key)
            for table, key, _ in changes
            if table == "meshes"
        ]
        tables.write(link, changes)
        with self._changing:
            self._replaced |= {row[2] for row in rows if row is not None and row[2]}

    def _is_file_of_link(self) -> bool:
        """Whether the connection's file is still the one under its name."""
        return (
            self._link_stat is not None
            and self.file.exists()
            and os.path.samestat(self.file.stat(), self._link_stat)
        )

    def _open(self, patience: float) -> None:
        """Take the file and see whether it is sound; one that is not is set aside."""
        files.make_directories(self.file.parent)
        if self._lock is None:
            self._lock = tables.lock_file(self.file, patience)
        tables.refuse_hard_links(self.file)
        try:
            link = self._connect_soundly()
        except Exception as error:
            if not tables.is_damage(error):
                raise
            self.set_aside = tables.set_aside(self.file)
            self._say(
                f"the state file {self.file} cannot be read ({error}); it is now "
                f"{self.set_aside}, and the node starts without it; meshes in "
                f"{self.meshes.folder} stay there"
            )
            link = self._connect_soundly()
        self._use(link)
        self._copy_older_meshes(link)
        with self._changing:
            self._replaced |= {name for (name,) in tables.rows_of(link, "files")}

    def _copy_older_meshes(self, link: sqlite3.Connection) -> None:
        """Copy meshes from where older versions have them; `read` finds the others."""
        with suppress(OSError, sqlite3.Error):
            for name in tables.files_of_meshes(link):
                message = None if self.meshes.has(name) else self.meshes.read(name)
                if message is not None:
                    self._adopt(link, name, message)
        if self._adopted:
            older_folders = " and ".join(map(str, self.meshes.older_folders))
            self._say(
                f"{self._adopted} meshes of an older version are copied to "
                f"{self.meshes.folder}; {older_folders} may be deleted, unless another "
                "node has its own there"
            )

    def _adopt(self, link: sqlite3.Connection, name: str, message: bytes) -> None:
        """Have a mesh in a file of the state's own; raises OSError, sqlite3.Error."""
        tables.write(link, [Change("files", name, (name,))])
        self.meshes.write(name, message)
        self._adopted += 1

    def _convert_file(
        self,
        link: sqlite3.Connection,
        name: str,
        convert: Callable[[bytes], bytes | None],
    ) -> str | None:
        """Have a mesh as a message of today in another file; None where it is broken.

        One that is gone keeps its name: its part is to be sent again.
        """
        message = self.meshes.read(name)
        if message is None:
            return name
        converted = convert(message)
        if converted is None:
            return None
        new_name = mesh_files.name_of(converted)
        if not self.meshes.is_sound(new_name):
            self._adopt(link, new_name, converted)
        return new_name

    def _connect_soundly(self) -> sqlite3.Connection:
        """Connect, and look at every row; messages become those of today."""
        link = tables.connect(self.file)
        try:
            tables.check_sound(link)
            tables.update_messages(
                link,
                self._definitions,
                self._convert,
                partial(self._convert_file, link),
            )
        except BaseException:
            link.close()
            raise
        return link

    def _use(self, link: sqlite3.Connection | None) -> None:
        """Work with a connection, or with none, from now on."""
        link_stat = None if link is None else self.file.stat()
        previous = self._link
        self._link = link
        self._link_stat = link_stat
        if previous is not None:
            with suppress(sqlite3.Error):
                previous.close()

    def _make_anew(self, old: sqlite3.Connection) -> None:
        """Write what the deleted file has, which is open yet, into one of its name."""
        files.make_directories(self.file.parent)
        self._unlock()  # the lock file may be gone, too
        self._lock = tables.lock_file(self.file, 0.0)
        for end in ("-wal", "-shm"):
            Path(f"{self.file}{end}").unlink(missing_ok=True)

        def write_copy(folder: Path) -> None:
            copy = sqlite3.connect(folder / self.file.name)
            old.backup(copy)
            copy.close()

        files.write_whole(self.file.parent, write_copy)
        self._use(tables.connect(self.file))
        self._say(f"the state file {self.file} was deleted, and is made anew")

    def _remove_replaced(self) -> None:
        """Remove files that no part has any more; later, where one is being made."""
        if not self._replaced or not self._filing.acquire(blocking=False):
            return
        try:
            for name in self._unused_files():
                if self.meshes.remove(name):
                    self.put(Change("files", name, None))
        finally:
            self._filing.release()

    def _unused_files(self) -> set[str]:
        """Which of the replaced files are the state's own, and no part's any more."""
        with self._changing:
            names = self._replaced
            self._replaced = set()
            pending = {
                row[2]
                for (table, _), (row,) in self._pending.items()
                if table == "meshes" and row is not None
            }
        with self.in_use, suppress(sqlite3.Error):
            if self._link is not None:
                own = {name for (name,) in tables.rows_of(self._link, "files")}
                return (names & own) - pending - tables.files_of_meshes(self._link)
        return set()
