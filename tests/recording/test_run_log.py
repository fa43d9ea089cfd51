"""The bag of a run, as long as nothing goes wrong."""

from __future__ import annotations

import os
import re
import threading
import time

import pytest

from ros_pose_stats.recording.directory_lock import is_locked
from ros_pose_stats.recording.finished import is_finished
from ros_pose_stats.recording.reader.raw_reader import raw_messages
from ros_pose_stats.recording.run_names import bag_files
from ros_pose_stats.recording.writer import bag_file, run_log
from ros_pose_stats.recording.writer.run_log import RecordingError
from tests.recording.bags import (
    ANSWERS,
    EVENTS,
    TYPES,
    data_of,
    new_log,
    numbered,
    only_file,
    undamaged,
)


class TestLife:
    def test_an_idle_log_makes_nothing(self, tmp_path):
        log = new_log(tmp_path / "log")
        assert log.bytes_written == 0
        log.sync()
        log.close()
        assert list(tmp_path.iterdir()) == []

    def test_the_directory_is_named_by_time_and_process(self, tmp_path):
        log = new_log(tmp_path / "deep" / "log")
        log.write(ANSWERS, numbered(0), durable=True)
        assert log.directory.parent == tmp_path / "deep" / "log"
        assert re.fullmatch(rf"pose_stats_\d{{8}}T\d{{6}}_\d{{6}}_{os.getpid()}",
                            log.directory.name)
        assert [one.name for one in log.directory.parent.iterdir()] == [log.directory.name]
        assert sorted(one.name for one in log.directory.iterdir()) == [
            ".lock", "metadata.yaml", f"{log.directory.name}_0.mcap"]

    def test_messages_come_back_in_order(self, tmp_path):
        log = new_log(tmp_path)
        log.write(ANSWERS, numbered(1), durable=False)
        log.write(EVENTS, numbered(5), durable=True)
        log.write(ANSWERS, numbered(2), durable=False)
        log.close()
        messages = list(raw_messages(log.directory))
        assert [(one.topic, one.type_name, one.data) for one in messages] == [
            (ANSWERS, "std_msgs/msg/String", numbered(1)),
            (EVENTS, "example_msgs/msg/Event", numbered(5)),
            (ANSWERS, "std_msgs/msg/String", numbered(2))]
        assert messages[0].definition == TYPES[ANSWERS].definition

    def test_what_is_written_is_there_before_the_end(self, tmp_path):
        log = new_log(tmp_path)
        for number in range(3):
            log.write(ANSWERS, numbered(number), durable=True)
            assert len(data_of(log.directory)) == number + 1
            assert log.bytes_written == only_file(log.directory).stat().st_size

    def test_the_bag_is_held_until_it_is_closed(self, tmp_path):
        log = new_log(tmp_path)
        log.write(ANSWERS, numbered(0), durable=True)
        assert is_locked(log.directory)
        assert not is_finished(log.directory)
        log.close()
        assert not is_locked(log.directory)
        assert is_finished(log.directory)

    def test_nothing_is_written_after_the_end(self, tmp_path):
        log = new_log(tmp_path)
        log.write(ANSWERS, numbered(0), durable=True)
        log.close()
        log.close()
        with pytest.raises(RecordingError, match=r"^cannot record to .*: the log is closed$"):
            log.write(ANSWERS, numbered(1), durable=True)
        assert undamaged(log.directory) == [numbered(0)]

    def test_an_unknown_topic_is_a_mistake_of_the_caller(self, tmp_path):
        with pytest.raises(KeyError):
            new_log(tmp_path).write("/other", b"", durable=False)

    def test_a_taken_name_is_not_taken_again(self, tmp_path):
        logs = [new_log(tmp_path, name="mine") for _ in range(2)]
        for number, log in enumerate(logs):
            log.write(ANSWERS, numbered(number), durable=True)
        for number, log in enumerate(logs):
            log.close()
            assert undamaged(log.directory) == [numbered(number)]

    def test_a_clock_that_is_put_back_does_not_put_back_the_log(self, tmp_path, monkeypatch):
        log = new_log(tmp_path)
        now = time.time_ns()
        for shown in (now, now, now - 3600 * 10**9, now + 5):
            monkeypatch.setattr(run_log.time, "time_ns", lambda shown=shown: shown)
            log.write(ANSWERS, numbered(0), durable=False)
        log.close()
        times = [message.log_time for message in raw_messages(log.directory)]
        assert times == [now, now + 1, now + 2, now + 5]


