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

"""A file that is closed is written anew with an index: the same messages, whatever
comes in between.
"""

import os
import random
import shutil
import stat
import subprocess
import sys
from contextlib import suppress
from dataclasses import astuple
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from mcap.exceptions import EndOfFile, McapError
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader

from ros_pose_stats import analyse_bags
from ros_pose_stats.node.recorder import TYPES, message_type
from ros_pose_stats.node.recording import indexing, repair, run_log
from tests.contract.bags.messages import result, run_of_a_node, serialised
from tests.contract.bags.recorders import write_run
from tests.contract.bags.rosbag2 import assert_played_by_time
from tests.contract.node.harness.bags import (
    assert_readable_by_others,
    files_of,
    raw,
    size_of,
)
from tests.contract.node.harness.client import until
from tests.running import answer, is_gone

FILE = 65_536
RUN = [
    (f"/pose_stats/{topic}", serialised(message)) for topic, message in run_of_a_node()
]


class Recorder:
    """A log of a run in this process, and what was written to it."""

    def __init__(self, folder, *, is_large=False, **bounds):
        self.lines = []
        self.messages = []
        self.log = run_log.RunLog(
            folder,
            {topic: message_type(kind) for topic, kind in TYPES.items()},
            **{"max_bag_bytes": FILE, "max_log_bytes": 0, **bounds},
            node="/pose_stats",
            warn=self.lines.append,
        )
        if is_large:  # every file is, for the node itself and for its end
            self.log.indexer = indexing.Indexer(0)
            self.log.last_bytes = 0

    def record(self, messages=RUN):
        """Write messages."""
        for topic, data in messages:
            self.log.write(topic, data)
            # rclpy returns some bytes too many
            self.messages.append((topic, bytes(self.log._lengths[topic].trimmed(data))))
        return self

    def fill(self, files):
        """Write messages until so many files are closed."""
        while len(files_of(self.log.directory)) <= files:
            self.record()
        return self

    @property
    def files(self):
        """Of the bag, in their order."""
        return files_of(self.log.directory)


def is_indexed(file):
    with file.open("rb") as stream:
        try:
            summary = make_reader(stream).get_summary()
        except McapError:
            return False
    return summary is not None and len(summary.chunk_indexes) > 0


def facts(file):
    """All that each message is recorded with, also in a file that has no end yet."""
    messages = []
    with file.open("rb") as stream, suppress(EndOfFile):
        for record in StreamReader(stream).records:
            if isinstance(record, Message):
                messages.append(astuple(record))
    return messages


def halves(folder):
    return list(folder.rglob("*.half"))


def mend(folder):
    return list(repair.repair_bags(folder, indexing.write_indexed))


def is_whole(folder):
    """Whether nothing is left to mend."""
    return not mend(folder) and not halves(folder)


@pytest.mark.parametrize("messages", [RUN, RUN[:1]])
def test_a_bag_is_indexed_as_it_ends(tmp_path, messages):
    recorder = Recorder(tmp_path).record(messages)
    (file,) = recorder.files
    before = facts(file)
    recorder.log.close()
    assert_played_by_time(file)
    assert facts(file) == before
    assert raw(file.parent) == recorder.messages
    assert_readable_by_others(file.parent)
    assert not halves(tmp_path) and not recorder.lines


def test_files_that_are_followed_are_indexed_meanwhile_in_a_process(tmp_path):
    recorder = Recorder(tmp_path, is_large=True).fill(3)
    first, second, third, last = recorder.files
    until(lambda: all(map(is_indexed, (first, second, third))), "the index")
    process = recorder.log.indexer._worker._process._process
    assert os.getpriority(os.PRIO_PROCESS, process.pid) == indexing.LOWEST_PRIORITY
    recorder.record().log.close()
    assert until(lambda: is_gone(process.pid), "its end")
    for file in (first, second, third):
        assert_played_by_time(file)
    assert not is_indexed(last)  # the end has no time for it
    assert raw(last.parent) == recorder.messages
    assert_readable_by_others(last.parent)
    assert not halves(tmp_path) and not recorder.lines


