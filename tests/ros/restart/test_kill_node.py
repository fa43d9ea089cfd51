"""`kill -9` of the node at any moment loses nothing that a client was told."""

from __future__ import annotations

import random
import time

import pytest

from ros_pose_stats.recording.finished import is_finished
from ros_pose_stats.recording.run_names import bag_files, runs

from ..harness.cell import QuickClient
from ..harness.client import CANCELLED
from ..harness.node import NodeProcess
from ..harness.readers import assert_readable_by_others, message_of, on_topic, raw
from ..harness.witness import Told, Witness, events, unfinished

pytestmark = pytest.mark.long

KILLS = 9
NAMESPACE = ("-r", "__ns:=/killed")
SHARE_IN_START = 0.2
START_SECONDS = 2.0
LOAD_SECONDS = 1.2
ON_ITS_WAY = 0.03
"""Seconds that an answer may still take after the node has died."""

UDP_ONLY = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
"""A killed process would leave its shared memory behind."""


class Killings:
    """One log directory through many short lives of the node."""

    def __init__(self, log_directory, client_of, seed):
        self.log_directory = log_directory
        self.client_of = client_of
        self.chance = random.Random(seed)
        self.told = Told()
        self.cancelled = 0
        self._bags = {}

    def recorded(self):
        """Everything in all bags, those that are finished read once."""
        found = []
        for bag in runs(self.log_directory):
            messages = self._bags[bag] if bag in self._bags else raw(bag)
            if is_finished(bag):
                self._bags[bag] = messages
            found += messages
        return found

    def live(self):
        """Start, look what the last life left, work, and die; the node's log."""
        left = [bag for bag in runs(self.log_directory)
                if bag_files(bag) and not is_finished(bag)]
        before = self.recorded()
        node = NodeProcess(self.log_directory, *NAMESPACE, environment=UDP_ONLY,
                           log_drops=self.chance.choice(("true", "false")))
        try:
            if self.chance.random() < SHARE_IN_START:
                time.sleep(START_SECONDS * self.chance.random())
            else:
                self._work(node, left, before)
        finally:
            node.kill()
        time.sleep(ON_ITS_WAY)

    def _work(self, node, left, before):
        client = self.client_of()
        node.ready()
        for bag in left:
            assert is_finished(bag)
            assert bag.name in node.log
            assert_readable_by_others(bag)
        self._look_at_cancelled(client, unfinished(events(before)))
        witness = Witness(client, self.told, self.chance.random())
        try:
            time.sleep(LOAD_SECONDS * self.chance.random())
            node.kill()
            time.sleep(ON_ITS_WAY)
        finally:
            witness.stop()

    def _look_at_cancelled(self, client, jobs):
        listed = client.call("list_drop_simulations")
        states = dict(zip(listed.job_id, listed.state, strict=True))
        for job_id in jobs:
            answer = client.good("get_drop_simulation", job_id=job_id)
            assert (answer.state, states[job_id]) == (CANCELLED, CANCELLED)
            assert "the node ended" in answer.message
        self.cancelled += len(jobs)


@pytest.fixture
def client(domain):
    return lambda: QuickClient(domain, "/killed/pose_stats")


@pytest.mark.parametrize("seed", [1, 2])
def test_nothing_acknowledged_is_lost(client, tmp_path, seed):
    killings = Killings(tmp_path, client, seed)
    for _ in range(KILLS):
        killings.live()
        killings.told.assert_in(killings.recorded())
    with NodeProcess(tmp_path, *NAMESPACE) as node:
        node.ready()
    recorded = killings.recorded()
    killings.told.assert_in(recorded)
    found = events(recorded)
    assert unfinished(found) == set()
    ends = [[kind for kind in kinds if kind >= 3] for kinds in found.values()]
    assert all(len(kinds) == 1 for kinds in ends)
    assert len(killings.told.answers) > KILLS and len(killings.told.ends) > 5
    assert killings.cancelled > 5
    assert any(message_of(topic, data).pose_index for topic, data in recorded
               if topic == on_topic("drop_records"))
