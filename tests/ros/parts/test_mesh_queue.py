"""The queue of meshes on their way to become parts, without a node."""

from __future__ import annotations

import threading

import pytest

from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.mesh.patience import TakesLongError
from ros_pose_stats.ros.parts.lanes import Pace
from ros_pose_stats.ros.parts.mesh_queue import MOST_WAITING, MeshQueue

PATIENCE = 60.0


@pytest.fixture
def queue():
    found = MeshQueue(lambda: 250)
    yield found
    found.close()


class Gate:
    """A task that holds up the queue until the test opens it."""

    def __init__(self, queue, **options):
        self.entered, self._opened = threading.Event(), threading.Event()
        self.future = queue.put(self._wait, 0, **options)

    def _wait(self):
        self.entered.set()
        assert self._opened.wait(PATIENCE)

    def open(self):
        self._opened.set()


def blocked_put(queue, size):
    """Put a task from another thread; set once it was taken in."""
    done = threading.Event()

    def put():
        queue.put(lambda: None, size)
        done.set()

    threading.Thread(target=put, daemon=True).start()
    return done


def started_gate(queue, **options):
    """A gate in a queue that has begun to work."""
    if not queue._threads[0].is_alive():
        queue.start()
    found = Gate(queue, **options)
    assert found.entered.wait(PATIENCE)
    return found


@pytest.fixture
def gate(queue):
    found = started_gate(queue)
    yield found
    found.open()


class TestOrder:
    def test_results_and_failures_go_to_who_asked(self, queue):
        queue.start()
        good, bad = queue.put(lambda: 7, 1), queue.put(lambda: 1 / 0, 1)
        assert good.result(PATIENCE) == 7
        assert isinstance(bad.exception(PATIENCE), ZeroDivisionError)
        assert queue.put(lambda: 8, 1).result(PATIENCE) == 8

    def test_requests_first_and_what_can_wait_last(self, queue, gate):
        done = []
        futures = [queue.put_later(lambda: done.append("later")),
                   queue.put(lambda: done.append("mesh"), 1),
                   queue.put(lambda: done.append("mesh 2"), 1),
                   queue.put_first(lambda: done.append("request"))]
        gate.open()
        for future in futures:
            future.result(PATIENCE)
        assert done == ["request", "mesh", "mesh 2", "later"]


class TestLanes:
    def test_a_large_mesh_holds_up_no_small_one(self, queue):
        slow = started_gate(queue, large=True)
        assert queue.put(lambda: 1, 1).result(PATIENCE) == 1
        assert queue.put_first(lambda: 2).result(PATIENCE) == 2
        behind = queue.put(lambda: 3, 1, large=True)
        assert not behind.done()
        slow.open()
        assert behind.result(PATIENCE) == 3

    def test_a_small_mesh_after_a_large_one_of_its_name(self, queue):
        slow = started_gate(queue, large=True, part_id="a")
        later = queue.put(lambda: 1, 1, "a")
        urgent = queue.put_first(lambda: 2, 1, "a")
        assert queue.put(lambda: 3, 1, "b").result(PATIENCE) == 3
        assert not later.done() and not urgent.done()
        slow.open()
        assert later.result(PATIENCE) == 1
        assert urgent.result(PATIENCE) == 2
        assert queue.put(lambda: 4, 1, "a").result(PATIENCE) == 4

    def test_a_large_mesh_after_a_small_one_of_its_name(self, queue):
        quick = started_gate(queue, part_id="a")
        later = queue.put(lambda: 1, 1, "a", large=True)
        urgent = queue.put_first(lambda: 2, 1, "a", large=True)
        with pytest.raises(TimeoutError):
            urgent.result(0.1)
        quick.open()
        assert later.result(PATIENCE) == 1
        assert urgent.result(PATIENCE) == 2

    def test_too_many_large_ones_are_refused(self, queue):
        slow = started_gate(queue, large=True)
        queue.put(lambda: None, 400, large=True)
        refused = queue.put(lambda: None, 400, large=True)
        with pytest.raises(PoseStatsError, match="large meshes"):
            refused.result(PATIENCE)
        assert queue.put(lambda: 1, 600).result(PATIENCE) == 1
        slow.open()


class Long:
    """A task that only the slow lane has the time for; which lanes it has been in."""

    def __init__(self, queue, done, name=""):
        self._queue, self._done, self._name = queue, done, name
        self.paces = []

    def __call__(self):
        self.paces.append(self._queue.pace())
        if self.paces[-1] is not Pace.SLOW:
            raise TakesLongError
        self._done.append(self._name)


