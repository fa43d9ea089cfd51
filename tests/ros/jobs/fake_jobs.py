"""A queue of drop simulations around a simulation that the test controls."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from ros_pose_stats.records import DropScene, PoseStatistics
from ros_pose_stats.ros.jobs import JobRequest, Jobs, run

from ..harness.client import until

REQUEST = JobRequest("part", b"content", DropScene(), 100, 1, 0.0, 600.0)


def asked(**changes):
    return replace(REQUEST, **changes)


def settings(most=1000):
    return SimpleNamespace(max_queued_jobs=most, threads=lambda: 1, log_drops=False)


def part_there():
    found = Future()
    found.set_result("a part")
    return found


@dataclass
class Listener:
    """Notes what it is told; `hook(event, job)` may interfere."""

    hook: object = lambda event, job: None

    def __post_init__(self):
        self.events = []
        self.lock = threading.Lock()

    def _note(self, event, job):
        with self.lock:
            self.events.append((event, job))
        self.hook(event, job)

    def queued(self, job):
        self._note("queued", job)
        return True

    def joined(self, job):
        self._note("joined", job)
        return True

    def started(self, job):
        self._note("started", job)

    def progressed(self, job):
        self._note("progressed", job)

    def dropped(self, job, chunk):
        self._note("dropped", job)

    def ended(self, job, state):
        self._note(state.name, job)

    def told(self, job):
        self._note("told", job)

    def of(self, job):
        with self.lock:
            return [event for event, one in self.events if one is job]

    def jobs(self, event):
        with self.lock:
            return [job for one, job in self.events if one == event]


class FakeSimulation:
    """Stands in for `simulate`: one drop at a time, as many as the test lets through.

    Attributes
    ----------
    free : bool
        Whether drops need no leave.
    """

    def __init__(self, *, free):
        self.free = free
        self.failure = None
        self._leave = threading.Semaphore(0)
        self.runs = []

    def let(self, drops):
        for _ in range(drops):
            self._leave.release()

    def __call__(self, part, drops, restitution, seed, drop_height, target_error, workers, *,
                 on_progress, on_drops, should_stop, cluster_tolerance, round_sides, background,
                 judge):
        self.runs.append(seed)
        done = 0
        while done < drops and not should_stop():
            if self.free or self._leave.acquire(timeout=0.001):
                done += 1
        if self.failure is not None:
            raise self.failure
        return PoseStatistics(
            part_id="part", part_digest="", radius=1.0, method="simulation",
            restitution=restitution, drop_height=1.0, cluster_tolerance=cluster_tolerance,
            drops=done, unsettled=0, seed=seed, expected_error=0.01, plate_error=0.05,
            seconds=0.0, warnings=(), poses=())


@contextmanager
def queue_of(monkeypatch, listener, *, free=False, started=True):
    """A queue and the simulation in it; closed at the end."""
    simulation = FakeSimulation(free=free)
    monkeypatch.setattr(run, "simulate", simulation)
    failures = []
    jobs = Jobs("run", listener, failures.append)
    jobs.failures = failures
    if started:
        jobs.start()
    try:
        yield jobs, simulation
    finally:
        jobs.close("the end")


def submit(jobs, most=1000, **changes):
    return jobs.submit(asked(**changes), part_there(), settings(most))


def ended(job):
    until(job.finished.is_set, f"the end of {job.job_id}")
    return job.state


def random(seed):
    return np.random.default_rng(seed)
