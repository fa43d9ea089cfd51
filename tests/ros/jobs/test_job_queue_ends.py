"""How jobs end in the queue of drop simulations, without a node."""

from __future__ import annotations

import threading
from concurrent.futures import Future

import pytest

from ros_pose_stats.errors import MeshError
from ros_pose_stats.ros.jobs import State

from ..harness.client import until
from .fake_jobs import Listener, asked, ended, queue_of, settings, submit


class TestCancel:
    def test_waiting(self, monkeypatch):
        with queue_of(monkeypatch, listener := Listener()) as (jobs, _):
            submit(jobs, seed=1)
            waiting = submit(jobs, seed=2)
            assert jobs.cancel(waiting.job_id, "no more") is waiting
            assert waiting.finished.is_set()
        assert (waiting.state, waiting.message) == (State.CANCELLED, "no more")
        assert listener.of(waiting) == ["queued", "CANCELLED", "told"]

    def test_running_keeps_what_was_done(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, simulation):
            job = submit(jobs)
            simulation.let(7)
            until(lambda: simulation._leave._value == 0 and job.state == State.RUNNING)
            jobs.cancel(job.job_id, "no more")
            assert ended(job) == State.CANCELLED
        assert job.drops_done == 7

    def test_while_the_part_is_on_its_way(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, _):
            job = jobs.submit(asked(), Future(), settings())
            until(lambda: job.state == State.RUNNING)
            jobs.cancel(job.job_id, "no more")
            assert ended(job) == State.CANCELLED
            assert job.snapshot is None

    def test_one_that_has_ended_stays_as_it_is(self, monkeypatch):
        with queue_of(monkeypatch, Listener(), free=True) as (jobs, _):
            job = submit(jobs)
            ended(job)
            assert jobs.cancel(job.job_id, "too late") is job
        assert (job.state, job.message) == (State.DONE, "")

    def test_unknown(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, _):
            assert jobs.cancel("none", "no more") is None

    def test_close_waits_for_no_run_that_does_not_listen(self, monkeypatch):
        monkeypatch.setattr("ros_pose_stats.ros.jobs.queue.LAST_SECONDS", 0.1)
        leave = threading.Event()
        with queue_of(monkeypatch, listener := Listener()) as (jobs, simulation):
            def deaf(*args, should_stop, **kwargs):
                assert leave.wait(60.0)
                return simulation(*args, should_stop=should_stop, **kwargs)

            monkeypatch.setattr("ros_pose_stats.ros.jobs.run.simulate", deaf)
            job = submit(jobs)
            until(lambda: job.state == State.RUNNING)
            assert not jobs.close("the node ended")
            assert (job.state, job.message) == (State.CANCELLED, "the node ended")
            leave.set()
            jobs._thread.join(60.0)
            assert jobs.close("again")
        assert listener.of(job) == ["queued", "started", "CANCELLED", "told"]

    def test_close_cancels_all(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, _):
            sent = [submit(jobs, seed=seed, refinement=seed > 3) for seed in range(1, 7)]
            jobs.close("the node ended")
            assert {job.state for job in sent} == {State.CANCELLED}
            assert {job.message for job in sent} == {"the node ended"}

    def test_close_meets_a_refinement_that_gives_way(self, monkeypatch):
        """The refinement has stopped for a client when the node ends."""
        with queue_of(monkeypatch, Listener()) as (jobs, simulation):
            refinement = submit(jobs, seed=1, refinement=True)
            until(lambda: refinement.state == State.RUNNING)
            leave = threading.Event()

            def slow_end(*args, should_stop, **kwargs):
                while not should_stop():
                    pass
                assert leave.wait(60.0)
                return simulation(*args, should_stop=lambda: True, **kwargs)

            simulation.let(200)
            ended(refinement)
            monkeypatch.setattr("ros_pose_stats.ros.jobs.run.simulate", slow_end)
            second = submit(jobs, seed=2, refinement=True)
            until(lambda: second.state == State.RUNNING)
            client = submit(jobs, seed=3)
            closing = threading.Thread(target=jobs.close, args=("the node ended",))
            closing.start()
            until(client.finished.is_set)
            leave.set()
            closing.join(60.0)
            assert (second.state, second.message) == (State.CANCELLED, "the node ended")


class TestFailures:
    def test_a_part_that_is_none(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, _):
            part = Future()
            part.set_exception(MeshError("a solid", "a sheet", "close it"))
            job = jobs.submit(asked(), part, settings())
            assert ended(job) == State.FAILED
        assert job.message == "expected a solid, got a sheet; close it"
        assert jobs.failures == []

    def test_an_internal_failure_ends_the_job_and_not_the_queue(self, monkeypatch):
        with queue_of(monkeypatch, Listener(), free=True) as (jobs, simulation):
            simulation.failure = ZeroDivisionError("oh")
            first = submit(jobs, seed=1)
            assert ended(first) == State.FAILED
            simulation.failure = None
            assert ended(submit(jobs, seed=2)) == State.DONE
        assert "ZeroDivisionError" in first.message and len(jobs.failures) == 1

    @pytest.mark.parametrize("event", ["started", "DONE", "told"])
    def test_a_listener_that_fails_does_not_end_the_queue(self, monkeypatch, event):
        def hook(told, job):
            if told == event and job.seed == 1:
                raise ZeroDivisionError(told)

        with queue_of(monkeypatch, Listener(hook), free=True) as (jobs, _):
            first = submit(jobs, seed=1)
            assert ended(first).ended
            assert ended(submit(jobs, seed=2)) == State.DONE
            until(lambda: jobs.running is None)
        assert first.state == (State.FAILED if event == "started" else State.DONE)
        assert jobs.failures

    def test_a_listener_that_always_fails(self, monkeypatch):
        def hook(event, job):
            if event not in ("queued", "started"):
                raise ZeroDivisionError(event)

        with queue_of(monkeypatch, Listener(hook), free=True) as (jobs, _):
            assert ended(submit(jobs, seed=1)).ended
            assert ended(submit(jobs, seed=2)).ended


class TestMemory:
    def test_the_newest_finished_jobs_are_kept(self, monkeypatch):
        monkeypatch.setattr("ros_pose_stats.ros.jobs.queue.KEPT", 10)
        with queue_of(monkeypatch, Listener(), free=True) as (jobs, _):
            sent = [submit(jobs, seed=seed) for seed in range(1, 31)]
            ended(sent[-1])
            until(lambda: len(jobs.all()) == 10)
            assert jobs.all() == sent[-10:]

    def test_the_newest_are_those_that_ended_last(self, monkeypatch):
        """A long one is not forgotten at its end because many came and went meanwhile."""
        monkeypatch.setattr("ros_pose_stats.ros.jobs.queue.KEPT", 3)
        with queue_of(monkeypatch, Listener()) as (jobs, simulation):
            long = submit(jobs, seed=1)
            for seed in range(2, 10):
                jobs.cancel(submit(jobs, seed=seed).job_id, "no more")
            simulation.let(100)
            assert ended(long) == State.DONE
            assert jobs.get(long.job_id) is long
            assert len(jobs.all()) == 3
