"""What takes long in building a part holds up nothing quick, and not for ever."""

from __future__ import annotations

import os
import threading
from functools import partial

import pytest

from ros_pose_stats import part_from_mesh
from ros_pose_stats.batch.worker import WorkerProcess
from ros_pose_stats.errors import BatchError, RequestError
from ros_pose_stats.ros.parts.intake import LARGE_BYTES, Intake
from ros_pose_stats.ros.parts.known_part import NODE_SCENE, KnownPart, PartSource
from ros_pose_stats.ros.parts.lanes import Lane, Lanes, Rank

TETRAHEDRON = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
               [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


@pytest.fixture
def lanes():
    queue = Lanes(lambda: 2**20)
    queue.start()
    yield queue
    queue.close()


def occupied(lanes, lane):
    """What ends the task that keeps a lane busy."""
    begun, may_end = threading.Event(), threading.Event()

    def work():
        begun.set()
        may_end.wait()

    lanes.put(work, Rank.KNOWN, lane)
    assert begun.wait(60.0)
    return may_end


def test_a_large_part_that_is_asked_for_is_built_beside_quick_ones(lanes):
    begun, may_end = threading.Event(), threading.Event()

    def build():
        begun.set()
        may_end.wait()
        return part_from_mesh(*TETRAHEDRON)

    known = KnownPart("large", "", b"", NODE_SCENE, PartSource(None, build), size=LARGE_BYTES + 1)
    intake = Intake(None, None, None, None, lanes, None, None, None, None)
    try:
        large = intake.built(known)
        assert begun.wait(60.0)
        assert lanes.put(lambda: "quick", Rank.KNOWN).result(60.0) == "quick"
        assert not large.done()
    finally:
        may_end.set()
    assert large.result(60.0) is known and known.source.is_built


def test_a_large_mesh_of_a_request_waits_behind_few_others(lanes):
    """Those that follow are refused, so that no client waits for an hour."""
    may_end, order = occupied(lanes, Lane.SLOW), []
    coming = [lanes.put(partial(order.append, number), Rank.KNOWN, Lane.SLOW)
              for number in range(60)]
    sent = [lanes.put(partial(order.append, "sent"), Rank.SENT, Lane.SLOW) for _ in range(9)]
    may_end.set()
    with pytest.raises(RequestError, match="at most 8 large meshes"):
        sent[-1].result(60.0)
    coming[-1].result(60.0)
    assert order == ["sent"] * 8 + list(range(60))


def test_checks_wait_for_meshes_that_are_soon_built_and_no_longer(lanes):
    may_end = occupied(lanes, Lane.QUICK)
    lanes.put(lambda: None, Rank.PUBLISHED)
    later = lanes.put(lanes.waiting, Rank.LATER, Lane.CHECK)
    assert lanes.put(lambda: "asked for", Rank.KNOWN, Lane.CHECK).result(60.0) == "asked for"
    assert not later.done()
    may_end.set()
    assert later.result(60.0) == 0


def test_a_process_that_does_not_start_is_given_up(tmp_path, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text("import time\ntime.sleep(600.0)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(BatchError, match="took longer"):
        WorkerProcess(0.2)
