"""Work in processes: all of it comes back, and the death of one harms nobody else."""

import importlib.util
import math
import operator
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ros_pose_stats.batch.processes import (
    ProcessDiedError,
    TookLongError,
    WorkerProcess,
    check_workers,
    work_in_processes,
)
from ros_pose_stats.errors import RequestError


@pytest.fixture
def process():
    process = WorkerProcess()
    yield process
    process.kill()


def children():
    """Ids of the processes that this one has started."""
    mine = set()
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            stat = (folder / "stat").read_text()
        except OSError:  # ended just now
            continue
        state, parent = stat.rpartition(")")[2].split()[:2]
        if int(parent) == os.getpid() and state != "Z":
            mine.add(int(folder.name))
    return mine


def test_a_process_calls_functions_one_after_the_other(process):
    assert [process.call(math.factorial, n) for n in range(6)] == [1, 1, 2, 6, 24, 120]
    assert process.call(os.getpid) != os.getpid()


def test_no_module_comes_from_where_it_is_started(tmp_path, monkeypatch):
    """A file beside the parts may have the name of a module that the work needs."""
    (tmp_path / "queue.py").write_text("import pathlib; pathlib.Path('ran').touch(); 1 / 0")
    (tmp_path / "sent_along.py").write_text("")
    monkeypatch.chdir(tmp_path)
    process = WorkerProcess()
    try:
        assert process.call(eval, "__import__('sys').path") == sys.path
        assert process.call(importlib.util.find_spec, "sent_along") is None
    finally:
        process.kill()
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(("ending", "arguments", "told"), [
    (os.abort, (), "SIGABRT"), (os._exit, (3,), "status 3"),
    (signal.raise_signal, (signal.SIGKILL,), "SIGKILL"), (operator.truediv, (1, 0), "status 1"),
])
def test_how_it_ended_is_told(process, ending, arguments, told):
    with pytest.raises(ProcessDiedError, match=told):
        process.call(ending, *arguments)


def test_ctrl_c_is_for_whoever_started_it(process):
    os.kill(process.call(os.getpid), signal.SIGINT)
    assert process.call(operator.add, 1, 2) == 3


def test_a_piece_that_kills_its_process_costs_no_other():
    deadly = {3, 11}

    def call(process, piece):
        return process.call(*((os.abort,) if piece in deadly else (math.factorial, piece)))

    before = children()
    found = dict(work_in_processes(2, call, lambda piece, how: how, range(20), lambda: False))
    assert {piece for piece, how in found.items() if str(how) == "ended by SIGABRT"} == deadly
    assert all(found[n] == math.factorial(n) for n in set(range(20)) - deadly)
    assert children() == before


def test_a_process_that_died_for_another_reason_gets_a_second_try():
    tries = []

    def call(process, piece):
        tries.append(piece)
        return process.call(*((os.abort,) if len(tries) == 1 else (math.factorial, piece)))

    assert list(work_in_processes(1, call, lambda *_: None, [4], lambda: False)) == [(4, 24)]
    assert tries == [4, 4]


def test_a_piece_that_takes_too_long_is_not_tried_again():
    tries, before = [], children()

    def call(process, piece):
        tries.append(piece)
        return process.call_within(
            *((0.2, time.sleep, 600.0) if piece == 1 else (60.0, math.factorial, piece)))

    found = dict(work_in_processes(1, call, lambda piece, how: how, range(4), lambda: False))
    assert [found[n] for n in (0, 2, 3)] == [1, 2, 6]
    assert isinstance(found[1], TookLongError)
    assert tries == [0, 1, 2, 3]
    assert children() == before


SUSPENDED = """
import time
from ros_pose_stats.batch.processes import WorkerProcess
process = WorkerProcess()
print("started", flush=True)
process.call_within(2.0, time.sleep, 0.5)
process.kill()
print("in time", flush=True)
"""


def test_a_run_that_is_suspended_takes_no_time():
    """By Ctrl-Z, say, and with all its processes."""
    running = subprocess.Popen([sys.executable, "-c", SUSPENDED], stdout=subprocess.PIPE,
                               text=True, start_new_session=True)
    assert running.stdout.readline() == "started\n"
    os.killpg(running.pid, signal.SIGSTOP)
    time.sleep(3.0)
    os.killpg(running.pid, signal.SIGCONT)
    assert running.communicate()[0] == "in time\n"


def test_what_is_in_hand_is_given_up_on_a_stop():
    begin, polled = time.monotonic(), []
    before = children()
    found = list(work_in_processes(
        2, lambda process, piece: process.call(time.sleep, 600.0), lambda *_: None, range(4),
        lambda: polled.append(1) or len(polled) > 20))
    assert found == []
    assert time.monotonic() < begin + 60.0
    assert children() == before


@pytest.mark.parametrize("workers", [0, -1, 1025])
def test_workers_out_of_their_range(workers):
    with pytest.raises(RequestError, match="workers"):
        check_workers(workers)
