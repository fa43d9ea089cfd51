"""The queue of drop simulations, without a node."""

from __future__ import annotations

import threading

import pytest

from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.ros.jobs import State

from ..harness.client import until
from .fake_jobs import Listener, ended, queue_of, submit


class TestOrder:
    def test_first_come_first_served(self, monkeypatch):
        with queue_of(monkeypatch, listener := Listener(), free=True) as (jobs, _):
            sent = [submit(jobs, seed=seed) for seed in range(1, 20)]
            assert {ended(job) for job in sent} == {State.DONE}
        assert listener.jobs("started") == sent
        assert all(listener.of(job) == ["queued", "started", "DONE", "told"] for job in sent)

    def test_clients_before_refinements(self, monkeypatch):
        with queue_of(monkeypatch, listener := Listener(), free=True, started=False) as (jobs, _):
            refinement = submit(jobs, seed=1, refinement=True)
            client = submit(jobs, seed=2)
            jobs.start()
            assert {ended(refinement), ended(client)} == {State.DONE}
        assert listener.jobs("started") == [client, refinement]

    def test_a_refinement_gives_way_and_begins_again(self, monkeypatch):
        with queue_of(monkeypatch, listener := Listener()) as (jobs, simulation):
            refinement = submit(jobs, drops=10, seed=1, refinement=True)
            simulation.let(4)
            until(lambda: refinement.state == State.RUNNING)
            client = submit(jobs, drops=3, seed=2)
            simulation.let(100)
            assert ended(client) == ended(refinement) == State.DONE
        assert listener.jobs("DONE") == [client, refinement]
        assert simulation.runs == [1, 2, 1]
        assert (client.drops_done, refinement.drops_done) == (3, 10)

    def test_a_client_does_not_give_way(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, simulation):
            first, second = submit(jobs, seed=1), submit(jobs, seed=2)
            simulation.let(1000)
            assert ended(first) == ended(second) == State.DONE
        assert simulation.runs == [1, 2]


class TestAcceptance:
    def test_identical_requests_in_flight_are_one_job(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, simulation):
            first = submit(jobs, seed=0)
            assert submit(jobs, seed=0) is first
            assert submit(jobs, seed=5) is not first
            simulation.let(1000)
            ended(first)
            assert submit(jobs, seed=0) is not first

    def test_a_client_does_not_join_a_refinement_but_a_refinement_joins(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, _):
            refinement = submit(jobs, refinement=True)
            client = submit(jobs)
            assert client is not refinement
            assert submit(jobs, seed=3) is submit(jobs, seed=3, refinement=True)

    def test_a_cancelled_one_is_not_joined(self, monkeypatch):
        with queue_of(monkeypatch, Listener(), started=False) as (jobs, _):
            first = submit(jobs)
            first.cancel("on its way out")
            assert submit(jobs) is not first

    def test_a_full_queue_refuses_clients_only(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, _):
            running = submit(jobs, most=2, seed=1)
            until(lambda: running.state == State.RUNNING)
            submit(jobs, most=2, seed=2)
            submit(jobs, most=2, seed=3)
            with pytest.raises(PoseStatsError, match="at most 2 simulations"):
                submit(jobs, most=2, seed=4)
            submit(jobs, most=2, seed=4, refinement=True)
            assert jobs.counts() == (2, 1)

    def test_ids_are_unique(self, monkeypatch):
        with queue_of(monkeypatch, Listener(), started=False) as (jobs, _):
            assert len({submit(jobs, seed=seed).job_id for seed in range(1, 101)}) == 100

    def test_nothing_is_accepted_by_a_closed_queue(self, monkeypatch):
        with queue_of(monkeypatch, Listener()) as (jobs, _):
            jobs.close("the node ended")
            with pytest.raises(PoseStatsError, match="running node"):
                submit(jobs)

    def test_a_job_accepted_while_the_queue_closes_ends_too(self, monkeypatch):
        """Acceptance goes to the disk, which takes time."""
        inside, closing = threading.Event(), threading.Event()

        def hook(event, job):
            if event == "queued":
                inside.set()
                assert closing.wait(60.0)

        with queue_of(monkeypatch, listener := Listener(hook)) as (jobs, _):
            found = []
            threading.Thread(target=lambda: found.append(submit(jobs))).start()
            assert inside.wait(60.0)
            ending = threading.Thread(target=jobs.close, args=("the node ended",))
            ending.start()
            until(lambda: jobs._closing)
            closing.set()
            ending.join(60.0)
            (job,) = listener.jobs("told")  # by the time that close returns
            assert job.state == State.CANCELLED
        assert listener.of(job) == ["queued", "CANCELLED", "told"]
