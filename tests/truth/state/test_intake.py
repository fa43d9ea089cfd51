"""What takes long in building a part of an earlier run holds up nothing quick."""

from __future__ import annotations

import threading

import pytest

from ros_pose_stats import part_from_mesh
from ros_pose_stats.ros.parts.intake import LARGE_BYTES, Intake
from ros_pose_stats.ros.parts.known_part import NODE_SCENE, KnownPart, PartSource
from ros_pose_stats.ros.parts.mesh_queue import MeshQueue

TETRAHEDRON = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
               [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


@pytest.fixture
def lanes():
    queue = MeshQueue(lambda: 2**20)
    queue.start()
    yield queue
    queue.close()


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
        assert lanes.put_first(lambda: "quick").result(60.0) == "quick"
        assert not large.done()
    finally:
        may_end.set()
    assert large.result(60.0) is known and known.source.is_built
