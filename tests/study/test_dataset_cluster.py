"""A dataset from a dask.distributed cluster of separate processes, some of which die."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, closing, contextmanager

import pytest

from ros_pose_stats.errors import BatchError
from ros_pose_stats.study.dataset import DatasetSpec, make_chunk, make_dataset, on_threads
from ros_pose_stats.version import VERSION
from tests.clusters import scheduler, worker
from tests.running import ROOT, complaints

distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")

from ros_pose_stats.batch.cluster import work_there  # noqa: E402
from ros_pose_stats.study.dataset.cluster import on_cluster  # noqa: E402

OPTIONS = ("--bodies", "200", "--drops", "40", "--seed", "5")
SPEC = DatasetSpec(bodies=200, drops=40, seed=5)


@pytest.fixture
def elsewhere(tmp_path_factory):
    return tmp_path_factory.mktemp("cluster")


@contextmanager
def client_of(address):
    """Ours, to look into the scheduler."""
    with distributed.Client(address, set_as_default=False, timeout=60) as client:
        yield client


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.npz"
    assert make_dataset(path, SPEC, on_threads(1))
    return path.read_bytes()


def started(file, address):
    return subprocess.Popen(
        [sys.executable, "-m", "ros_pose_stats", "dataset", "-o", str(file), *OPTIONS,
         "--scheduler", address], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        cwd=ROOT)


def pieces(file):
    return list(file.with_name(file.name + ".unfinished").glob("bodies_*.npz"))


def wait_for_a_piece(file, running):
    while not pieces(file):
        assert running.poll() is None, running.communicate()
        time.sleep(0.005)


@pytest.mark.long
class TestLosses:
    @pytest.mark.parametrize("again", ["0", "3"])
    def test_a_worker_is_killed_midway(self, whole, tmp_path, elsewhere, again):
        """The one that holds most of the work; a scheduler may give up pieces at once."""
        file = tmp_path / "a.npz"
        with ExitStack() as cluster:
            _, address = cluster.enter_context(scheduler(
                elsewhere, DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES=again))
            workers = [cluster.enter_context(worker(address)) for _ in range(2)]
            client = cluster.enter_context(client_of(address))
            client.wait_for_workers(2, timeout=60)
            pids = client.run(os.getpid)
            assert sorted(pids.values()) == sorted(one.pid for one in workers)
            running = started(file, address)
            wait_for_a_piece(file, running)
            busy = client.processing()
            assert sum(map(len, busy.values())) > 0
            os.kill(pids[max(busy, key=lambda one: len(busy[one]))], signal.SIGKILL)
            assert not file.exists()
            out, err = running.communicate()
            assert running.returncode == 0, err
            assert complaints(err) == []
            assert "200 random polyhedra" in out
            assert len(client.nthreads()) == 1
        assert file.read_bytes() == whole
        assert list(tmp_path.iterdir()) == [file]

    def test_ctrl_c_then_the_scheduler_dies_then_threads_go_on(self, whole, tmp_path,
                                                                       elsewhere):
        file = tmp_path / "a.npz"
        with scheduler(elsewhere) as (head, address), worker(address), ExitStack() as cluster:
            client = cluster.enter_context(client_of(address))
            running = started(file, address)
            wait_for_a_piece(file, running)
            running.send_signal(signal.SIGINT)
            out, err = running.communicate()
            assert (running.returncode, out) == (130, "")
            assert complaints(err) == ["ros_pose_stats: interrupted; the same command goes on "
                                       "from here"]
            there = len(pieces(file))
            assert there > 0
            while client.run_on_scheduler(lambda dask_scheduler: len(dask_scheduler.tasks)):
                time.sleep(0.05)  # given up, they all go away
            cluster.close()
            running = started(file, address)
            while len(pieces(file)) == there:
                assert running.poll() is None, running.communicate()
                time.sleep(0.005)
            head.kill()
            out, err = running.communicate()
            assert (running.returncode, out) == (2, "")
            (line,) = complaints(err)
            assert "expected a scheduler that stays" in line
            assert len(pieces(file)) > there
        assert make_dataset(file, SPEC, on_threads(1))
        assert file.read_bytes() == whole

    def test_no_worker_comes(self, tmp_path, elsewhere):
        file = tmp_path / "a.npz"
        with scheduler(elsewhere) as (_, address), client_of(address):
            with pytest.raises(BatchError, match=r"a worker at the scheduler.*dask worker"):
                make_dataset(file, SPEC, on_cluster(address, worker_seconds=0.5))
            polled = []
            assert not make_dataset(file, SPEC, on_cluster(address),
                                    should_stop=lambda: polled.append(1) or len(polled) > 9)
        assert list(tmp_path.iterdir()) == []


class TestWhatAnswers:
    def refused(self, address, tmp_path):
        with pytest.raises(BatchError, match="a scheduler that answers") as refusal:
            make_dataset(tmp_path / "a.npz", SPEC, on_cluster(address))
        assert "\n" not in str(refusal.value)
        assert list(tmp_path.iterdir()) == []

    def test_nothing(self, tmp_path, monkeypatch):
        monkeypatch.setattr("ros_pose_stats.batch.cluster.CONNECT_SECONDS", 0.5)
        self.refused("tcp://127.0.0.1:1", tmp_path)

    @pytest.mark.parametrize("first", [b"", b"HTTP/1.0 400 Bad Request\r\n\r\n", b"\0" * 64],
                             ids=["silent", "http", "zeros"])
    def test_something_else(self, tmp_path, monkeypatch, first):
        """A server that hangs, or one that talks another language."""
        monkeypatch.setattr("ros_pose_stats.batch.cluster.CONNECT_SECONDS", 1.0)
        with closing(socket.create_server(("127.0.0.1", 0))) as server:
            address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
            answer = subprocess.Popen(
                [sys.executable, "-c", "import socket, sys, time\n"
                 f"server = socket.socket(fileno={server.fileno()})\n"
                 "while True:\n"
                 "    talk = server.accept()[0]\n"
                 f"    talk.sendall({first!r})\n"
                 "    keep = globals().setdefault('keep', []) + [talk]\n"],
                pass_fds=[server.fileno()])
            try:
                self.refused(address, tmp_path)
            finally:
                answer.kill()
                answer.wait()

    def test_ctrl_c_while_it_is_looked_for(self, tmp_path):
        polled = []
        assert not make_dataset(tmp_path / "a.npz", SPEC, on_cluster("tcp://127.0.0.1:1"),
                                should_stop=lambda: polled.append(1) or len(polled) > 3)
        assert list(tmp_path.iterdir()) == []


class TestOnTheWorker:
    def test_another_version_is_refused(self):
        with pytest.raises(BatchError, match="same version everywhere"):
            work_there("0.0.1", make_chunk, SPEC, 0, 1)

    def test_the_same_version_makes_the_piece(self):
        assert len(work_there(VERSION, make_chunk, SPEC, 3, 2)["poses"]) == 2