class TestRotation:
    def test_no_file_passes_the_bound(self, tmp_path):
        log = new_log(tmp_path, max_bag_bytes=20_000)
        messages = [numbered(number, 10 * number) for number in range(200)]
        for message in messages:
            log.write(ANSWERS, message, durable=False)
            assert log.bytes_written == sum(
                file.stat().st_size for file in log.directory.glob("*.mcap"))
        log.close()
        files = bag_files(log.directory)
        assert len(files) > 10
        assert [file.name for file in files] == [
            f"{log.directory.name}_{number}.mcap" for number in range(len(files))]
        sizes = [file.stat().st_size for file in files]
        assert max(sizes) <= 20_000
        assert min(sizes[:-1]) > 16_000
        assert undamaged(log.directory) == messages

    def test_each_file_stands_by_itself(self, tmp_path):
        log = new_log(tmp_path, max_bag_bytes=20_000)
        for number in range(40):
            log.write(ANSWERS, numbered(number, 2000), durable=False)
        finished = bag_files(log.directory)[:-1]
        found = [message for file in finished for message in undamaged(file)]
        assert len(finished) > 3
        assert found == [numbered(number, 2000) for number in range(len(found))]

    def test_a_message_beyond_the_bound_gets_a_file_of_its_own(self, tmp_path):
        log = new_log(tmp_path, max_bag_bytes=20_000)
        messages = [numbered(number, size) for number, size in enumerate((10, 50_000, 10))]
        for message in messages:
            log.write(ANSWERS, message, durable=True)
        log.close()
        assert [undamaged(file) for file in bag_files(log.directory)] == [
            [message] for message in messages]


class TestSharing:
    """Several threads that wait for the disk."""

    THREADS = 6
    EACH = 25

    def run_threads(self, work):
        threads = [threading.Thread(target=work, args=(one,)) for one in range(self.THREADS)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    def test_nobody_returns_too_early(self, tmp_path, monkeypatch):
        synced = bytearray()
        real = os.fdatasync

        def slow(number: int) -> None:
            with open(f"/proc/self/fd/{number}", "rb") as file:  # noqa: PTH123
                there = file.read()
            time.sleep(0.003)
            real(number)
            synced[:] = there

        monkeypatch.setattr(bag_file.os, "fdatasync", slow)
        log = new_log(tmp_path)
        early = []

        def write(thread: int) -> None:
            for one in range(self.EACH):
                message = numbered(1000 * thread + one)
                log.write(ANSWERS, message, durable=True)
                if message not in synced:
                    early.append(message)

        self.run_threads(write)
        log.close()
        assert early == []
        assert sorted(undamaged(log.directory)) == sorted(
            numbered(1000 * thread + one)
            for thread in range(self.THREADS) for one in range(self.EACH))

    def test_whoever_waits_for_a_sync_shares_the_next(self, tmp_path, monkeypatch):
        log = new_log(tmp_path)
        log.write(ANSWERS, numbered(0), durable=True)
        file = only_file(log.directory)
        messages = [numbered(1 + one) for one in range(self.THREADS)]
        syncs = []

        def held(number: int) -> None:
            """The first sync lasts until every thread has written its message."""
            syncs.append(number)
            end = time.monotonic() + 30.0
            while not all(message in file.read_bytes() for message in messages):
                assert time.monotonic() < end, "the threads do not write while one waits"
                time.sleep(0.001)

        monkeypatch.setattr(bag_file.os, "fdatasync", held)
        self.run_threads(lambda thread: log.write(ANSWERS, messages[thread], durable=True))
        assert len(syncs) in (1, 2)  # 1 where all had written before the first sync began
        log.close()

    def test_threads_meet_at_rotations(self, tmp_path):
        log = new_log(tmp_path, max_bag_bytes=12_000)

        def write(thread: int) -> None:
            for one in range(self.EACH):
                log.write(ANSWERS, numbered(1000 * thread + one, 900), durable=one % 3 == 0)

        self.run_threads(write)
        log.sync()
        log.close()
        assert len(bag_files(log.directory)) > 5
        assert sorted(undamaged(log.directory)) == sorted(
            numbered(1000 * thread + one, 900)
            for thread in range(self.THREADS) for one in range(self.EACH))

    def test_a_sync_covers_what_was_not_durable(self, tmp_path, monkeypatch):
        log = new_log(tmp_path)
        log.write(ANSWERS, numbered(0), durable=True)
        synced = []
        monkeypatch.setattr(bag_file.os, "fdatasync", synced.append)
        log.write(ANSWERS, numbered(1), durable=False)
        assert synced == []
        log.sync()
        log.sync()
        assert len(synced) == 1
