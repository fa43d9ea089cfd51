"""A bounded log directory loses its oldest finished runs, then the oldest files of the bag."""

from __future__ import annotations

import re
from contextlib import suppress

import pytest

from ros_pose_stats.recording.directory_lock import DirectoryLock
from ros_pose_stats.recording.finished import is_finished
from ros_pose_stats.recording.repair import removal
from ros_pose_stats.recording.repair.repair import repair_bags
from ros_pose_stats.recording.run_names import METADATA, bag_files, runs
from ros_pose_stats.recording.writer.run_log import RecordingError
from tests.recording.bags import (
    ANSWERS,
    data_of,
    finished_bag,
    let_die,
    new_log,
    numbered,
    undamaged,
    unfinished_bag,
)
from tests.recording.faults import Faults


def name(number: int) -> str:
    return f"pose_stats_20260102T030405_{number:06}_7"


@pytest.fixture
def old_runs(tmp_path):
    """Five finished runs of 50 to 60 kB."""
    return [finished_bag(tmp_path, [numbered(number, 50_000)], name(number))
            for number in range(5)]


def write(log, size: int) -> None:
    log.write(ANSWERS, numbered(0, size), durable=False)


def total(folder) -> int:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def test_the_oldest_go_first_and_no_more_than_needed(tmp_path, old_runs):
    log = new_log(tmp_path, max_log_bytes=300_000)
    for _ in range(12):
        write(log, 10_000)
        assert total(tmp_path) <= 300_000
    assert runs(tmp_path) == [*old_runs[3:], log.directory]
    assert log.deleted_runs == old_runs[:3]
    assert log.deleted_runs == []
    assert not log.over_bound
    assert 0 <= log.bytes_left <= 300_000 - total(tmp_path) + 10_000
    assert undamaged(old_runs[3]) == [numbered(3, 50_000)]
    log.close()
    assert total(tmp_path) <= 300_000


def test_without_a_bound_nothing_goes(tmp_path, old_runs):
    log = new_log(tmp_path)
    write(log, 1_000_000)
    assert runs(tmp_path) == [*old_runs, log.directory]
    assert (log.bytes_left, log.over_bound, log.deleted_runs) == (None, False, [])


class TestOwnFiles:
    """Once no other run may go, the oldest closed files of the running bag do."""

    @pytest.fixture
    def log(self, tmp_path, old_runs):
        """A bag that has lost files; each of its messages has 10 kB and its number."""
        log = new_log(tmp_path, max_log_bytes=300_000)
        for number in range(100):
            log.write(ANSWERS, numbered(number, 10_000), durable=False)
            assert total(tmp_path) <= 300_000
        assert runs(tmp_path) == [log.directory]
        yield log
        log.close()

    @staticmethod
    def described(directory):
        """The files that metadata.yaml names."""
        return re.findall(r'path: "(.*mcap)"', (directory / METADATA).read_text())

    def test_go_and_the_last_messages_stay(self, log):
        data = data_of(log.directory)
        assert data == [numbered(number, 10_000) for number in range(100 - len(data), 100)]
        assert len(data) > 15
        own = log.own_files
        assert own.deleted > 10 and not log.over_bound
        assert own.last_deleted == f"{log.directory.name}_{own.deleted - 1}.mcap"

    def test_leave_a_bag_that_is_described_as_it_is(self, log):
        left = [file.name for file in bag_files(log.directory)]
        assert self.described(log.directory) == left
        assert left[0].endswith(f"_{log.own_files.deleted}.mcap")
        log.close()
        assert self.described(log.directory) == left
        assert len(undamaged(log.directory)) == len(data_of(log.directory))
        assert is_finished(log.directory)

    def test_leave_a_bag_that_can_be_mended(self, tmp_path, log):
        log.sync()
        data = data_of(log.directory)
        let_die(log)
        (repair,) = repair_bags(tmp_path)
        assert (repair.kept, repair.problem) == (len(data), "")
        assert undamaged(log.directory) == data

    @pytest.mark.parametrize("call", ["replace", "unlink"])
    def test_that_cannot_be_deleted_now_go_later(self, log, monkeypatch, call):
        first = bag_files(log.directory)[0]
        with monkeypatch.context() as patch:
            faults = Faults(patch, lambda number: True, [call])
            for number in range(100, 110):
                with suppress(RecordingError):
                    log.write(ANSWERS, numbered(number, 10_000), durable=False)
            assert faults.failed
            assert first.exists() == log.over_bound == (call == "unlink")
        log.write(ANSWERS, numbered(110, 10_000), durable=False)
        assert not first.exists() and not log.over_bound
        log.close()
        assert self.described(log.directory) == [one.name for one in bag_files(log.directory)]
        assert is_finished(log.directory)

    def test_give_notice_before_they_go(self, tmp_path):
        """What is written again at the notice is always there, by its mark or by the other."""
        log = new_log(tmp_path, max_log_bytes=300_000)
        kept, mark = numbered(-1, 5_000), -1
        for number in range(200):
            if mark < log.own_files.kept_from:
                mark = log.mark
                log.write(ANSWERS, kept, durable=False)
            log.write(ANSWERS, numbered(number, 1_000 + 100 * number), durable=False)
            assert kept in data_of(log.directory)
        assert log.own_files.deleted > 20
        assert data_of(log.directory).count(kept) <= 3
        log.close()

    def test_one_message_that_is_larger_than_the_bound_is_said(self, log):
        log.write(ANSWERS, numbered(7, 400_000), durable=True)
        assert log.over_bound and not log.waits and log.bytes_left == 0
        assert data_of(log.directory)[-1] == numbered(7, 400_000)
        log.write(ANSWERS, numbered(8, 10_000), durable=True)
        log.write(ANSWERS, numbered(9, 10_000), durable=True)
        assert not log.over_bound
        assert data_of(log.directory) == [numbered(8, 10_000), numbered(9, 10_000)]


