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

"""A node in a process of its own to try things on, and what its process says of
itself.
"""

import atexit
import os
import signal
import tempfile
import time
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from pathlib import Path

from rclpy.logging import LoggingSeverity, set_logger_level

from ros_pose_stats import estimate, simulate
from tests.contract.node.harness import parts
from tests.contract.node.harness.cell import (  # noqa: F401 - for the trials
    Client,
    Health,
    MeshPublisher,
    cell_of,
    latched,
)
from tests.contract.node.harness.domains import own_domain
from tests.contract.node.harness.jobs import finished, start
from tests.contract.node.harness.parts import WEDGE, flat, new_id

MEGABYTE = 2**20
ENDINGS: list[float] = []
"""Seconds that nodes of this program took to end after SIGTERM."""

LONGEST_LINE = 2500
"""Characters of a refusal; it may name eight known parts."""


@lru_cache(maxsize=1)
def domain():
    """A domain for nodes of this program alone, their logs in a folder that goes.

    The program has it until its end, also where `tried_node` takes another one.
    """
    stack = ExitStack()
    atexit.register(stack.close)
    os.environ["ROS_LOG_DIR"] = stack.enter_context(tempfile.TemporaryDirectory())
    number = stack.enter_context(own_domain())
    os.environ["ROS_DOMAIN_ID"] = str(number)
    for name in (
        "planner",
        "rcl.logging_rosout",
    ):  # whom latched meshes do not reach, and such
        set_logger_level(name, LoggingSeverity.ERROR)
    return number


@contextmanager
def tried_node(bags, **values):
    """A ready node in a namespace of its own, and a client of it; its log must be
    sound.

    Each has a domain of its own: a publisher would be matched with subscriptions of a
    node that has ended, and what killed neighbours had of the memory that Fast DDS
    shares stays taken.
    """
    domain.cache_clear()
    with cell_of(domain(), bags, "tried", **values) as (node, client):
        yield node, client
        if node.process.poll() is None:
            end(node)
        node.assert_sound()
        strange = [ascii(line) for line in node.lines if not line.isprintable()]
        assert not strange, f"lines that no terminal shows: {strange[:3]}"


def end(node):
    """End a node by SIGTERM; seconds until it has, with status 0."""
    begin = time.monotonic()
    node.send(signal.SIGTERM)
    status_at_end = node.ended()
    seconds = time.monotonic() - begin
    assert status_at_end == 0, f"it ended with status {status_at_end}"
    ENDINGS.append(seconds)
    return seconds


def status(node, name):
    """A number of /proc: `VmRSS` and `VmHWM` in bytes, `Threads`."""
    text = Path(f"/proc/{node.process.pid}/status").read_text("utf-8")
    value, *unit = text.partition(f"{name}:")[2].partition("\n")[0].split()
    return int(value) * (1024 if unit else 1)


def forget_peak(node):
    """Let `VmHWM` begin anew."""
    Path(f"/proc/{node.process.pid}/clear_refs").write_text("5", "utf-8")


def assert_line(text):
    """A line that a terminal can show, and none of an internal failure."""
    assert text.isprintable(), ascii(text)
    assert len(text) <= LONGEST_LINE, text
    assert "internal failure" not in text, text


def assert_serves(client):
    """An estimate, a simulation and a published mesh, all as the library has them."""
    part_id = new_id()
    part = parts.library_part(WEDGE, part_id)
    answer = client.good(
        "estimate", part=flat(WEDGE, part_id), method="csae"
    ).statistics
    assert parts.probabilities(answer.poses) == parts.probabilities(
        estimate(part, "csae").poses
    )
    job = finished(client, start(client, part_id, 50, seed=5)).statistics
    assert parts.counts(job.poses) == parts.counts(simulate(part, 50, seed=5).poses)
    published_id = new_id()
    MeshPublisher(client).matched().publish(flat(WEDGE, published_id))
    assert latched(client, published_id).part_digest == part.digest


def quiet(health):
    """What diagnostics say of the parts, as numbers, once no mesh waits."""
    _, values = health.line("parts", lambda _, values: values["meshes waiting"] == "0")
    return {name: int(value) for name, value in values.items() if value.isdecimal()}


def part_ids(client):
    """Names of the parts that have a result."""
    return sorted(
        statistics.part_id for statistics in client.call("get_statistics").statistics
    )


def publish_in_turn(client, surface, names, factor=0.01, first=0):
    """Publish parts one after the other, each a little larger and once the one before
    is known.
    """
    publisher = MeshPublisher(client).matched()
    vertices, triangles = surface
    for number, name in enumerate(names, first):
        publisher.publish(flat((vertices * (1.0 + factor * number), triangles), name))
        latched(client, name)