class TestTime:
    def test_what_takes_long_goes_on_to_the_next_lane(self, queue):
        queue.start()
        long = Long(queue, [])
        queue.put_first(long, 1).result(PATIENCE)
        assert long.paces == [Pace.QUICK, Pace.MIDDLE, Pace.SLOW]
        long = Long(queue, [])
        queue.put(long, 1, large=True).result(PATIENCE)
        assert long.paces == [Pace.MIDDLE, Pace.SLOW]
        assert queue.put(lambda: 1, 900).result(PATIENCE) == 1  # nothing is held of them

    def test_a_medium_mesh_does_not_wait_for_slow_ones(self, queue):
        opened = threading.Event()

        def slow():
            if queue.pace() is not Pace.SLOW:
                raise TakesLongError
            assert opened.wait(PATIENCE)

        queue.start()
        waiting = [queue.put_first(slow, 1, large=True) for _ in range(8)]
        assert queue.put(lambda: 1, 1, large=True).result(PATIENCE) == 1
        assert not any(one.done() for one in waiting)
        opened.set()

    def test_the_later_one_of_a_name_is_done_last(self, queue, gate):
        done = []
        long = Long(queue, done, "long")
        coming = [queue.put(long, 1, "a"),
                  queue.put(lambda: done.append("small"), 1, "a"),
                  queue.put(lambda: done.append("large"), 1, "a", large=True),
                  queue.put(lambda: done.append("last"), 1, "a")]
        gate.open()
        for one in coming:
            one.result(PATIENCE)
        assert done == ["long", "small", "large", "last"]

    def test_without_end_it_fails(self, queue):
        def never():
            raise TakesLongError

        queue.start()
        assert isinstance(queue.put(never, 1).exception(PATIENCE), TakesLongError)


class TestBounds:
    def test_all_that_waits_has_one_bound_in_bytes(self, queue, gate):
        queue.put(lambda: None, 300)
        queue.put(lambda: None, 300, large=True)
        queue.put_first(lambda: None, 300)
        with pytest.raises(PoseStatsError) as refusal:
            queue.put_first(lambda: None, 150)
        assert str(refusal.value) == (
            "expected at most 1000 bytes of meshes waiting (4 times max_mesh_bytes), got 150 "
            "bytes more than the 900 that wait; send it again once they are done, or decimate it")
        queue.put_first(lambda: None, 100)

    def test_large_ones_leave_room_for_small_ones(self, queue, gate):
        slow = started_gate(queue, large=True)
        queue.put_first(lambda: None, 500, large=True)
        with pytest.raises(PoseStatsError, match="500 bytes of large meshes"):
            queue.put_first(lambda: None, 1, large=True)
        queue.put_first(lambda: None, 500)
        slow.open()

    def test_bytes(self, queue, gate):
        queue.put(lambda: None, 600)
        assert not (second := blocked_put(queue, 600)).wait(0.1)
        gate.open()
        assert second.wait(PATIENCE)

    def test_a_task_larger_than_the_bound_waits_alone(self, queue, gate):
        assert blocked_put(queue, 10**6).wait(PATIENCE)
        assert not blocked_put(queue, 1).wait(0.1)

    def test_number(self, queue, gate):
        for _ in range(MOST_WAITING):
            queue.put(lambda: None, 1)
        assert not blocked_put(queue, 1).wait(0.1)
        for _ in range(10 * MOST_WAITING):
            queue.put_later(lambda: None)  # never waits
        assert queue.waiting() == 11 * MOST_WAITING

    def test_requests_are_refused_rather_than_kept_waiting(self, queue, gate):
        for _ in range(MOST_WAITING):
            queue.put_first(lambda: None)
        with pytest.raises(PoseStatsError, match="waiting"):
            queue.put_first(lambda: None)


class TestClose:
    def test_drops_what_waits_and_lets_go_of_who_waits(self, queue, gate):
        waiting = [queue.put(lambda: None, 600), queue.put_later(lambda: None),
                   queue.put_first(lambda: None)]
        blocked = blocked_put(queue, 600)
        closing = threading.Thread(target=queue.close)
        closing.start()
        assert blocked.wait(PATIENCE)
        gate.open()
        closing.join(PATIENCE)
        assert all(future.cancelled() for future in waiting)
        assert gate.future.result(PATIENCE) is None

    def test_nobody_waits_for_what_takes_long(self, queue, gate):
        assert not queue.close()
        assert gate.future.cancelled()
        gate.open()

    def test_nothing_is_taken_in_afterwards(self, queue):
        queue.start()
        queue.close()
        assert queue.put(lambda: None, 1).cancelled()
        assert queue.put_later(lambda: None).cancelled()

    def test_one_that_never_began(self, queue):
        future = queue.put(lambda: None, 1)
        queue.close()
        assert future.cancelled()
