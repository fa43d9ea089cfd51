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

"""Bags that are made to take time, memory or the terminal: each costs what its size
warrants, and what is whole in it is read.
"""

import sqlite3
import struct
import zlib

import lz4.frame
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, Message, Schema

from ros_pose_stats import analyse_bags
from tests.running import call, refusal

from .messages import START, definition, result, serialised, type_name
from .recorders import write_mcap, write_run, write_sqlite

RUN = 14  # messages of a run of a node
PRIVATE = 0x90  # opcode of a record that readers pass over
HEAD = struct.Struct("<BQ")  # opcode and length of a record
CHECK = HEAD.pack(0xC5, 4) + bytes(4)  # the node's record in front of each, here wrong


def record(code, content):
    return bytes([code]) + len(content).to_bytes(8, "little") + content


def chunk(content, compression, pack, size=None):
    builder = RecordBuilder()
    size = len(content) if size is None else size
    Chunk(compression, pack(content), START, START, zlib.crc32(content), size).write(
        builder
    )
    return builder.end()


def read_around(folder, *stretches):
    """What is read of a run, of these bytes behind it, and of the run again."""
    run = write_mcap(folder / "run.mcap", closed=False).read_bytes()
    (folder / "run.mcap").write_bytes(b"".join([run, *stretches, run[8:]]))
    return analyse_bags(folder).contents


ZEROS = bytes(1 << 20)
MANY = record(PRIVATE, b"") * 300_000


