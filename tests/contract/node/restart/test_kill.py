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

"""`kill -9` of the node at any moment loses nothing that a client was told."""

import random

import pytest

from ..harness.bags import assert_readable_by_others, bags_of, on_topic, raw
from ..harness.client import DONE, Client, until
from ..harness.node import NodeProcess
from ..harness.witness import Told, Witness, events, unfinished

KILLS = 8
NAMESPACE = ("-r", "__ns:=/killed")


class Killings:
    """One log directory through many short lives of the node."""

    def __init__(self, folder, domain, seed):
        self.folder = folder
        self.domain = domain
        self.chance = random.Random(seed)
        self.told = Told()
        self.ended_by_start = 0

    def recorded(self):
        """Topic and bytes of everything in all bags."""
        return [message for bag in bags_of(self.folder) for message in raw(bag)]

    def have_met_enough(self):
        """Whether there was all that a kill may come upon, which it does where it
        happens to.
        """
        return self.ended_by_start > 3 < len(self.told.ends) and any(
            topic == on_topic("drop_records") for topic, _ in self.recorded()
        )

    def live(self, answers):
        """Start, look at what the last life left, work for a number of answers, and
        die.
        """
        bags = bags_of(self.folder)
        cut_off = unfinished(events(self.recorded()))
        node = NodeProcess(
            self.folder,
            *NAMESPACE,
            log_drops=bool(self.chance.randrange(2)),
        )
        try:
            if not answers:  # somewhere in its start
                lines = self.chance.randrange(4)
                until(
                    lambda: len(node.lines) >= lines or "]: ready" in node.log,
                    "its start",
                )
                return
            client = Client(self.domain, "/killed/pose_stats")
            node.ready()
            for bag in bags:
                assert_readable_by_others(bag)
            self._look_at(client, cut_off)
            answers_before = len(self.told.answers)
            witness = Witness(client, self.told, self.chance.random())
            try:
                until(
                    lambda: len(self.told.answers) >= answers_before + answers,
                    "so many answers",
                )
                node.kill()
            finally:
                witness.stop()
        finally:
            node.kill()

    def _look_at(self, client, jobs):
        """Those that were cut off have ended."""
        for job_id in jobs:
            assert (
                client.good("get_drop_simulation", job_id=job_id).status.state >= DONE
            )
        self.ended_by_start += len(jobs)
        for job_id, state in self.told.ends.items():
            assert (
                client.good("get_drop_simulation", job_id=job_id).status.state == state
            )


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_nothing_acknowledged_is_lost(domain, tmp_path, seed):
    killings = Killings(tmp_path, domain, seed)
    number = 0
    while number < KILLS or not killings.have_met_enough():
        killings.live(0 if number % 4 == 3 else killings.chance.randrange(1, 60))
        killings.told.assert_in(killings.recorded())
        number += 1
    with (
        NodeProcess(tmp_path, *NAMESPACE) as node,
        Client(domain, "/killed/pose_stats") as client,
    ):
        node.ready()
        recorded = killings.recorded()
        lives = events(recorded)
        for job_id in unfinished(
            lives
        ):  # killed before the end of its job was on record
            assert (
                client.good("get_drop_simulation", job_id=job_id).status.state >= DONE
            )
    killings.told.assert_in(recorded)
    assert all(
        len([kind for kind in kinds if kind >= DONE]) <= 1 for kinds in lives.values()
    )
