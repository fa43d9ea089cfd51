"""Small bags to write, damage and read back, without ROS."""

from __future__ import annotations

import hashlib
import struct
from pathlib import Path

from ros_pose_stats.recording.reader.raw_reader import raw_messages
from ros_pose_stats.recording.writer.message_types import MessageType
from ros_pose_stats.recording.writer.run_log import RunLog

RUN = "pose_stats_20260102T030405_000006_7"
LATER_RUN = "pose_stats_20260102T030405_000007_7"
ANSWERS = "/pose_stats/answers"
EVENTS = "/pose_stats/job_events"
TYPES = {
    ANSWERS: MessageType("std_msgs/msg/String", "string data\n", "RIHS01_" + "1" * 64),
    EVENTS: MessageType("example_msgs/msg/Event", "string data\n", "RIHS01_" + "2" * 64),
}


def string(text: str) -> bytes:
    """A std_msgs/String as CDR."""
    data = text.encode() + b"\0"
    return b"\0\1\0\0" + struct.pack("<I", len(data)) + data


def numbered(number: int, size: int = 20) -> bytes:
    """A message that tells its number, followed by so many letters that depend on it."""
    letters = hashlib.sha256(str(number).encode()).hexdigest()
    return string(f"{number}:" + (letters * (size // 64 + 1))[:size])


def new_log(folder: Path, **settings) -> RunLog:
    return RunLog(folder, TYPES, **{"max_bag_bytes": 1 << 29, **settings})


def let_die(log: RunLog) -> None:
    """Leave a log as a kill would: nothing more is written, and the lock is gone."""
    log._bag.abandon()


def unfinished_bag(folder: Path, messages: list[bytes], name: str = RUN) -> tuple[Path, list[int]]:
    """A bag with one file that lacks its end; its path, and the size after each message."""
    log = new_log(folder, name=name)
    sizes = []
    for message in messages:
        log.write(ANSWERS, message, durable=False)
        sizes.append(log.bytes_written)
    log.sync()
    let_die(log)
    return log.directory, sizes


def finished_bag(folder: Path, messages: list[bytes], name: str = RUN) -> Path:
    log = new_log(folder, name=name)
    for message in messages:
        log.write(ANSWERS, message, durable=False)
    log.close()
    return log.directory


def only_file(directory: Path) -> Path:
    [file] = directory.glob("*.mcap")
    return file


def data_of(bag: Path) -> list[bytes]:
    """What the messages of a bag say, in order."""
    return [message.data for message in raw_messages(bag)]


def undamaged(bag: Path) -> list[bytes]:
    """The same; there must be nothing wrong with the bag."""
    damage = []
    data = [message.data for message in raw_messages(bag, damage.append)]
    assert damage == []
    return data
