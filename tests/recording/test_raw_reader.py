"""Reading bags that others recorded, and bags that are not what they should be."""

from __future__ import annotations

import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from ros_pose_stats.recording.reader.raw_reader import finished_runs, raw_messages
from tests.recording.bags import (
    ANSWERS,
    LATER_RUN,
    RUN,
    data_of,
    finished_bag,
    new_log,
    numbered,
    only_file,
    undamaged,
    unfinished_bag,
)

MESSAGES = [numbered(number, 50 * number) for number in range(40)]


def record(path, messages=MESSAGES, **settings):
    """A file as `ros2 bag record` leaves it."""
    with path.open("wb") as file:
        writer = Writer(file, **settings)
        writer.start("ros2", "somebody else")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
        channel = writer.register_channel("/words", "cdr", schema)
        for number, data in enumerate(messages):
            writer.add_message(channel, 1000 + number, data, 1000 + number)
        writer.finish()
    return path


@pytest.mark.parametrize("settings", [
    {"use_chunking": False}, {"compression": CompressionType.NONE, "chunk_size": 2000},
    {"compression": CompressionType.LZ4, "chunk_size": 2000},
    {"compression": CompressionType.ZSTD, "chunk_size": 2000},
    {"compression": CompressionType.ZSTD, "chunk_size": 1 << 20},
], ids=str)
def test_chunks_and_compression(tmp_path, settings):
    file = record(tmp_path / "a.mcap", **settings)
    damage = []
    messages = list(raw_messages(file, damage.append))
    assert [one.data for one in messages] == MESSAGES
    assert damage == []
    assert (messages[3].topic, messages[3].type_name, messages[3].log_time,
            messages[3].definition) == ("/words", "std_msgs/msg/String", 1003, "string data")


def test_files_in_the_order_of_their_numbers(tmp_path):
    for number in (10, 9, 0, 2):
        record(tmp_path / f"talk_{number}.mcap", [numbered(number)])
    (tmp_path / "metadata.yaml").touch()
    (tmp_path / "talk_3.mcap.half").write_bytes(b"nothing yet")
    assert undamaged(tmp_path) == [numbered(number) for number in (0, 2, 9, 10)]


def test_files_that_were_compressed_as_a_whole(tmp_path):
    plain = record(tmp_path / "a_0.mcap")
    packed = tmp_path / "a_0.mcap.zstd"
    packed.write_bytes(zstandard.compress(plain.read_bytes()))
    plain.unlink()
    assert undamaged(tmp_path) == undamaged(packed) == MESSAGES
    packed.write_bytes(packed.read_bytes()[:-20])
    assert data_of(packed) == MESSAGES[:len(data_of(packed))]


def test_a_damaged_chunk_is_told(tmp_path):
    file = record(tmp_path / "a.mcap", compression=CompressionType.NONE, chunk_size=2000)
    content = bytearray(file.read_bytes())
    content[len(content) // 3] ^= 1
    file.write_bytes(content)
    damage = []
    found = [one.data for one in raw_messages(file, damage.append)]
    assert 0 < len(found) < len(MESSAGES)
    assert all(one in MESSAGES for one in found)
    [one] = damage
    assert one.path == file and one.end > one.start and "chunk" in one.reason


@pytest.mark.parametrize("cut", [1, 7, 50, 100])
def test_a_cut_tail_is_told(tmp_path, cut):
    directory, sizes = unfinished_bag(tmp_path, MESSAGES[:3])
    content = only_file(directory).read_bytes()
    only_file(directory).write_bytes(content[:-cut])
    damage = []
    assert [one.data for one in raw_messages(directory, damage.append)] == MESSAGES[:2]
    assert [(one.start, one.end, one.reason) for one in damage] == [
        (sizes[1], sizes[2] - cut, "no whole record"),
        (sizes[2] - cut, sizes[2] - cut, "no footer")]


def test_a_missing_footer_is_told(tmp_path):
    directory, sizes = unfinished_bag(tmp_path, MESSAGES)
    damage = []
    assert [one.data for one in raw_messages(directory, damage.append)] == MESSAGES
    assert [(one.start, one.end, one.reason) for one in damage] == [
        (sizes[-1], sizes[-1], "no footer")]


@pytest.mark.parametrize("content", [b"", b"no bag at all" * 100, b"\x89MCAP0\r\n"])
def test_files_without_anything(tmp_path, content):
    file = tmp_path / "a.mcap"
    file.write_bytes(content)
    damage = []
    assert list(raw_messages(file, damage.append)) == []
    assert damage[-1].reason == "no footer"


def test_a_message_without_a_channel_is_told(tmp_path):
    file = record(tmp_path / "a.mcap", MESSAGES[:2], use_chunking=False)
    content = file.read_bytes()
    start = content.index(b"\x04", content.index(b"string data"))
    file.write_bytes(content[:start] + b"\x84" + content[start + 1:])
    damage = []
    assert list(raw_messages(file, damage.append)) == []
    assert [one.reason for one in damage] == ["no channel 1", "no channel 1"]


@pytest.mark.parametrize("name", ["missing", "missing.mcap"])
def test_a_missing_bag(tmp_path, name):
    with pytest.raises(FileNotFoundError):
        list(raw_messages(tmp_path / name))


def test_runs_that_nobody_holds(tmp_path):
    assert finished_runs(tmp_path / "missing") == finished_runs(tmp_path) == []
    first = finished_bag(tmp_path, MESSAGES[:1], RUN)
    second, _ = unfinished_bag(tmp_path, MESSAGES[:2], LATER_RUN)
    living = new_log(tmp_path)
    living.write(ANSWERS, MESSAGES[0], durable=True)
    finished_bag(tmp_path, MESSAGES[:1], "zzz")
    assert finished_runs(tmp_path) == [first, second]
    living.close()
    assert finished_runs(tmp_path) == [first, second, living.directory]
