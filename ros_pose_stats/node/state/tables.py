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

"""The SQLite file of a node's state: who has it, what is in it, whether it is sound."""

import errno
import fcntl
import itertools
import json
import os
import re
import sqlite3
import time
import zlib
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from ...base.errors import PoseStatsError, RequestError, reason

VERSION = 4
APPLICATION = 0x52505353  # what the file's header says of its kind
COLUMNS = {  # the first one is the key; each row has a checksum behind the others
    "parts": "part_id TEXT PRIMARY KEY, digest TEXT, content BLOB, restitution REAL, "
    "drop_height REAL, size INTEGER, used INTEGER",
    # a large message lies in the file
    "meshes": "part_id TEXT PRIMARY KEY, message BLOB, file TEXT",
    "results": "part_id TEXT PRIMARY KEY, latched BLOB, model BLOB, revision INTEGER",
    "counts": "part_id TEXT PRIMARY KEY, digest TEXT, cluster_tolerance REAL, "
    "round_sides INTEGER, plate TEXT, total BLOB, series INTEGER",
    # counts by speed, of that series of `counts`
    "flips": "part_id TEXT PRIMARY KEY, series INTEGER, speeds TEXT",
    # of a message of counts: 8 bytes of the series, 16 of a digest
    "counted": "identity BLOB PRIMARY KEY",
    "jobs": "job_id TEXT PRIMARY KEY, state INTEGER, event BLOB, answer BLOB",
    "facts": "name TEXT PRIMARY KEY, value TEXT",
    # of meshes that this state has written, or is about to, and has not removed
    "files": "name TEXT PRIMARY KEY",
}
ALWAYS = {"parts", "meshes", "facts"}  # tables of every version
OF_PARTS = ("parts", "meshes", "results", "counts", "flips")  # whose key is a part_id
MESSAGES = {
    "meshes": {1: "PartMesh"},
    "results": {1: "PoseStatistics", 2: "PoseStatistics"},
    "jobs": {2: "JobEvent", 3: "PoseStatistics"},
}  # serialised in columns
FILE = 2  # column of `meshes`
MOST_COUNTED = 1_000_000  # messages of counts whose identity is kept, the newest ones
LOCK_SECONDS = 5.0  # to wait for the lock of another process
POLL_SECONDS = 0.05
# for which another program that looks into the file may hold a commit up
BUSY_SECONDS = 2.0
_PROCESS = re.compile(rb"[0-9\0]{0,20}\n?")  # a lock file; zeros are of a power cut
_TROUBLE = ("unable to open", "readonly", "disk i/o", "is full", "is locked")
"""What SQLite says of a disk that cannot be used; all else is of the file itself."""

Row = tuple[Any, ...]
Convert = Callable[[str, str, bytes], bytes | None]
"""From a type's name, its definition of that time and a message to today's message."""


class Change(NamedTuple):
    """A row that is to take the place of the one with its key; None: that one goes."""

    table: str
    key: str | bytes
    row: Row | None


class DamagedError(Exception):
    """The file is none of a state, or not as it was written."""


class StateInUseError(PoseStatsError):
    """Another process has the file."""


def lock_file(file: Path, seconds: float) -> int:
    """Take the kernel's lock of a state file, beside it; it ends with the descriptor.

    The lock file stays, so that nobody locks one that is gone.
    """
    path = file.with_name(f"{file.name}.lock")
    deadline = time.monotonic() + seconds
    while True:
        number = _open_lock(path, file)
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = os.pread(number, 20, 0).decode(errors="replace").strip()
        else:
            break
        os.close(number)
        if time.monotonic() > deadline:
            raise StateInUseError(
                f"a state file that no other node uses (parameter state_file, {file})",
                f"one that process {holder} has in use",
                "end that process, or name another file",
            )
        time.sleep(POLL_SECONDS)
    with suppress(OSError):  # of a disk that can only be read
        # What somebody else has written there stays; it can be locked all the same.
        if _PROCESS.fullmatch(os.pread(number, 22, 0)):
            os.ftruncate(number, 0)
            os.pwrite(number, f"{os.getpid()}\n".encode(), 0)
    return number


