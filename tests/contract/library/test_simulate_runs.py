# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""A run of drops as its caller sees it: the same whatever the timing, stopped, listened
to.
"""

import os
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import part_from_mesh, simulate

LONG = 10**8


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 3))


def same(statistics, second):
    """Equal in all but the time it took."""
    ours = statistics.as_dict()
    theirs = second.as_dict()
    return {**ours, "seconds": None} == {**theirs, "seconds": None}


@pytest.fixture(autouse=True)
def _no_threads_are_left():
    threads = threading.active_count()
    yield
    assert threading.active_count() <= threads


def checkpoints(drops):
    """At which prefixes a run of at most so many drops is looked at; the last is
    `drops`.
    """
    looked = [100]
    while looked[-1] < drops:
        looked.append(looked[-1] * 3 // 2)
    return [*(n for n in looked if n < drops), drops]


@pytest.mark.parametrize("restitution", [0.2, 0.9])
def test_workers_do_not_matter(part, restitution):
    first, *others = (
        simulate(part, 1500, restitution, 7, workers=workers) for workers in (1, 2, 5)
    )
    assert all(same(first, statistics) for statistics in others)


@pytest.mark.parametrize("target", [0.02, 0.01])
def test_a_target_ends_a_run_at_a_checkpoint(part, target):
    """Where the bound is kept, whatever the workers; the one before did not keep it."""
    first, *others = (
        simulate(part, LONG, 0.4, 8, target_error=target, workers=workers)
        for workers in (1, 2, 5)
    )
    assert all(same(first, statistics) for statistics in others)
    looked = checkpoints(LONG)
    assert first.drops in looked and first.expected_error <= target
    assert not any(warning.code == "TARGET_MISSED" for warning in first.warnings)
    assert same(simulate(part, first.drops, 0.4, 8), first)
    earlier_run = simulate(
        part, looked[looked.index(first.drops) - 1], 0.4, 8, target_error=target
    )
    assert any(warning.code == "TARGET_MISSED" for warning in earlier_run.warnings)


@pytest.mark.parametrize("workers", [1, 3])
def test_a_stop_leaves_the_first_drops_of_the_run(part, workers):
    drops_done = [0]
    statistics = simulate(
        part,
        LONG,
        0.6,
        9,
        workers=workers,
        should_stop=lambda: drops_done[-1] >= 500,
        on_progress=lambda progress: drops_done.append(progress.drops),
    )
    assert 500 <= statistics.drops < LONG
    assert same(statistics, simulate(part, statistics.drops, 0.6, 9))


@pytest.mark.skipif(sys.platform != "linux", reason="threads have no priorities")
def test_workers_in_the_background_give_way_to_their_caller_whatever_its_priority(part):
    def niceness_of_caller_and_worker():
        """Of a caller that gives way itself, and of its worker once they differ."""
        caller = os.nice(12)
        threads_before = threading.enumerate()
        others = set()

        def is_seen():
            others.update(
                os.getpriority(os.PRIO_PROCESS, thread.native_id)
                for thread in threading.enumerate()
                if thread not in threads_before
            )
            return bool(others - {caller})

        simulate(part, LONG, workers=1, background=True, should_stop=is_seen)
        return caller, max(others, key=lambda niceness: abs(niceness - caller))

    with ThreadPoolExecutor(1) as thread:
        caller, worker = thread.submit(niceness_of_caller_and_worker).result()
    assert worker > caller


def test_a_stop_at_once_is_quick_for_slow_drops_too(part):
    """A needle's drop takes 0.1 s of a core at 0.99: a usual number of them is no short
    wait.
    """
    statistics = simulate(part, LONG, 0.6, 9, workers=2, should_stop=lambda: True)
    assert statistics.drops < 5000 and (
        statistics.drops > 0 or np.isnan(statistics.expected_error)
    )
    needle = part_from_mesh(*shapes.box(1.0, 0.001, 0.002))
    assert (
        simulate(needle, 1000, 0.99, 1, workers=2, should_stop=lambda: True).drops < 16
    )


def test_progress_comes_in_the_callers_thread(part):
    heard = []

    def listen(progress):
        assert threading.current_thread() is threading.main_thread()
        heard.append((progress, progress.statistics()))

    simulated = simulate(part, 5000, 0.6, 3, on_progress=listen)
    drops = [progress.drops for progress, _ in heard]
    assert drops[0] > 0 and drops[-1] == 5000
    assert all(a < b for a, b in pairwise(drops))
    for progress, statistics in heard:
        assert (progress.bound, progress.target_error) == (5000, 0.0)
        assert statistics.drops == progress.drops
        assert statistics.unsettled == progress.unsettled
        assert statistics.expected_error == progress.expected_error
        assert progress.rate > 0.0 and progress.seconds_left >= 0.0
    assert same(heard[-1][1], simulated)


def test_every_drop_is_handed_over_once_and_in_order(part):
    chunks = []
    statistics = simulate(part, 2000, 0.6, 3, workers=3, on_drops=chunks.append)
    ends = np.cumsum([len(chunk.downs) for chunk in chunks])
    assert [chunk.first for chunk in chunks] == [0, *ends[:-1]] and ends[-1] == 2000
    number = np.bincount(
        np.concatenate([chunk.outcomes.pose for chunk in chunks]),
        minlength=len(statistics.poses),
    )
    assert [pose.count for pose in statistics.poses] == [
        number[pose.index] for pose in statistics.poses
    ]


class ListenerError(Exception):
    """Raised by a listener."""


@pytest.mark.parametrize("error", [ListenerError, KeyboardInterrupt])
@pytest.mark.parametrize("listener", ["on_progress", "should_stop", "on_drops"])
def test_an_exception_of_the_listener_comes_through(part, listener, error):
    def raise_it(*_):
        raise error

    with pytest.raises(error):
        simulate(part, LONG, 0.5, 1, workers=4, **{listener: raise_it})
