"""What is kept up to a bound, and parts that are built once."""

from __future__ import annotations

from threading import Thread

import numpy as np
import pytest

from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.ros.parts import part_builder
from ros_pose_stats.ros.parts.memory import Memory

pytest.importorskip("rclpy")


def test_the_least_recently_used_goes_first():
    memory = Memory(2)
    memory.put("a", 1)
    memory.put("b", 2)
    assert memory.get("a") == 1
    memory.put("c", 3)
    assert (memory.get("a"), memory.get("b"), memory.get("c")) == (1, None, 3)


def test_weights_bound_the_sum_and_the_newest_stays():
    memory = Memory(10, weight=len)
    memory.put("a", "x" * 6)
    memory.put("b", "x" * 4)
    assert memory.get("a") is not None
    memory.put("a", "x" * 7)  # in place of the first
    assert memory.get("a") == "x" * 7 and memory.get("b") is None
    memory.put("c", "x" * 50)
    assert memory.get("a") is None and memory.get("c") == "x" * 50
    memory.clear()
    assert memory.get("c") is None


def test_threads_leave_it_whole():
    memory = Memory(8)

    def work(k):
        for i in range(2000):
            memory.put((k, i % 20), i)
            memory.get((k, (i * 7) % 20))

    threads = [Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    kept = [key for key in ((k, i) for k in range(4) for i in range(20))
            if memory.get(key) is not None]
    assert len(kept) == 8


def request(vertices, name="part"):
    from ros_pose_stats.ros.parts.part_requests import PartRequest

    fields = {"part_id": name, "vertices": vertices,
              "triangles": np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], np.uint32)}
    return PartRequest(**fields)


TETRAHEDRON = np.vstack([np.zeros(3), np.eye(3)]) * 0.01


def test_a_part_is_built_once_and_a_refusal_remembered(monkeypatch):
    calls = []
    real = part_builder.part_of
    monkeypatch.setattr(part_builder, "part_of", lambda one: calls.append(one) or real(one))
    builder = part_builder.PartBuilder()
    assert builder.build(request(TETRAHEDRON)) is builder.build(request(TETRAHEDRON.copy()))
    assert len(calls) == 1
    flat = TETRAHEDRON * [1, 1, 0]
    for _ in range(2):
        with pytest.raises(PoseStatsError):
            builder.build(request(flat))
    assert len(calls) == 2
