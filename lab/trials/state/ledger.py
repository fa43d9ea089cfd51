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

"""What clients were promised of parts, jobs, counts and plates, beside what a node
has.
"""

import time
from collections import Counter, defaultdict

import numpy as np
import yaml
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from lab.bodies import shapes
from ros_pose_stats import part_from_mesh
from tests.contract.node.harness.bags import (
    bags_of,
    files_of,
    message_of,
    on_topic,
    raw,
)
from tests.contract.node.harness.client import DONE

from ..soak.told import NOT_RECORDED, PARTS, Told

BOXES = [shapes.box(0.030, 0.010 + 0.001 * number, 0.020) for number in range(12)]
DIGESTS = [part_from_mesh(*surface).digest for surface in BOXES]
PLATE = "glass"
PROFILE = {
    "restitution": 0.4,
    "restitution_low": 0.3,
    "restitution_high": 0.5,
    "drop_height": 0.2,
    "drop_height_low": 0.1,
    "drop_height_high": 0.3,
    "plate_error": 0.03,
    "p_value": 0.5,
    "parts": ["drum"],
    "counted": 900,
    "date": "2026-11-23T12:00:00+00:00",
    "version": "1",
}
KEPT_JOBS = 900
"""The newest that are looked for; the node keeps 1000."""

SETTLED = 60.0
"""Seconds in which a start has shown all parts and counts."""