@pytest.mark.parametrize(
    ("stretch", "words"),
    [
        (chunk(ZEROS, "zstd", zstandard.compress), "no whole record"),
        (chunk(ZEROS, "lz4", lz4.frame.compress), "no whole record"),
        (chunk(ZEROS, "", bytes), "no whole record"),
        (chunk(ZEROS, "zstd", zstandard.compress, 2**40), "unpacks to 1099511627776"),
        (chunk(ZEROS, "lz4", lz4.frame.compress, 100), "its size is another"),
        (chunk(ZEROS, "zstd", zstandard.compress, 100), "its size is another"),
        (chunk(record(PRIVATE, b"")[:5], "", bytes), "no whole record"),
        (chunk(MANY, "zstd", zstandard.compress), "more records than"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_chunk_that_is_more_than_it_may_be_costs_itself(tmp_path, stretch, words):
    contents = read_around(tmp_path, stretch)
    (file,) = contents.files
    assert file.state == "damaged" and words in file.note
    assert file.messages == 2 * RUN


def test_the_records_before_the_damage_in_a_chunk_are_read(tmp_path):
    run = write_mcap(tmp_path / "run.mcap", closed=False).read_bytes()[8:]
    (tmp_path / "run.mcap").unlink()
    contents = read_around(tmp_path, chunk(run + ZEROS, "zstd", zstandard.compress))
    assert contents.files[0].messages == 3 * RUN


def test_a_file_that_unpacks_to_far_more_than_its_size_is_cut(tmp_path):
    run = write_mcap(tmp_path / "run.mcap", closed=False).read_bytes()
    (tmp_path / "run.mcap").unlink()
    (tmp_path / "run.mcap.zstd").write_bytes(zstandard.compress(run + MANY + run[8:]))
    (file,) = analyse_bags(tmp_path).contents.files
    assert (file.state, file.messages) == ("cut", RUN)


def test_damage_that_looks_like_records_is_not_tried_for_ever(tmp_path):
    """Each of these claims all that follows, so all of them would be hundreds of
    times what is tried. What is whole behind them is given up with them.
    """
    claims = 80_000
    length = HEAD.size + len(CHECK)
    stretch = b"".join(
        CHECK + HEAD.pack(PRIVATE, (claims - k - 1) * length) for k in range(claims)
    )
    contents = read_around(tmp_path, stretch)
    assert (contents.files[0].state, contents.files[0].messages) == ("cut", RUN)


class TestDefinitions:
    def read(self, folder, text):
        message = result(20.0)
        builder = RecordBuilder()
        Schema(9, text.encode(), "ros2msg", type_name(message)).write(builder)
        Channel(9, "/late/pose_statistics", "cdr", {}, 9).write(builder)
        Message(9, START, serialised(message), START, 1).write(builder)
        return read_around(folder, builder.end())

    def test_comments_are_no_part_of_it(self, tmp_path):
        """The parser takes a minute for this one."""
        text = f"{definition(type_name(result(1.0)))}\n# {'[' * 50_000}\n"
        assert self.read(tmp_path, text).notes == read_around(tmp_path).notes

    @pytest.mark.parametrize(
        "addition",
        [
            "# " + "x" * 65536,
            "".join(f"uint8 N{k}=1\n" for k in range(1000)),
        ],
    )
    def test_one_that_is_too_long_is_not_parsed(self, tmp_path, addition):
        text = definition(type_name(result(1.0)))
        contents = self.read(tmp_path, f"{addition}\n{text}")
        assert contents.files[0].messages == 2 * RUN + 1
        assert "1 message left out, broken or of another definition" in contents.notes

    @pytest.mark.parametrize("line", ["\x1b]0;title\x07", "\x1b[31mred\x1b[0m field"])
    def test_no_line_of_it_reaches_the_terminal(self, tmp_path, line):
        self.read(tmp_path, line)
        outcome = call("bag", tmp_path)
        assert outcome.returncode == 0
        assert "\x1b" not in outcome.stdout + outcome.stderr
        assert "Error" not in outcome.stderr


ENDLESS = (
    "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n LIMIT 3) "
    "SELECT original.* FROM original, n"
)


@pytest.fixture(scope="module")
def sqlite_bag(tmp_path_factory):
    (file,) = write_sqlite(tmp_path_factory.mktemp("sqlite") / "bag").glob("*.db3")
    return file.read_bytes()


@pytest.fixture
def change(sqlite_bag, tmp_path):
    """Writes a bag in SQLite and changes it by commands."""

    def change_bag(*commands):
        file = tmp_path / "bag.db3"
        file.write_bytes(sqlite_bag)
        base = sqlite3.connect(file)
        for command in commands:
            base.execute(command)
        base.commit()
        base.close()
        return file

    return change_bag


class TestSqlite:
    @pytest.mark.parametrize("table", ["topics", "messages", "message_definitions"])
    def test_a_view_is_no_table(self, change, tmp_path, table):
        file = change(
            f"ALTER TABLE {table} RENAME TO original",
            f"CREATE VIEW {table} AS {ENDLESS}",
        )
        assert f"no plain table {table};" in refusal("bag", file)
        write_run(tmp_path)
        assert file.name in call("bag", tmp_path).stdout

    def test_a_view_that_says_it_is_a_table(self, change):
        file = change(
            "ALTER TABLE messages RENAME TO original",
            f"CREATE VIEW messages AS {ENDLESS}",
            "PRAGMA writable_schema=ON",
            "UPDATE sqlite_master SET type = 'table', rootpage = 2 "
            "WHERE name = 'messages'",
        )
        refusal("bag", file)

    def test_a_column_that_is_computed_is_none(self, change):
        file = change(
            "ALTER TABLE messages DROP COLUMN data",
            "ALTER TABLE messages ADD COLUMN data AS (zeroblob(1000))",
        )
        assert "no plain table messages;" in refusal("bag", file)

    @pytest.mark.parametrize(
        ("table", "column", "value"),
        [
            ("messages", "data", "1e9"),
            ("messages", "data", "'a'"),
            ("messages", "timestamp", "x'00'"),
            ("messages", "timestamp", "'a'"),
            ("topics", "name", "x'00'"),
            ("topics", "type", "x'00'"),
            ("message_definitions", "encoded_message_definition", "1e9"),
        ],
    )
    def test_values_of_another_kind_are_passed_over(
        self, change, tmp_path, table, column, value
    ):
        file = change(f"UPDATE {table} SET {column} = {value}")
        write_run(tmp_path)
        outcome = call("bag", tmp_path)
        assert (outcome.returncode, outcome.stderr) == (0, "")
        assert str(file.name) in call("bag", tmp_path, "--json").stdout
