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

"""What clients were told, beside the library and beside the bags."""

import threading
from collections import Counter, defaultdict
from functools import cache
from typing import NamedTuple

import numpy as np
from ros_pose_stats_msgs.msg import JobStatus

from lab.bodies.samples import random_polyhedron
from ros_pose_stats import estimate, part_from_mesh, simulate
from tests.contract.node.harness.bags import bags_of, message_of, on_topic, raw

METHODS = ("combined", "csae", "area")
RESTITUTIONS = (0.2, 0.5)
NOT_RECORDED = "NOT_RECORDED"
ENDS = {JobStatus.DONE, JobStatus.CANCELLED, JobStatus.FAILED}
SEVERAL = 5
"""Faults of a kind that are spelt out."""

SURFACES = [
    (0.02 * vertices, triangles)
    for vertices, triangles in (
        random_polyhedron(8 + number, number + 1) for number in range(10)
    )
]
PARTS = [part_from_mesh(*surface) for surface in SURFACES]


class Simulated(NamedTuple):
    """A simulation that a client was told of."""

    body: int
    restitution: float
    seed: int
    asked: int
    drops: int
    drop_height: float | None = None


class Told:
    """Everything that was asked and told, and whatever must not be.

    Results are kept under what they say, but for those that said NOT_RECORDED;
    estimates and simulations with what is to be compared with the library.
    """

    def __init__(self):
        self._lock = threading.Lock()
        self.wrong = []
        self.seconds = defaultdict(list)
        self.events = Counter()
        self.answers = set()
        self.accepted = set()
        self.ended = set()
        self.estimates = []
        self.simulations = {}

    def called(self, name, seconds):
        """A call was answered."""
        self.seconds[name].append(seconds)

    def refusal(self, message):
        """A refusal, which must give its reason in one line."""
        if not message.isprintable() or "internal failure" in message or not message:
            self.wrong.append(f"refused with {message!a}")
        with self._lock:
            self.events["refused"] += 1

    def result(self, statistics):
        """A result; whether it is acknowledged."""
        recorded = not any(
            warning.code == NOT_RECORDED for warning in statistics.warnings
        )
        with self._lock:
            self.events["not recorded, and said so"] += not recorded
            if recorded:
                self.answers.add(key_of(statistics))
        return recorded

    def end(self, job_id, simulated, answer):
        """What came of a job; one that was cancelled at once has nothing to show."""
        statistics = answer.statistics
        if (
            self.result(statistics)
            if statistics.drops
            else NOT_RECORDED not in answer.message
        ):
            with self._lock:
                self.ended.add(job_id)
        if statistics.drops:
            key = simulated._replace(
                drops=statistics.drops, drop_height=statistics.drop_height
            )
            counts = {pose.index: pose.count for pose in statistics.poses if pose.count}
            if self.simulations.setdefault(key, counts) != counts:
                self.wrong.append(f"{key} gave other counts before")
            with self._lock:
                self.events["simulations"] += 1

    def unlike_the_library(self):
        """Estimates and simulations whose numbers are not the library's."""
        bad = [
            f"estimate {key}"
            for key, probabilities in self.estimates
            if probabilities != estimated(*key)
        ]
        runs = defaultdict(list)
        for key in self.simulations:
            runs[key.body, key.restitution, key.seed, key.drop_height].append(key)
        for run, keys in runs.items():
            counts = prefixes(*run, sorted({key.drops for key in keys}))
            bad += [
                f"{key}" for key in keys if self.simulations[key] != counts[key.drops]
            ]
        return bad

    def not_in(self, folders):
        """Results, acceptances and ends that are in no bag, and jobs that ended
        twice.
        """
        answers = set()
        events = defaultdict(list)
        for bag in (bag for folder in folders for bag in bags_of(folder)):
            for topic, data in raw(bag):
                self.events["messages in bags"] += 1
                if topic == on_topic("answers"):
                    answers.add(key_of(message_of(topic, data)))
                elif topic == on_topic("job_events"):
                    event = message_of(topic, data)
                    events[event.status.job_id].append(event.status.state)
        ended = {job: len(ENDS.intersection(kinds)) for job, kinds in events.items()}
        return [
            *(f"result {key}" for key in self.answers - answers),
            *(f"acceptance of {job}" for job in self.accepted - events.keys()),
            *(f"end of {job}" for job in self.ended if not ended.get(job)),
            *(f"one end only of {job}" for job, ends in ended.items() if ends > 1),
        ]


def key_of(statistics):
    """What a result is known by: its place among the others, and what it says."""
    stamp = statistics.header.stamp
    return (
        statistics.part_id,
        statistics.part_digest,
        statistics.method,
        statistics.revision,
        stamp.sec,
        stamp.nanosec,
        statistics.job_id,
        statistics.drops,
        statistics.seed,
        tuple(
            (pose.index, pose.count, repr(pose.probability))
            for pose in statistics.poses
        ),
    )


@cache
def estimated(number, method, restitution):
    """Probabilities by pose."""
    answer = estimate(PARTS[number], method, restitution=restitution)
    return {pose.index: pose.probability for pose in answer.poses}


def prefixes(number, restitution, seed, drop_height, sizes):
    """Counts of the first so many drops of one run, by number: drop k depends on seed
    and k.
    """
    chunks = []
    simulate(
        PARTS[number],
        max(sizes),
        restitution,
        seed,
        drop_height,
        workers=1,
        on_drops=lambda chunk: chunks.append(chunk.outcomes.pose.copy()),
    )
    row = np.concatenate(chunks)
    counts = {}
    for size in sizes:
        values, numbers = np.unique(row[:size][row[:size] >= 0], return_counts=True)
        counts[size] = dict(zip(values.tolist(), numbers.tolist(), strict=True))
    return counts
