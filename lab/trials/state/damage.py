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

"""State files that are cut, or of which a byte has changed."""

import random
import shutil

from ros_pose_stats.base.errors import PoseStatsError
from ros_pose_stats.node.state import Change, State
from ros_pose_stats.node.state.tables import COLUMNS

from ..frame import Outcome, Setting
from .original import NAME, killed_state

CUTS = 20
FLIPS = 200
READ_FLIPS = 4000


def _tried(setting, tries, damage):
    """Nodes on files that were damaged, each in a way of its own."""
    original = killed_state()
    chance = random.Random(setting.seed)
    broken = []
    empty = 0
    for number in range(tries):
        file = original.copy(setting.folder / "copy")
        damage_done = damage(file, chance)
        try:
            wrong, original_known = original.start(setting.folder, file)
        except AssertionError as error:
            wrong = [str(error)]
            original_known = 0
        broken += [
            f"{damage_done} (try {number} of seed {setting.seed}): {line}"
            for line in wrong
        ]
        empty += not original_known
    return Outcome(
        tries,
        broken,
        f"{empty} starts without anything, {tries - empty} with what was sound",
    )


def _any_file(file, chance):
    """One of the files of a state, the larger the likelier."""
    paths = [
        path
        for path in (
            file,
            file.with_name(f"{NAME}-wal"),
            *sorted(file.with_name(f"{file.name}.meshes").glob("*")),
        )
        if path.exists()
    ]
    return chance.choices(paths, [path.stat().st_size for path in paths])[0]


def _cut(file, chance):
    path = chance.choice((file, _any_file(file, chance)))
    data = path.read_bytes()
    length = chance.choice((0, 1, 100, chance.randrange(len(data)), len(data) - 1))
    path.write_bytes(data[:length])
    return f"{path.name} cut to {length} of {len(data)} bytes"


def _flip(file, chance):
    path = _any_file(file, chance)
    data = bytearray(path.read_bytes())
    position = chance.randrange(len(data))
    bits = chance.randrange(1, 256)
    data[position] ^= bits
    path.write_bytes(data)
    return f"byte {position} of {path.name} ^ {bits}"


def cut_files(setting: Setting) -> Outcome:
    """State files cut anywhere: the node starts with what is sound, or with nothing."""
    return _tried(setting, setting.of(CUTS, 2), _cut)


def flipped_bytes(setting: Setting) -> Outcome:
    """A byte of the file, its log or its meshes changed: sound numbers, or none."""
    return _tried(setting, setting.of(FLIPS, 5), _flip)


def flipped_bytes_read(setting: Setting) -> Outcome:
    """The same, the state alone read: each row by its key as it was written, or
    none.
    """
    file = setting.folder / "original" / NAME
    truth = _rows()
    state = State(file)
    state.put(
        *(Change(table, row[0], row) for table, rows in truth.items() for row in rows)
    )
    state.close()
    chance = random.Random(setting.seed)
    broken = []
    set_aside = 0
    tries = setting.of(READ_FLIPS, 100)
    for number in range(tries):
        copy = setting.folder / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(file.parent, copy)
        damage_done = _flip(copy / NAME, chance)
        try:
            state = State(copy / NAME)
        except PoseStatsError as refusal:
            if "newer" not in str(refusal) and "another program" not in str(refusal):
                broken.append(f"{damage_done}: {refusal}")
            continue
        set_aside += bool(state.set_aside)
        broken += [
            f"{damage_done} (try {number} of seed {setting.seed}): {line}"
            for line in _strange_rows(state, truth)
        ]
        state.close()
    return Outcome(tries, broken, f"{set_aside} set aside")


def _rows():
    """Rows of every table but that of meshes, whose files have no rows to be
    compared.
    """
    values = {
        "TEXT": "text {}".format,
        "INTEGER": int,
        "REAL": float,
        "BLOB": lambda number: b"%d " % number * 9,
    }
    return {
        table: [
            tuple(values[column.split()[1]](number) for column in text.split(","))
            for number in range(40)
        ]
        for table, text in COLUMNS.items()
        if table != "meshes"
    }


def _strange_rows(state, truth):
    """What a state gives that nobody put there, or does not give though the file was
    sound.

    Of messages that were counted one may be missing, so that it counts again if it
    comes again: there may be a million of them, too many to look at in a start.
    """
    for table, rows in truth.items():
        try:
            strange = (
                []
                if table == "counted"
                else [row for row in state.rows(table) if row not in rows]
            )
            values = [state.get(table, row[0]) for row in rows]
        except Exception as error:
            yield f"{table} cannot be read: {type(error).__name__}: {error}"
            continue
        others = sum(
            value not in (row, None) for value, row in zip(values, rows, strict=True)
        )
        missing = 0 if state.set_aside or table == "counted" else values.count(None)
        if strange or others or missing:
            yield (
                f"{table} has {len(strange)} strange rows, {others} of other keys, "
                f"{missing} "
                "not there by their keys"
            )
