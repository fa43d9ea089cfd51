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

"""What the node says of its own health on /diagnostics."""

import os
import platform
import time
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from .harness.cell import Health, MeshPublisher, latched
from .harness.client import until
from .harness.goals import Goals
from .harness.jobs import LONG, known_part, running_with_results, start
from .harness.parts import WEDGE, flat, new_id


def processor_seconds(pid):
    """User and system time of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_five_lines_once_a_second_and_an_idle_node_hardly_computes(cell, shared_node):
    """A loop that waits for nothing would take a second a second, here it is a
    fiftieth.
    """
    began = time.time()
    heard = []
    health = Health(cell)
    known_part(cell)

    def take(message):
        if message.status[0].name.startswith("pose_stats: "):
            heard.append((message, processor_seconds(shared_node.process.pid)))

    subscription = cell.subscribe(DiagnosticArray, "/diagnostics", take)
    until(lambda: len(heard) >= 3)
    cell.node.destroy_subscription(subscription)
    stamps = [
        message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        for message, _ in heard
    ]
    for message, _ in heard:
        assert {line.hardware_id for line in message.status} == {platform.node()}
        assert [line.name for line in message.status] == [
            f"pose_stats: {name}"
            for name in ("parts", "counts", "jobs", "flips", "recording")
        ]
    assert began < stamps[-1] < time.time() and stamps == sorted(stamps)
    assert heard[-1][1] - heard[0][1] < 0.6 * (len(heard) - 1)
    line, values = health.latest("jobs")
    assert (line.message, values["queued"], values["refinements queued"]) == (
        "idle",
        "0",
        "0",
    )
    assert health.latest("flips")[0].message == "idle"
    line, values = health.latest("recording")
    assert (line.level, line.message) == (DiagnosticStatus.OK, "recording")
    assert values["bag"].startswith(str(shared_node.log_directory))
    assert int(values["bytes written"]) > 0 and int(values["bytes left"]) > 0
    assert values["messages not recorded"] == "0" and values["last repair"] == "none"


def test_queue_running_job_and_flips(cell):
    goals = Goals(cell, "simulate_flips")
    health = Health(cell)
    part_id = known_part(cell)
    jobs = [start(cell, part_id, LONG, seed=seed) for seed in (1, 2, 3)]
    messages = [
        goals.send(part_id=part_id, kick_height=0.012, drops=500_000, seed=seed)
        for seed in (1, 2)
    ]
    running_with_results(cell, jobs[0])
    line, values = health.eventually(
        "jobs",
        lambda _, values: (values["running"], values["queued"]) == (jobs[0], "2"),
    )
    assert values["queue bound"] == "16" and int(values["threads"]) > 0
    assert line.message.startswith(f"{jobs[0]}: ") and f"'{part_id}'" in line.message
    assert line.level == DiagnosticStatus.OK
    line, values = health.eventually(
        "flips", lambda _, values: values["goals queued"] == "1"
    )
    assert (
        values["running"]
        and values["plans queued"] == "0"
        and f"'{part_id}'" in line.message
    )
    for goal in reversed(messages):
        goal.cancel()
        goal.result()
    goals.close()


def test_what_is_refused_or_comes_in_floods_is_a_warning(tuned, node):
    publisher = MeshPublisher(tuned).matched()
    health = Health(tuned)
    part_id = new_id()
    refused_before = int(health.line("parts")[1]["refused"])
    publisher.publish(flat((0.0 * WEDGE[0], WEDGE[1]), "crushed"))
    for number in range(
        35, 141, 35
    ):  # two publishers of one name, not too fast for the node
        publisher.publish(
            *[
                flat(((1.0 + k % 2) * WEDGE[0], WEDGE[1]), part_id)
                for k in range(number, number + 35)
            ]
        )
        until(lambda n=number: latched(tuned, part_id).revision >= n)
    line, values = health.eventually(
        "parts", lambda _, values: part_id in values["floods"]
    )
    assert line.level == DiagnosticStatus.WARN and "crushed" in line.message
    assert (
        int(values["refused"]) == refused_before + 1
    )  # though two subscriptions had it
    flood = f"a flood: more than 60 of meshes of part '{part_id}'"
    assert node.says(flood).log.count(flood) == 1
    assert {"parts", "meshes waiting", "overrun"} <= values.keys()
