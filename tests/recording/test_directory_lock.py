"""Who holds a directory, also when it is deleted or replaced."""

from __future__ import annotations

import shutil
import subprocess
import sys

import pytest

from ros_pose_stats.recording.directory_lock import DirectoryLock, is_locked


def test_a_lock_is_held_by_one(tmp_path):
    with DirectoryLock.take(tmp_path) as lock:
        assert lock.holds(tmp_path)
        assert is_locked(tmp_path)
        assert DirectoryLock.take(tmp_path) is None
    assert not is_locked(tmp_path)
    assert DirectoryLock.take(tmp_path) is not None


def test_looking_leaves_nothing_behind(tmp_path):
    assert not is_locked(tmp_path)
    assert list(tmp_path.iterdir()) == []
    assert not is_locked(tmp_path / "missing")


def test_a_missing_directory_cannot_be_locked(tmp_path):
    with pytest.raises(FileNotFoundError):
        DirectoryLock.take(tmp_path / "missing")


def test_a_replaced_directory_is_not_the_one_that_was_locked(tmp_path):
    directory = tmp_path / "bag"
    directory.mkdir()
    with DirectoryLock.take(directory) as lock:
        shutil.rmtree(directory)
        assert not lock.holds(directory)
        directory.mkdir()
        assert not lock.holds(directory)
        with DirectoryLock.take(directory) as other:
            assert other.holds(directory) and not lock.holds(directory)


def test_a_moved_directory_is_still_locked_where_it_is_now(tmp_path):
    directory = tmp_path / "bag"
    directory.mkdir()
    with DirectoryLock.take(directory) as lock:
        moved = directory.rename(tmp_path / "moved")
        assert lock.holds(moved) and is_locked(moved) and not lock.holds(directory)


def test_the_lock_ends_with_its_process(tmp_path):
    code = ("import sys, pathlib\n"
            "from ros_pose_stats.recording.directory_lock import DirectoryLock\n"
            "lock = DirectoryLock.take(pathlib.Path(sys.argv[1]))\n"
            "print('held', flush=True)\n"
            "sys.stdin.read()")
    with subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], text=True,
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        assert child.stdout.readline() == "held\n"
        assert is_locked(tmp_path)
        child.kill()
        child.wait()
    assert not is_locked(tmp_path)
