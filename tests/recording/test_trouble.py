"""Disks that fail or are full, and directories that disappear: the log goes on."""

from __future__ import annotations

import errno
import itertools
import os
import pickle
import shutil
import subprocess
from contextlib import suppress
from pathlib import Path

import pytest

from ros_pose_stats.recording.directory_lock import is_locked
from ros_pose_stats.recording.finished import is_finished
from ros_pose_stats.recording.repair.repair import repair_bags
from ros_pose_stats.recording.run_names import runs
from ros_pose_stats.recording.writer.run_log import RecordingError
from tests.recording.bags import (
    ANSWERS,
    RUN,
    data_of,
    let_die,
    new_log,
    numbered,
    only_file,
    undamaged,
    unfinished_bag,
)
from tests.recording.faults import Faults

COUNT = 12
MESSAGES = [numbered(number, 1500) for number in range(COUNT)]


def write_all(log, messages=MESSAGES) -> list[bytes]:
    """Those whose writing was acknowledged."""
    acknowledged = []
    for message in messages:
        with suppress(RecordingError):
            log.write(ANSWERS, message, durable=True)
            acknowledged.append(message)
    return acknowledged


def everything(log_directory: Path) -> list[bytes]:
    return [data for run in runs(log_directory) for data in undamaged(run)]


class TestFaults:
    """Every system call fails, one after the other."""

    @pytest.fixture(autouse=True)
    def no_waiting(self, monkeypatch):
        """Thousands of syncs need not wait for the disk."""
        for name in ("fsync", "fdatasync"):
            monkeypatch.setattr(os, name, lambda number: None)

    @pytest.mark.parametrize(("lasting", "closed"), [(1, True), (3, False), (20, False)])
    def test_a_log_recovers_from_any_failure(self, tmp_path, lasting, closed):
        for first in itertools.count():
            folder = tmp_path / str(first)
            log = new_log(folder, max_bag_bytes=14_000)
            with pytest.MonkeyPatch.context() as patch:
                faults = Faults(patch, lambda number, first=first: 0 <= number - first < lasting)
                acknowledged = write_all(log)
            after = numbered(COUNT, 100)
            log.write(ANSWERS, after, durable=True)
            assert {*acknowledged, after} <= {
                data for run in runs(folder) for data in data_of(run)}
            if closed:
                log.close()
            else:
                let_die(log)
            repair_bags(folder)
            assert all(is_finished(run) and not is_locked(run) for run in runs(folder))
            found = everything(folder)
            assert {*acknowledged, after} <= set(found) <= {*MESSAGES, after}
            assert len(set(found)) == len(found)
            assert [one for one in folder.iterdir() if one.name[0] != "."] == runs(folder)
            assert log.times_lost == 0
            if not faults.failed:
                assert len(acknowledged) == COUNT
                break
        assert first > 50

    def test_a_repair_can_be_repeated_after_any_failure(self, tmp_path):
        for first in itertools.count():
            folder = tmp_path / str(first)
            directory, _ = unfinished_bag(folder, MESSAGES, RUN)
            content = only_file(directory).read_bytes()
            only_file(directory).write_bytes(content[:-100])
            with pytest.MonkeyPatch.context() as patch:
                faults = Faults(patch, lambda number, first=first: number == first)
                repairs = repair_bags(folder)
            assert data_of(directory) == MESSAGES[:-1]
            assert [one.directory for one in repairs] in ([directory], [folder])
            again = repair_bags(folder)
            assert is_finished(directory) and undamaged(directory) == MESSAGES[:-1]
            assert not any(one.problem for one in again)
            if not faults.failed:
                break
        assert first > 10


def test_an_error_is_one_clear_line(tmp_path):
    (tmp_path / "log").write_text("mine")
    log = new_log(tmp_path / "log", name=RUN)
    with pytest.raises(RecordingError) as caught:
        log.write(ANSWERS, MESSAGES[0], durable=True)
    assert str(caught.value) == f"cannot record to {tmp_path}/log/{RUN}: File exists"
    assert caught.value.errno == errno.EEXIST
    copy = pickle.loads(pickle.dumps(caught.value))
    assert (str(copy), copy.directory) == (str(caught.value), caught.value.directory)


