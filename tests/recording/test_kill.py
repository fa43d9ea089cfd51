"""`kill -9` at any moment loses nothing that was acknowledged."""

from __future__ import annotations

import hashlib
import os
import random
import shutil
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from ros_pose_stats.recording.finished import is_finished
from ros_pose_stats.recording.reader.raw_reader import finished_runs
from ros_pose_stats.recording.repair.repair import repair_bags
from ros_pose_stats.recording.run_names import runs
from tests.recording.bags import ANSWERS, RUN, data_of, let_die, new_log, numbered, undamaged
from tests.volume import few_quick

ROOT = Path(__file__).resolve().parents[2]


@contextmanager
def child(module: str, *arguments: str):
    """A process that has imported all it needs and waits for its first line."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    with subprocess.Popen(
            [sys.executable, "-S", "-m", f"tests.recording.{module}", *arguments], cwd=ROOT,
            env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout.readline() == b"ready\n"
            yield process
        finally:
            process.kill()


def start(process) -> None:
    process.stdin.write(b"go\n")
    process.stdin.flush()


def digests(messages: list[bytes]) -> set[str]:
    return {hashlib.sha256(message).hexdigest() for message in messages}


class TestWriter:
    @pytest.mark.parametrize("seed", few_quick(range(50), 5))
    def test_everything_acknowledged_is_there(self, tmp_path, seed):
        chance = random.Random(seed)
        threads = chance.choice((1, 1, 3))
        with child("writer", str(tmp_path), str(seed), str(threads), "100000") as process:
            start(process)
            time.sleep(chance.choice((0.002, 0.02, 0.1)) * chance.random())
            process.kill()
            lines = process.stdout.read().decode().split("\n")[:-1]
        acknowledged = {line.split()[1] for line in lines}
        unrepaired = [data for run in runs(tmp_path) for data in data_of(run)]
        assert acknowledged <= digests(unrepaired)
        if acknowledged:
            assert finished_runs(tmp_path) == runs(tmp_path)
        repairs = repair_bags(tmp_path)
        assert not any(repair.problem for repair in repairs)
        assert all(is_finished(run) for run in runs(tmp_path))
        repaired = [data for run in runs(tmp_path) for data in undamaged(run)]
        assert repaired == unrepaired
        assert sum(repair.kept for repair in repairs) == len(repaired)
        for data in repaired:
            text = data[8:-1].decode()
            assert data == numbered(int(text.split(":")[0]), len(text.split(":")[1]))


@pytest.fixture(scope="module")
def unfinished(tmp_path_factory):
    """A bag with several files, each with half a message at its end, and what it holds."""
    folder = tmp_path_factory.mktemp("unfinished")
    messages = [numbered(number, 100_000) for number in range(60)]
    log = new_log(folder, name=RUN, max_bag_bytes=1_500_000)
    for message in messages:
        log.write(ANSWERS, message, durable=False)
    log.sync()
    let_die(log)
    for file in log.directory.glob("*.mcap"):
        os.truncate(file, file.stat().st_size - 100)
    return log.directory, data_of(log.directory)


class TestRepairer:
    """A repair that is killed and repeated."""

    @pytest.mark.parametrize("seed", few_quick(range(12), 3))
    def test_nothing_is_lost(self, tmp_path, unfinished, seed):
        directory, messages = unfinished
        shutil.copytree(directory, tmp_path / RUN)
        with child("repairer", str(tmp_path)) as process:
            start(process)
            time.sleep(0.06 * random.Random(seed).random())
            process.kill()
        assert data_of(tmp_path / RUN) == messages
        assert [repair.problem for repair in repair_bags(tmp_path)] in ([""], [])
        assert undamaged(tmp_path / RUN) == messages
        assert list((tmp_path / RUN).glob("*.half")) == []


class TestTwoProcesses:
    def test_the_bag_of_a_living_process_is_not_touched(self, tmp_path):
        with child("writer", str(tmp_path), "1", "2", "200000") as process:
            start(process)
            lines = [process.stdout.readline() for _ in range(20)]
            [directory] = runs(tmp_path)
            files = {file: file.stat().st_ino for file in directory.glob("*.mcap")}
            assert repair_bags(tmp_path) == []
            assert finished_runs(tmp_path) == []
            log = new_log(tmp_path, max_log_bytes=1)
            log.write(ANSWERS, numbered(7), durable=True)
            assert (log.over_bound, log.bytes_left, log.deleted_runs) == (True, 0, [])
            assert {file: file.stat().st_ino for file in files} == files
            log.close()
            assert finished_runs(tmp_path) == [log.directory]
            lines += [process.stdout.readline() for _ in range(20)]
            process.kill()
            lines += process.stdout.read().splitlines()
        [repair] = repair_bags(tmp_path)
        assert repair.directory == directory
        acknowledged = {line.split()[1].decode() for line in lines}
        assert acknowledged <= digests(undamaged(directory))

    def test_starts_and_ends_at_the_same_time(self, tmp_path):
        """Processes that start, repair and are killed on one directory."""
        acknowledged: set[str] = set()
        chance = random.Random(5)
        for _ in range(4):
            with (child("writer", str(tmp_path), "1", "1", "50000") as one,
                  child("writer", str(tmp_path), "2", "1", "50000") as other):
                start(one)
                start(other)
                until = time.monotonic() + 0.05 + 0.1 * chance.random()
                while time.monotonic() < until:
                    repair_bags(tmp_path)
                one.kill()
                repair_bags(tmp_path)
                other.kill()
                for process in (one, other):
                    acknowledged |= {
                        line.split()[1].decode() for line in process.stdout.read().splitlines()}
        repair_bags(tmp_path)
        assert len(acknowledged) > 5
        assert acknowledged <= digests([
            data for run in runs(tmp_path) for data in undamaged(run)])
