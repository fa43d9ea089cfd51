"""A run of drops as its caller sees it: the same whatever the timing, stopped, told about."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, shapes, simulate
from ros_pose_stats.simulation import chunks
from ros_pose_stats.statistics.error_bound import counted_bound
from tests.statistics.simulations import checkpoints

from ..bodies import random_polyhedron
from .dropping import counts

LONG = 10**8


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 3))


def same(statistics, other):
    """Equal in all but the time it took."""
    ours, theirs = statistics.as_dict(), other.as_dict()
    return {**ours, "seconds": None} == {**theirs, "seconds": None}


def no_threads_left():
    return not [thread for thread in threading.enumerate() if thread.name.startswith("drops-")]


class Stopper:
    """Stops a run once it has come to a number of drops, and keeps what it was told."""

    def __init__(self, drops):
        self.drops, self.told = drops, []

    def on_progress(self, progress):
        self.told.append(progress.drops)

    def should_stop(self):
        return bool(self.told) and self.told[-1] >= self.drops


@pytest.mark.parametrize("sampling", ["random", "lattice"])
@pytest.mark.parametrize("restitution", [0.2, 0.9])
def test_workers_do_not_matter(part, sampling, restitution):
    first, *others = (simulate(part, 1500, restitution, 7, workers=workers, sampling=sampling)
                      for workers in (1, 2, 5))
    assert all(same(first, other) for other in others)
    assert no_threads_left()


@pytest.mark.parametrize(("seconds", "first"), [(1e-9, 1), (1e-4, 3), (10.0, 1000), (0.04, 7)])
@pytest.mark.parametrize("sampling", ["random", "lattice"])
def test_chunks_do_not_matter(part, seconds, first, sampling, monkeypatch):
    usual = simulate(part, 700, 0.5, 7, sampling=sampling)
    monkeypatch.setattr(chunks, "CHUNK_SECONDS", seconds)
    monkeypatch.setattr(chunks, "FIRST_CHUNK", first)
    assert same(simulate(part, 700, 0.5, 7, workers=3, sampling=sampling), usual)


def bound_of(found):
    """What the counts keep with 90 % confidence."""
    return counted_bound(np.array([pose.count for pose in found.poses]))


@pytest.mark.parametrize("sampling", ["random", "lattice"])
@pytest.mark.parametrize("target", [0.02, 0.01])
def test_a_target_ends_a_run_at_a_checkpoint(part, target, sampling, monkeypatch):
    run = {workers: simulate(part, LONG, 0.4, 8, target_error=target, sampling=sampling,
                             workers=workers) for workers in (1, 2, 5)}
    found = run[1]
    assert same(found, run[2]) and same(found, run[5])
    looked = list(checkpoints(LONG))
    assert found.drops in looked
    assert found.expected_error <= target
    assert not any("TARGET_MISSED" in line for line in found.warnings)
    before = simulate(part, looked[looked.index(found.drops) - 1], 0.4, 8, sampling=sampling)
    if sampling == "random":
        assert bound_of(found) <= target < bound_of(before)
    assert same(simulate(part, found.drops, 0.4, 8, sampling=sampling), found)
    monkeypatch.setattr(chunks, "FIRST_CHUNK", 501)
    assert same(simulate(part, LONG, 0.4, 8, target_error=target, sampling=sampling), found)


def test_a_target_that_is_not_reached_takes_all_drops(part):
    found, plain = simulate(part, 333, 0.4, 8, target_error=1e-4), simulate(part, 333, 0.4, 8)
    assert [pose.count for pose in found.poses] == [pose.count for pose in plain.poses]
    assert found.drops == plain.drops == 333
    assert [line.split(":")[0] for line in set(found.warnings) - set(plain.warnings)] == [
        "TARGET_MISSED"]


@pytest.mark.parametrize("sampling", ["random", "lattice"])
def test_a_longer_run_begins_with_the_shorter_one(part, sampling):
    told = {}
    simulate(part, 4000, 0.6, 9, sampling=sampling,
             on_progress=lambda progress: told.update({progress.drops: progress.statistics()}))
    for drops in sorted(told)[:4]:
        assert same(told[drops], simulate(part, drops, 0.6, 9, sampling=sampling))


@pytest.mark.parametrize("workers", [1, 3])
def test_a_stop_leaves_a_contiguous_prefix(part, workers):
    stopper = Stopper(500)
    found = simulate(part, LONG, 0.6, 9, workers=workers, on_progress=stopper.on_progress,
                     should_stop=stopper.should_stop)
    assert 500 <= found.drops < LONG
    assert same(found, simulate(part, found.drops, 0.6, 9))
    assert no_threads_left()


def test_a_stop_waits_for_the_chunks_in_hand_alone():
    """Two workers: of the chunks that begin after six, only two were in hand by the stop."""
    allowed, taken, stopped = threading.Semaphore(6), [], []

    def drop(first, count):
        allowed.acquire()
        taken.append(first)
        return SimpleNamespace(pose=np.full(count, first))

    def should_stop():
        if len(taken) < 6:
            return False
        if stopped:  # asked again: the answer before has arrived
            allowed.release(2)
        stopped.append(True)
        return True

    workers = chunks.DropWorkers(drop, LONG, 2, should_stop)
    came = [outcomes.pose for outcomes in workers.outcomes_in_order()]
    assert 6 <= len(taken) <= 8
    assert [pose[0] for pose in came] == sorted(taken)
    assert [pose[0] + len(pose) for pose in came[:-1]] == [pose[0] for pose in came[1:]]


def test_a_stop_at_once(part):
    found = simulate(part, LONG, 0.6, 9, workers=2, should_stop=lambda: True)
    assert found.drops < 5000
    if found.drops == 0:
        assert np.isnan(found.expected_error)
    assert sum(counts(found)) + found.unsettled == found.drops


def test_a_stop_is_quick_for_slow_drops_too():
    """A needle's drop takes 0.1 s of a core at 0.99: sixteen of them are no chunk of 50 ms."""
    needle = part_from_mesh(*shapes.box(1.0, 0.001, 0.002))
    found = simulate(needle, 1000, 0.99, 1, workers=2, should_stop=lambda: True)
    assert found.drops < 16