def _open_lock(path: Path, file: Path) -> int:
    """Open a lock file; on a read-only disk it may have to be the file itself."""
    flags = os.O_NONBLOCK | os.O_NOFOLLOW
    try:
        return os.open(path, flags | os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise RequestError(
                f"a lock file beside state_file ({path})",
                "a symbolic link",
                "remove it, or name another state file",
            ) from error
        if error.errno != errno.EROFS:
            raise
        return os.open(path if path.exists() else file, flags | os.O_RDONLY)


def refuse_hard_links(file: Path) -> None:
    """Refuse a file of several names: each name would have a lock of its own."""
    with suppress(FileNotFoundError):
        names = file.stat().st_nlink
        if names > 1:
            raise RequestError(
                f"a state file with one name (parameter state_file, {file})",
                f"a file with {names} names (hard links)",
                "remove the others; copies and symbolic links do no harm",
            )


def is_trouble(error: sqlite3.Error) -> bool:
    """Whether an error is of the disk, and may pass."""
    return any(word in str(error).lower() for word in _TROUBLE)


def is_damage(error: Exception) -> bool:
    """Whether an error is of the file itself; damaged names come as UnicodeError."""
    return isinstance(error, (DamagedError, UnicodeError)) or (
        isinstance(error, sqlite3.Error) and not is_trouble(error)
    )


def sealed(row: Row) -> Row:
    """A row with its checksum."""
    return (*row, _checksum(row))


def _checksum(row: Row) -> int:
    checksum = 0
    for value in row:
        if isinstance(value, float):
            value += 0.0  # SQLite gives 0.0 back for -0.0
        data = value if isinstance(value, bytes) else repr(value).encode()
        checksum = zlib.crc32(data, zlib.crc32(b"%d:" % len(data), checksum))
    return checksum


def connect(file: Path) -> sqlite3.Connection:
    """Open a file, or make one; a read-only disk will do if it was closed well."""
    try:
        return _connected(str(file), file)
    except sqlite3.OperationalError as error:
        if not is_trouble(error) or Path(f"{file}-wal").exists() or not file.exists():
            raise
        return _connected(f"{file.absolute().as_uri()}?mode=ro&immutable=1", file)


def _connected(name: str, file: Path) -> sqlite3.Connection:
    read_only = name.startswith("file:")
    link = sqlite3.connect(
        name,
        timeout=BUSY_SECONDS,
        isolation_level=None,
        check_same_thread=False,
        uri=read_only,
    )
    # A damaged text reaches the checksum of its row instead of failing on the way.
    link.text_factory = partial(str, encoding="utf-8", errors="surrogateescape")
    try:
        _check_version(link, file)
        link.execute("PRAGMA synchronous=FULL")
        if not read_only:
            link.execute("PRAGMA journal_mode=WAL")
            link.execute("SELECT count(*) FROM facts").fetchone()
    except BaseException:
        link.close()
        raise
    return link


def _check_version(link: sqlite3.Connection, file: Path) -> None:
    (version,), (kind,) = (
        link.execute(f"PRAGMA {name}").fetchone()
        for name in ("user_version", "application_id")
    )
    tables = {
        name
        for (name,) in link.execute("SELECT name FROM sqlite_master WHERE type='table'")
    }
    if kind != APPLICATION and tables and not tables >= ALWAYS:
        raise RequestError(
            f"state_file to be a node's own ({file})",
            "an SQLite file of another program",
            "name another one",
        )
    if version > VERSION:
        raise RequestError(
            f"a state file of version {VERSION} or older ({file})",
            f"version {version}, of a newer ros_pose_stats",
            "start that version, or name another file (parameter state_file)",
        )
    if version < VERSION:
        if tables and not version:
            raise DamagedError("tables but no version")
        columns = "".join(
            f"CREATE TABLE {table} ({text}, checksum INTEGER);"
            for table, text in COLUMNS.items()
            if table not in tables
        )
        link.executescript(
            f"BEGIN IMMEDIATE; {columns} PRAGMA application_id={APPLICATION}; "
            f"PRAGMA user_version={VERSION}; COMMIT;"
        )


def check_sound(link: sqlite3.Connection) -> None:
    """Look at a file's structure and every row; raises DamagedError, sqlite3.Error."""
    (answer,) = link.execute("PRAGMA quick_check(1)").fetchone()
    if answer != "ok":
        raise DamagedError(answer)
    for table, text in COLUMNS.items():
        columns = [
            (name, kind, bool(key))
            for _, name, kind, _, _, key in link.execute(f"PRAGMA table_info({table})")
        ]
        if columns != _columns(text):
            raise DamagedError(f"columns of {table} are not as they were made")
    for table in COLUMNS.keys() - {"counted"}:  # of which there may be a million
        (answer,) = link.execute(f"PRAGMA integrity_check({table})").fetchone()
        if answer != "ok":  # an index, by which another row would be found, or none
            raise DamagedError(answer)
        for row in link.execute(f"SELECT * FROM {table}"):
            if _checksum(row[:-1]) != row[-1]:
                raise DamagedError(f"a row of {table} is not as it was written")


def _columns(text: str) -> list[tuple[str, str, bool]]:
    """Name, type and whether it is the key of each column of a table."""
    columns = []
    for column in (*text.split(", "), "checksum INTEGER"):
        name, kind, *key = column.split(" ")
        columns.append((name, kind, bool(key)))
    return columns


def rows_of(link: sqlite3.Connection, table: str) -> list[Row]:
    """All rows of a table in the order of their making, without their checksums."""
    return [row[:-1] for row in link.execute(f"SELECT * FROM {table} ORDER BY rowid")]


def write(link: sqlite3.Connection, changes: Iterable[Change]) -> None:
    """Make all changes in one transaction, on the disk when this returns, or none."""
    with link:
        link.execute("BEGIN IMMEDIATE")
        for table, key, row in changes:
            if row is None:
                link.execute(f"DELETE FROM {table} WHERE {_key(table)}=?", (key,))
            else:
                places = ",".join("?" * (len(row) + 1))
                link.execute(
                    f"INSERT OR REPLACE INTO {table} VALUES ({places})", sealed(row)
                )
        link.execute(
            "DELETE FROM counted WHERE rowid <= (SELECT max(rowid) FROM counted) - ?",
            (MOST_COUNTED,),
        )


def _key(table: str) -> str:
    return COLUMNS[table].partition(" ")[0]


def look_up(link: sqlite3.Connection, table: str, key: str | bytes) -> Row | None:
    """A row by its key; None where it is not there, or damaged."""
    row = link.execute(
        f"SELECT * FROM {table} WHERE {_key(table)}=?", (key,)
    ).fetchone()
    # A damaged index, as of messages that were counted, leads to another row.
    is_sound = row is not None and row[0] == key and row[-1] == _checksum(row[:-1])
    return row[:-1] if is_sound else None


def files_of_meshes(link: sqlite3.Connection) -> set[str]:
    """Names of the files in which large meshes of parts lie."""
    return {
        name for (name,) in link.execute("SELECT file FROM meshes WHERE file != ''")
    }


def update_messages(
    link: sqlite3.Connection,
    today: Mapping[str, str],
    convert: Convert,
    convert_file: Callable[[str, Callable[[bytes], bytes | None]], str | None],
) -> None:
    """Write messages anew whose definitions changed; what is unreadable now goes.

    `convert_file` does so with a file of a mesh, and gives the name of the new one.
    """
    fact = look_up(link, "facts", "definitions")
    written = {} if fact is None else json.loads(fact[1])
    if written == today:
        return
    changes = [Change("facts", "definitions", ("definitions", json.dumps(dict(today))))]
    for table, kinds in MESSAGES.items():
        for row in rows_of(link, table):
            values = list(row)
            for column, kind in kinds.items():
                if written.get(kind, today[kind]) == today[kind]:
                    continue
                if row[column]:
                    values[column] = convert(kind, written[kind], row[column])
                elif table == "meshes":
                    update = partial(convert, kind, written[kind])
                    values[FILE] = convert_file(row[FILE], update)
            if tuple(values) != row:
                is_readable = None not in values
                changes.append(
                    Change(table, row[0], tuple(values) if is_readable else None)
                )
    write(link, changes)


def set_aside(file: Path) -> str:
    """Give a file that cannot be read, and its log, another name; that name."""
    stamp = f"{file.name}.unreadable-{time.strftime('%Y%m%dT%H%M%S', time.gmtime())}"
    names = itertools.chain(
        [stamp], (f"{stamp}-{number}" for number in itertools.count(2))
    )
    name = next(name for name in names if not file.with_name(name).exists())
    for path, end in ((Path(f"{file}-wal"), "-wal"), (file, "")):
        with suppress(FileNotFoundError):
            path.rename(file.with_name(name + end))
    Path(f"{file}-shm").unlink(missing_ok=True)
    return name


def problem_of(file: Path, error: BaseException) -> str:
    """One clause that says why a state file cannot be used."""
    return f"cannot write the state file {file}: {reason(error)}"