def test_what_the_end_has_no_time_for_the_next_start_and_the_command_do(tmp_path):
    for name in ("start", "command"):
        recorder = Recorder(tmp_path / name, is_large=True).record()
        recorder.log.close()
        (file,) = recorder.files
        before = facts(file)
        assert not is_indexed(file)
        assert {file.state for file in analyse_bags(file).contents.files} == {"whole"}
        file.chmod(0o640)
        os.utime(file, ns=(10**18, 10**18))
        if name == "start":
            assert mend(tmp_path / name) == []  # nothing was lost
        else:
            assert "clamp" in answer("bag", tmp_path / name)
        assert_played_by_time(file)
        assert facts(file) == before
        status = file.stat()
        assert stat.S_IMODE(status.st_mode) == 0o640
        assert status.st_mtime_ns == 10**18


def test_bags_of_a_version_without_an_index_get_one_and_those_of_others_do_not(
    tmp_path,
):
    own = files_of(write_run(tmp_path / "log"))[0]
    other = files_of(write_run(tmp_path / "log", name="tuesday"))[0]
    before = other.read_bytes()
    assert mend(tmp_path / "log") == []
    answer("bag", tmp_path / "log")
    assert is_indexed(own)
    assert other.read_bytes() == before


def test_nothing_is_changed_where_somebody_has_the_bag_in_hand(tmp_path):
    recorder = Recorder(tmp_path, is_large=True).record()
    (file,) = recorder.files
    before = file.read_bytes()
    assert mend(tmp_path) == []
    answer("bag", tmp_path)
    assert file.read_bytes() == before
    recorder.log.close()


@pytest.mark.parametrize("begun", [b"", b"half of a file"])
def test_a_kill_in_the_middle_leaves_the_file_and_the_next_start_does_it(
    tmp_path, begun
):
    recorder = Recorder(tmp_path, is_large=True).record()
    recorder.log.close()
    (file,) = recorder.files
    file.with_name(f"{file.name}.half").write_bytes(begun)
    (tmp_path / "mine.half").write_bytes(b"mine")
    assert raw(file.parent) == recorder.messages
    mend(tmp_path)
    assert_played_by_time(file)
    assert raw(file.parent) == recorder.messages
    assert halves(tmp_path) == [tmp_path / "mine.half"]


def test_without_room_on_the_disk_the_file_stays_and_a_line_says_so(
    tmp_path, monkeypatch
):
    recorder = Recorder(tmp_path)
    recorder.record()
    (file,) = recorder.files
    room = SimpleNamespace(free=file.stat().st_size)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: room)
    recorder.log.close()
    (line,) = recorder.lines
    assert str(file) in line and "No space left" in line
    (mended,) = mend(tmp_path)
    assert "No space left" in mended.problem
    assert raw(file.parent) == recorder.messages and not is_indexed(file)
    assert not halves(tmp_path)


class Meanwhile:
    """Writes files anew; something happens before they can take their places."""

    def __init__(self, log, act):
        self._act = act
        log.indexer = self

    def write(self, path):
        rewrite = indexing.write_indexed(path)
        self._act(path)
        return rewrite

    def close(self):
        """Nothing to abandon."""


def test_a_process_that_outlives_its_node_is_in_nobody_s_way(tmp_path, monkeypatch):
    """It begins to write what the next start is about to put in place."""
    recorder = Recorder(tmp_path).record()
    (file,) = recorder.files
    recorder.log.close()
    before = facts(file)
    rewrite = indexing.write_indexed(file)
    outliving = indexing.write_indexed(file)
    with monkeypatch.context() as full_disk:
        full_disk.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=0))
        with pytest.raises(OSError, match="No space"):
            indexing.write_indexed(file)
    indexing.put_in_place(file, rewrite)
    assert facts(file) == before and is_indexed(file)
    assert halves(tmp_path) == [outliving.half]
    mend(tmp_path)
    assert not halves(tmp_path) and facts(file) == before


def test_a_file_that_is_deleted_meanwhile_does_not_come_back(tmp_path):
    recorder = Recorder(tmp_path)
    Meanwhile(recorder.log, Path.unlink)
    recorder.fill(2)
    until(lambda: len(recorder.files) == 1, "the deletion")
    recorder.log.close()
    assert len(recorder.files) == 1
    assert not halves(tmp_path)
    assert_readable_by_others(recorder.log.directory)


