"""Hundreds of random operations on the queue from several threads: every job ends, once."""

from __future__ import annotations

import threading
from contextlib import suppress

import pytest

from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.ros.jobs import State

from .fake_jobs import Listener, queue_of, random, submit

THREADS, OPERATIONS = 4, 150
ENDS = {State.DONE.name, State.CANCELLED.name, State.FAILED.name}


def worked(jobs, seed, mine):
    """Submit, cancel and look, at random."""
    dice = random(seed)
    for _ in range(OPERATIONS):
        choice = dice.random()
        if choice < 0.6:
            with suppress(PoseStatsError):  # a full queue
                mine.append(submit(jobs, most=20, drops=int(dice.integers(1, 300)),
                                   seed=int(dice.integers(0, 40)),
                                   refinement=bool(dice.random() < 0.3)))
        elif choice < 0.9 and mine:
            jobs.cancel(mine[dice.integers(len(mine))].job_id, "no more")
        else:
            assert all(job.state in State for job in jobs.all())


@pytest.mark.parametrize("seed", range(4))
def test_every_job_ends_once(monkeypatch, seed):
    listener, found = Listener(), [[] for _ in range(THREADS)]
    with queue_of(monkeypatch, listener, free=True) as (jobs, _):
        threads = [threading.Thread(target=worked, args=(jobs, 10 * seed + place, mine))
                   for place, mine in enumerate(found)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert jobs.failures == []
    accepted = {job for mine in found for job in mine}
    assert accepted == set(listener.jobs("queued"))
    for job in accepted:
        events = listener.of(job)
        assert job.state.ended and job.finished.is_set()
        assert [event for event in events if event in ENDS] == [job.state.name]
        assert events[0] == "queued" and events[-1] == "told"
        if job.state is State.DONE:
            assert job.drops_done == job.request.drops