class TestFullDisk:
    @pytest.fixture
    def small_disk(self, tmp_path):
        """A disk of 300 kB, where one may be mounted."""
        place = tmp_path / "disk"
        place.mkdir()
        mounted = os.geteuid() == 0 and subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", place],
            capture_output=True).returncode == 0
        if not mounted:
            pytest.skip("no right to mount a disk")
        yield place
        subprocess.run(["umount", place], check=True)

    def test_recording_goes_on_when_there_is_room_again(self, small_disk):
        ballast = small_disk / "ballast"
        ballast.write_bytes(bytes(100_000))
        log = new_log(small_disk / "log", max_bag_bytes=60_000)
        messages = [numbered(number, 5000) for number in range(80)]
        acknowledged = write_all(log, messages[:60])
        assert 20 < len(acknowledged) < 60
        with pytest.raises(RecordingError, match="No space left on device"):
            log.write(ANSWERS, messages[60], durable=True)
        assert data_of(log.directory) == acknowledged
        ballast.unlink()
        acknowledged += write_all(log, messages[61:65])
        assert acknowledged[-4:] == messages[61:65]
        log.close()
        assert undamaged(log.directory) == acknowledged

    def test_a_disk_full_from_the_start(self, small_disk):
        ballast = small_disk / "ballast"
        with pytest.raises(OSError, match="No space left"):
            ballast.write_bytes(bytes(400_000))
        log = new_log(small_disk / "log")
        assert write_all(log) == []
        ballast.unlink()
        assert write_all(log) == MESSAGES
        log.close()
        assert everything(small_disk / "log") == MESSAGES

    def test_a_bag_that_cannot_be_finished_is_mended_later(self, small_disk):
        log = new_log(small_disk / "log")
        write_all(log, MESSAGES[:2])
        ballast = small_disk / "ballast"
        with pytest.raises(OSError, match="No space left"):
            ballast.write_bytes(bytes(400_000))
        with pytest.raises(RecordingError, match="No space left"):
            log.close()
        [repair] = repair_bags(small_disk / "log")
        assert "No space left" in repair.problem
        assert data_of(log.directory) == MESSAGES[:2]
        ballast.unlink()
        assert repair_bags(small_disk / "log")[0].kept == 2
        assert undamaged(log.directory) == MESSAGES[:2]


class TestDisappearance:
    def test_a_deleted_log_directory_is_made_again(self, tmp_path):
        log = new_log(tmp_path / "log")
        write_all(log, MESSAGES[:3])
        before = log.directory
        shutil.rmtree(tmp_path / "log")
        assert write_all(log, MESSAGES[3:]) == MESSAGES[3:]
        assert log.times_lost == 1
        assert log.directory != before
        log.close()
        assert everything(tmp_path / "log") == MESSAGES[3:]

    def test_a_bag_that_is_moved_away_stays_as_it_was(self, tmp_path):
        log = new_log(tmp_path / "log")
        write_all(log, MESSAGES[:3])
        moved = log.directory.rename(tmp_path / "kept")
        write_all(log, MESSAGES[3:])
        log.close()
        assert data_of(moved) == MESSAGES[:3]
        assert everything(tmp_path / "log") == MESSAGES[3:]
        assert not is_locked(moved)

    def test_a_deleted_file_is_followed_by_another(self, tmp_path):
        log = new_log(tmp_path)
        write_all(log, MESSAGES[:3])
        only_file(log.directory).unlink()
        write_all(log, MESSAGES[3:])
        log.close()
        assert log.times_lost == 0
        assert undamaged(log.directory) == MESSAGES[3:]
        assert is_finished(log.directory)

    def test_a_deleted_lock_makes_another_bag(self, tmp_path):
        log = new_log(tmp_path)
        write_all(log, MESSAGES[:3])
        first = log.directory
        (first / ".lock").unlink()
        write_all(log, MESSAGES[3:])
        log.close()
        repair_bags(tmp_path)
        assert everything(tmp_path) == MESSAGES
        assert log.directory != first

    def test_a_bag_deleted_before_the_end(self, tmp_path):
        log = new_log(tmp_path / "log")
        write_all(log, MESSAGES[:3])
        shutil.rmtree(tmp_path / "log")
        log.close()
        assert not (tmp_path / "log").exists()

    def test_a_file_in_place_of_the_log_directory(self, tmp_path):
        (tmp_path / "log").write_text("mine")
        log = new_log(tmp_path / "log")
        assert write_all(log) == []
        (tmp_path / "log").unlink()
        assert write_all(log) == MESSAGES
        log.close()