def test_the_bound_holds_with_both_the_file_and_what_is_to_take_its_place(tmp_path):
    bound = 10 * FILE
    sizes = []
    recorder = Recorder(tmp_path, max_log_bytes=bound)
    Meanwhile(recorder.log, lambda path: sizes.append(size_of(tmp_path)))
    while len(sizes) < 12:
        recorder.record()
    recorder.log.close()
    assert recorder.log.space.deletions > 0
    assert max(sizes) <= bound
    assert len(recorder.files) >= 4


def test_an_indexed_file_that_lost_its_end_keeps_its_messages(tmp_path):
    recorder = Recorder(tmp_path, max_bag_bytes=2**30)
    many = [
        ("/pose_stats/answers", serialised(result(float(number), seed=number)))
        for number in range(1000)
    ]
    recorder.record(many).log.close()
    (file,) = recorder.files
    content = file.read_bytes()
    file.write_bytes(content[:-700])
    (mended,) = mend(tmp_path)
    assert mended.messages == len(many)
    assert raw(file.parent) == recorder.messages
    assert_played_by_time(file)


def test_a_file_that_does_not_say_what_its_messages_are_stays_as_it_is(tmp_path):
    recorder = Recorder(tmp_path, is_large=True).record()
    recorder.log.close()
    (file,) = recorder.files
    content = file.read_bytes()
    position = content.index(b"/pose_stats/answers")
    content = content[:position] + b"?" + content[position + 1 :]
    file.write_bytes(content)
    (mended,) = mend(tmp_path)
    assert "damaged" in mended.problem
    assert file.read_bytes() == content
    assert not halves(tmp_path)


def test_what_goes_for_room_at_a_start_is_the_oldest_run(tmp_path):
    for _ in range(4):
        Recorder(tmp_path, is_large=True).record().log.close()
    runs = sorted(tmp_path.glob("pose_stats_*"))
    bound = size_of(tmp_path) + 10_000
    recorder = Recorder(tmp_path, is_large=True, max_log_bytes=bound)
    for _ in repair.repair_bags(
        tmp_path, recorder.log.indexer.write, recorder.log.room_for
    ):
        pytest.fail("something was lost")
    remaining = [run for run in runs if run.exists()]
    assert remaining == runs[len(runs) - len(remaining) :]
    assert 0 < len(remaining) < len(runs)
    for run in remaining:
        assert_played_by_time(*files_of(run))
    recorder.log.close()


ENDLESS = """
import itertools, pathlib, sys
from ros_pose_stats.node.recorder import TYPES, message_type
from ros_pose_stats.node.recording import indexing, run_log
types = {topic: message_type(kind) for topic, kind in TYPES.items()}
log = run_log.RunLog(
    pathlib.Path(sys.argv[1]), types, max_bag_bytes=2**19, max_log_bytes=0,
    node="", warn=print,
)
log.indexer = indexing.Indexer(0)
for number in itertools.count():
    log.write("/pose_stats/answers", b"\\0\\3\\0\\0" + number.to_bytes(8, "big") * 500)
    if number % 100 == 0:
        print(number, flush=True)
"""


@pytest.mark.long
def test_kills_at_any_moment_lose_no_message_and_change_none(tmp_path):
    chance = random.Random(7)
    for attempt in range(10):
        folder = tmp_path / str(attempt)
        with subprocess.Popen(
            [sys.executable, "-c", ENDLESS, folder], stdout=subprocess.PIPE, text=True
        ) as process:
            for _ in range(chance.randrange(1, 30)):
                acknowledged = int(process.stdout.readline())
            process.kill()
        (run,) = folder.iterdir()
        list(repair.repair_bags(folder, indexing.write_indexed))
        numbers = [int.from_bytes(data[4:12], "big") for _, data in raw(run)]
        assert numbers == list(range(len(numbers)))
        assert len(numbers) > acknowledged
        for file in files_of(run):
            assert_played_by_time(file)
        # The process of the killed node may have begun a file since.
        until(partial(is_whole, folder), "the end of its process")