class Ledger(Told):
    """What must be there after a kill, and what may be.

    `allowed`: digests that a part may have by its name, None where it may be gone: one
    entry once that was acknowledged. `lives` of a part begin where it is taken after it
    was gone. `sent`: counts by the second of their stamp, with name, life and numbers
    by pose. `fitted`: scenes that the plate may have, None where it may have any.
    `always_written`: the state's file could be written all the time.
    """

    def __init__(self, folder, always_written=True):
        super().__init__()
        self.folder = folder
        self._always_written = always_written
        self.plates = folder.with_name(f"{folder.name}_plates.yaml")
        self.plates.write_text(yaml.safe_dump({"plates": {PLATE: PROFILE}}), "utf-8")
        self.fitted = {_scene(PROFILE)}
        self._carried = {
            f"part_{number}": part.digest for number, part in enumerate(PARTS)
        }
        self.allowed = defaultdict(
            lambda: {None},
            {name: {None, digest} for name, digest in self._carried.items()},
        )
        self.lives = Counter()
        self.sent = {}
        self.shown = Counter()
        self.ends = {}
        self._whole = {}

    def result(self, statistics):
        """A result; one that is on record says that its part is known."""
        recorded = super().result(statistics)
        if recorded:
            self.allowed[statistics.part_id] = {statistics.part_digest}
        return recorded

    def end(self, job_id, simulated, answer):
        """The end of a job, which stays as it was told."""
        super().end(job_id, simulated, answer)
        if job_id in self.ended:
            self.ends[job_id] = str(answer.statistics)

    def ask(self, name, digest):
        """A part is asked to be, or to be gone: from now on it may be."""
        if digest is not None and self.allowed[name] == {None}:
            self.lives[name] += 1
            self.shown[name] = 0
        self.allowed[name] = self.allowed[name] | {digest}

    def show(self, statistics):
        """What was counted as a result shows it; whether that is on the disk."""
        if not any(warning.code == NOT_RECORDED for warning in statistics.warnings):
            name = statistics.part_id
            self.shown[name] = max(self.shown[name], statistics.counted_parts)

    def look_at_bags(self, sealed):
        """Every bag is read whole by others and has what it had; `sealed`: none is
        written.
        """
        for bag in bags_of(self.folder):
            if self._whole.get(bag.name) is True:
                continue
            messages = raw(bag)
            earlier_messages = self._whole.get(bag.name, [])
            if messages[: len(earlier_messages)] != earlier_messages:
                self.wrong.append(
                    f"{bag.name} lost some of {len(earlier_messages)} messages"
                )
            self._whole[bag.name] = messages
            if sealed:
                self.wrong += _unlike(bag, messages)
                self._whole[bag.name] = True
                self.events["bags read whole"] += 1

    def recorded_counts(self):
        """Numbers by pose that the bags have, by part and life; each message once."""
        totals = defaultdict(Counter)
        seconds = {
            message_of(topic, data).header.stamp.sec
            for bag in bags_of(self.folder)
            for topic, data in raw(bag)
            if topic == on_topic("pose_counts")
        }
        for second in seconds & self.sent.keys():
            name, life, numbers = self.sent[second]
            totals[name, life].update(numbers)
        return totals

    def look_at(self, client, every_job=False):
        """All that was acknowledged is there, and nothing that nobody sent or
        counted.
        """
        self._look_at_parts(client)
        self._look_at_counts(client)
        self._look_at_jobs(client, every_job)
        self._look_at_plate(client)

    def _look_at_parts(self, client):
        certain = {
            name for name, allowed in self.allowed.items() if None not in allowed
        }
        end = time.monotonic() + SETTLED
        while True:
            statistics_of = {
                statistics.part_id: statistics.part_digest
                for statistics in client.good("get_statistics").statistics
            }
            if certain <= statistics_of.keys() or time.monotonic() > end:
                break
            time.sleep(0.05)
        for name in sorted(statistics_of.keys() | self.allowed.keys()):
            latched = statistics_of.get(name)
            allowed = self.allowed[name]
            if latched not in allowed:
                self.wrong.append(f"part {name} is {latched}, not one of {allowed}")
            self.allowed[name] = {latched, self._carried.get(name, latched)}
        self.events["parts looked for"] += len(certain)

    def _look_at_counts(self, client):
        """The state has what the bags have, unless it could not be written."""
        recorded = (
            self.recorded_counts() if self._always_written else defaultdict(Counter)
        )
        for name, life in self.lives.items():
            if not any(
                message[:2] == (name, life) for message in self.sent.values()
            ) or (self.allowed[name] == {None}):
                continue
            acknowledged = recorded[name, life]
            sent_total = sum(
                (
                    Counter(numbers)
                    for part_name, part_life, numbers in self.sent.values()
                    if (part_name, part_life) == (name, life)
                ),
                Counter(),
            )
            end = time.monotonic() + SETTLED
            while True:
                (statistics,) = client.good("get_statistics", part_id=name).statistics
                counts = Counter(
                    {
                        pose.index: pose.count
                        for pose in statistics.poses
                        if statistics.counted_parts
                    }
                )
                good = (
                    statistics.counted_parts == counts.total() >= self.shown[name]
                    and acknowledged <= counts <= sent_total
                )
                if good or time.monotonic() > end:
                    break
                time.sleep(0.05)
            if not good:
                self.wrong.append(
                    f"{name} (life {life}) has {statistics.counted_parts} counts, "
                    f"{dict(counts)}; the bags have {acknowledged.total()}, "
                    f"{dict(acknowledged)}; shown before were {self.shown[name]}"
                )
            self.events["totals of counts compared"] += 1
            self.show(statistics)

    def _look_at_jobs(self, client, every_job):
        listed = client.call("list_drop_simulations")
        states = {job.job_id: job.state for job in listed.jobs}
        newest = sorted(self.accepted | self.ends.keys(), key=_order)[-KEPT_JOBS:]
        for job_id in newest:
            if states.get(job_id, 0) < DONE:
                self.wrong.append(
                    f"{job_id} has state {states.get(job_id)} after a start"
                )
        known_jobs = [job_id for job_id in newest if job_id in self.ends]
        for job_id in known_jobs if every_job else known_jobs[-40:]:
            answer = client.call("get_drop_simulation", job_id=job_id)
            if not answer.success or str(answer.statistics) != self.ends[job_id]:
                self.wrong.append(f"{job_id} had another result: {answer.message}")
            self.events["results of jobs compared"] += 1

    def _look_at_plate(self, client):
        text = self.plates.read_text("utf-8")
        has = _scene(yaml.safe_load(text)["plates"][PLATE])
        if None not in self.fitted and not any(
            np.allclose(has, scene, rtol=1e-12) for scene in self.fitted
        ):
            self.wrong.append(f"plate {PLATE} is {has}, not one of {self.fitted}")
        self.fitted = {has}
        name = next(
            (name for name in self.lives if None not in self.allowed[name]), None
        )
        if name is not None:
            statistics = client.good("estimate", part_id=name, method="csae").statistics
            if statistics.restitution != has[0]:
                self.wrong.append(
                    f"answers have restitution {statistics.restitution}, "
                    f"the plate {has}"
                )


def _scene(profile):
    return profile["restitution"], profile["drop_height"]


def _order(job_id):
    run, _, number = job_id.rpartition("_")
    return run, int(number)


def _unlike(bag, expected):
    """Which of two independent readers does not find the messages that a file has."""
    faults = {}
    try:
        with AnyReader([bag]) as reader:
            faults["rosbags"] = [
                (connection.topic, bytes(data))
                for connection, _, data in reader.messages()
            ]
        faults["mcap"] = []
        for path in files_of(bag):
            with path.open("rb") as file:
                faults["mcap"] += [
                    (channel.topic, message.data)
                    for _, channel, message in make_reader(file).iter_messages(
                        log_time_order=False
                    )
                ]
    except Exception as error:
        return [f"{bag.name} cannot be read: {type(error).__name__}: {error}"]
    return [
        f"{name} reads {len(messages)} of {len(expected)} messages of {bag.name}"
        for name, messages in faults.items()
        if messages != expected
    ]
