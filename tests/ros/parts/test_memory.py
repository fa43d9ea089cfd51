"""What is kept up to a bound."""

from __future__ import annotations

from threading import Thread

import pytest

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
