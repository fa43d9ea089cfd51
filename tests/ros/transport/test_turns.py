"""Many requests of one client, and what others wait for meanwhile."""

from __future__ import annotations

import signal
import threading

import pytest

from ros_pose_stats.ros.transport.turns import MOST_WAITING, Turns

from ..harness.cell import QuickClient
from ..harness.client import until, wait_for
from ..harness.jobs import known_part

PATIENCE = 60.0
MANY = 600


@pytest.fixture
def turns():
    failures = []
    found = Turns(failures.append)
    yield found
    found.close(PATIENCE)
    assert failures == []


class Gates:
    """Requests that hold up all the threads until the test opens them."""

    def __init__(self, turns, monkeypatch):
        monkeypatch.setattr("ros_pose_stats.ros.transport.turns.THREADS", 1)
        self._opened, entered = threading.Event(), threading.Event()
        turns.put(10**6, lambda: (entered.set(), self._opened.wait(PATIENCE)))
        assert entered.wait(PATIENCE)

    def open(self):
        self._opened.set()


class TestOrder:
    def test_clients_in_turn_and_each_in_its_order(self, turns, monkeypatch):
        gates, done = Gates(turns, monkeypatch), []
        for number in (*range(1, 5), 70, 71, 900):
            turns.put(number, lambda number=number: done.append(number))
        gates.open()
        until(lambda: len(done) == 7)
        assert done == [1, 70, 900, 2, 71, 3, 4]

    def test_a_failure_is_told_and_ends_nothing(self):
        told, done = [], []
        turns = Turns(told.append)
        turns.put(1, lambda: 1 / 0)
        turns.put(2, lambda: done.append(2))
        until(lambda: done and told)
        assert turns.close(PATIENCE)
        assert "ZeroDivisionError" in told[0]


class TestBounds:
    def test_room(self, turns, monkeypatch):
        gates = Gates(turns, monkeypatch)
        for number in range(MOST_WAITING):
            assert turns.has_room()
            turns.put(number, lambda: None)
        assert not turns.has_room()
        gates.open()
        until(turns.has_room)

    def test_all_that_wait_are_answered_at_the_end(self, turns, monkeypatch):
        gates, done = Gates(turns, monkeypatch), []
        for number in range(10):
            turns.put(number, lambda: done.append(1))
        assert not turns.close(0.01)
        gates.open()
        assert turns.close(PATIENCE)
        assert len(done) == 10
        assert not turns.has_room()


class TestNode:
    def test_another_client_does_not_wait_for_all_of_them(self, domain, cell):
        """The other one too keeps many answers: each client is sent those to all others."""
        part_id = known_part(cell)
        with QuickClient(domain) as greedy, QuickClient(domain) as other:
            greedy.good("estimate", part_id=part_id)
            sent = [greedy.send("estimate", part_id=part_id, restitution=0.3 + 1e-4 * number)
                    for number in range(MANY)]
            until(lambda: any(one.done() for one in sent))
            for _ in range(5):
                other.good("estimate", part_id=part_id)
            assert not all(one.done() for one in sent)
            assert all(wait_for(one).success for one in sent)

    def test_all_are_told_when_the_node_ends(self, node_of, other_domain):
        node = node_of().ready()
        with QuickClient(other_domain) as client:
            part_id = known_part(client)
            sent = [client.send("estimate", part_id=part_id, restitution=0.3 + 1e-4 * number)
                    for number in range(MANY // 3)]
            until(lambda: any(one.done() for one in sent))
            node.stop(signal.SIGTERM)
            answers = [wait_for(one) for one in sent]
        refused = [one.message for one in answers if not one.success]
        assert set(refused) == {
            "expected a running node, got one that is ending; start it again"}