def test_progress_is_told_in_the_callers_thread(part):
    told = []

    def listen(progress):
        assert threading.current_thread() is threading.main_thread()
        told.append((progress, progress.statistics()))

    found = simulate(part, 5000, 0.6, 3, on_progress=listen)
    drops = [progress.drops for progress, _ in told]
    assert drops == sorted(set(drops))
    assert (drops[0] > 0, drops[-1]) == (True, 5000)
    for progress, statistics in told:
        assert (progress.bound, progress.target_error) == (5000, 0.0)
        assert statistics.drops == progress.drops == sum(counts(statistics)) + progress.unsettled
        assert statistics.unsettled == progress.unsettled
        assert statistics.expected_error == progress.expected_error
        assert progress.rate > 0.0
        assert progress.seconds_left >= 0.0
    assert same(told[-1][1], found)
    times = [progress.seconds for progress, _ in told]
    assert times == sorted(times) and times[-1] <= found.seconds


class ListenerError(Exception):
    """Raised by a listener."""


@pytest.mark.parametrize("error", [ListenerError, KeyboardInterrupt])
@pytest.mark.parametrize("where", ["on_progress", "should_stop"])
def test_an_exception_of_the_listener_comes_through(part, where, error):
    def raise_it(*_):
        raise error

    with pytest.raises(error):
        simulate(part, LONG, 0.5, 1, workers=4, **{where: raise_it})
    assert no_threads_left()


def test_an_exception_of_a_worker_comes_through():
    def fail(first, _):
        raise ListenerError(f"at {first}")

    with pytest.raises(ListenerError, match="at "):
        list(chunks.DropWorkers(fail, 1000, 3, lambda: False).outcomes_in_order())
    assert no_threads_left()
