"""A bounded log directory loses its oldest finished runs, and nothing else."""

from __future__ import annotations

import pytest

from ros_pose_stats.recording.directory_lock import DirectoryLock
from ros_pose_stats.recording.repair import removal
from ros_pose_stats.recording.run_names import runs
from tests.recording.bags import (
    ANSWERS,
    data_of,
    finished_bag,
    new_log,
    numbered,
    undamaged,
    unfinished_bag,
)


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


def test_the_own_run_stays_and_says_that_it_is_too_large(tmp_path, old_runs):
    log = new_log(tmp_path, max_log_bytes=100_000, max_bag_bytes=60_000)
    for number in range(10):
        log.write(ANSWERS, numbered(number, 30_000), durable=True)
    assert runs(tmp_path) == [log.directory]
    assert log.over_bound
    assert log.bytes_left == 0
    assert data_of(log.directory) == [numbered(number, 30_000) for number in range(10)]


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