class TestRunsInUse:
    """They are asked for a file ahead, and waited for before own files go."""

    LIMIT = 400_000

    @pytest.fixture
    def needed(self):
        """Names of runs that are in use."""
        return set()

    @pytest.fixture
    def asked(self):
        return []

    @pytest.fixture
    def log(self, tmp_path, old_runs, needed, asked):
        def in_use(run):
            asked.append(run)
            return run in needed

        log = new_log(tmp_path, max_log_bytes=self.LIMIT)
        log.keep_runs(in_use)
        yield log
        log.close()

    def test_are_asked_for_before_they_must_go(self, log, old_runs, asked, tmp_path):
        write(log, 10)
        assert old_runs[0] in asked and old_runs[-1] not in asked
        assert runs(tmp_path) == [*old_runs, log.directory]

    def test_stay_and_others_go(self, log, old_runs, needed, tmp_path, monkeypatch):
        monkeypatch.setattr(removal, "SOON", 0.0)
        needed.add(old_runs[0])
        for _ in range(25):
            write(log, 10_000)
        assert old_runs[0].is_dir() and not old_runs[1].is_dir()
        assert total(tmp_path) <= self.LIMIT + log.own_files.margin

    def test_are_waited_for_but_not_for_ever(self, log, old_runs, needed, tmp_path):
        needed.update(old_runs)
        while total(tmp_path) <= self.LIMIT + log.own_files.margin // 2:
            write(log, 10_000)
        assert log.over_bound and log.waits and log.own_files.deleted == 0
        for _ in range(100):
            write(log, 10_000)
            assert total(tmp_path) <= self.LIMIT + log.own_files.margin
        assert log.own_files.deleted > 0 and all(run.is_dir() for run in old_runs)
        needed.clear()
        log.release_files(log.mark)
        assert not log.over_bound and not old_runs[0].is_dir()
        assert total(tmp_path) <= self.LIMIT


def test_what_is_held_unfinished_or_somebody_elses_stays(tmp_path, old_runs):
    held, foreign, noted, *rest = old_runs
    (foreign / "notes.txt").write_text("mine")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "file").write_bytes(bytes(1000))
    unfinished, _ = unfinished_bag(tmp_path, [numbered(0, 50_000)], name(0) + "0")
    noted.rename(tmp_path / "good_run")
    with DirectoryLock.take(held):
        log = new_log(tmp_path, max_log_bytes=1)
        write(log, 10)
        assert log.deleted_runs == rest
        assert runs(tmp_path) == [held, unfinished, foreign, log.directory]
        assert (tmp_path / "other" / "file").exists() and (tmp_path / "good_run").exists()
        assert log.over_bound


def test_what_others_did_is_noticed_in_time(tmp_path, old_runs, monkeypatch):
    now = [1000.0]
    monkeypatch.setattr(removal.time, "monotonic", lambda: now[0])
    log = new_log(tmp_path, max_log_bytes=500_000)
    write(log, 10)
    later = [finished_bag(tmp_path, [numbered(0, 100_000)], f"{name(9)}{number}")
             for number in range(3)]
    write(log, 10)
    assert len(runs(tmp_path)) == 9
    now[0] += removal.RESCAN
    write(log, 10)
    assert runs(tmp_path) == [*old_runs[3:], *later, log.directory]


def test_a_run_that_gets_free_goes_later(tmp_path, old_runs, monkeypatch):
    now = [1000.0]
    monkeypatch.setattr(removal.time, "monotonic", lambda: now[0])
    log = new_log(tmp_path, max_log_bytes=50_000)
    with DirectoryLock.take(old_runs[0]):
        write(log, 10)
        assert log.over_bound and runs(tmp_path) == [old_runs[0], log.directory]
    now[0] += removal.RESCAN
    write(log, 10)
    assert not log.over_bound and runs(tmp_path) == [log.directory]
