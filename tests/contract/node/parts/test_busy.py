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

"""However large or many the meshes are, others are served, and none is lost without a
word.
"""

import threading

import numpy as np
import pytest
from rclpy.time import Time

from lab.bodies import shapes
from lab.bodies.slow import slivers, smooth_body
from ros_pose_stats import estimate
from tests.answers import notes

from ..harness.bags import recorded
from ..harness.cell import Health, MeshPublisher, latched
from ..harness.client import Client, until, wait_for
from ..harness.parts import WEDGE, flat, library_part, new_id, probabilities
from ..harness.slow import (
    builder_at_work,
    kill,
    memory,
    standing,
    standing_builder,
)

LARGE = smooth_body(12_000)
"""So large that it is built in a process of its own."""

MOST_GROWTH = 400 * 2**20
"""Bytes of a hundred waiting meshes on either side of the middleware, and of what is
kept.
"""


def sized(surface, number):
    """The same body a little larger, which is another mesh."""
    return (1.0 + 0.1 * number) * surface[0], surface[1]


@pytest.fixture
def publisher(tuned):
    return MeshPublisher(tuned).matched()


@pytest.fixture
def pid(node):
    return node.process.pid


def test_small_meshes_known_parts_and_lists_do_not_wait(tuned, publisher, pid):
    """Of one name the later mesh wins, though it is checked sooner."""
    part_id, slow, small, published = (new_id() for _ in range(4))
    tuned.good("estimate", part=flat(WEDGE, part_id))
    with standing_builder(tuned, pid):
        waiting = tuned.send("estimate", part=flat(LARGE, slow))
        # Answered when the node has taken up what was asked before it.
        tuned.good("estimate", part_id=part_id, restitution=0.3)
        publisher.publish(flat(WEDGE, slow), flat(WEDGE, published))
        tuned.good("estimate", part=flat(WEDGE, small))
        latched(tuned, published)
        tuned.call("list_drop_simulations")
        assert not tuned.call("get_statistics", part_id=slow).success
        assert not waiting.done()
    assert wait_for(waiting).statistics.part_digest == library_part(LARGE).digest
    last = library_part(WEDGE).digest
    until(lambda: latched(tuned, slow).part_digest == last)


def test_a_large_part_is_the_library_s(tuned):
    statistics = tuned.good("estimate", part=flat(LARGE, new_id())).statistics
    expected = estimate(library_part(LARGE))
    assert (statistics.part_digest, notes(statistics)) == (
        expected.part_digest,
        notes(expected),
    )
    assert probabilities(statistics.poses) == pytest.approx(
        probabilities(expected.poses)
    )


def test_needles_hold_up_no_small_mesh(tuned, pid):
    """A mesh of needles is small, and keeps whoever checks it for half a second."""
    needles = slivers(800)
    with standing_builder(tuned, pid):
        futures = [
            tuned.send("estimate", part=flat(sized(needles, k))) for k in range(2)
        ]
        tuned.good("estimate", part=flat(WEDGE, new_id()))
        assert not any(answer.done() for answer in futures)
    assert all(wait_for(answer).success for answer in futures)


@pytest.mark.long
def test_poses_for_another_tolerance_hold_up_nobody(tuned, pid):
    slow = new_id()
    small = new_id()
    tuned.good("estimate", part=flat(LARGE, slow))
    with standing_builder(tuned, pid):
        assert tuned.set(cluster_tolerance=0.02) == {}
        tuned.good("estimate", part=flat(WEDGE, small))
    until(lambda: latched(tuned, slow).cluster_tolerance == 0.02)


def test_all_requests_that_wait_share_one_bound_in_bytes(tuned, pid):
    """Of which small ones have their part."""
    size = LARGE[0].nbytes + 12 * len(LARGE[1])
    assert tuned.set(max_mesh_bytes=size) == {}
    with standing_builder(tuned, pid):
        futures = [
            tuned.send("estimate", part=flat(sized(LARGE, k), new_id()))
            for k in range(6)
        ]
        tuned.good("estimate", part=flat(WEDGE, new_id()))
    refused = [
        answer.message for answer in map(wait_for, futures) if not answer.success
    ]
    assert len(refused) == 4  # one is built and another one waits
    assert all(
        f"at most {2 * size} bytes of large meshes waiting (2 times max_mesh_bytes)"
        in message
        for message in refused
    )


def test_a_mesh_whose_process_is_killed_is_refused_and_the_next_one_served(
    tuned, publisher, pid
):
    slow = smooth_body(120_000)
    future = tuned.send("estimate", part=flat(slow, new_id()))
    published = new_id()
    kill(builder_at_work(pid))
    assert "send the mesh again" in wait_for(future).message
    publisher.publish(flat(slow, published))
    kill(builder_at_work(pid))
    Health(tuned).line(
        "parts",
        lambda line, _: (
            f"part '{published}'" in line.message
            and "send the mesh again" in line.message
        ),
    )
    tuned.good("estimate", part=flat(LARGE, new_id()))


@pytest.fixture
def busy(domain, cell):
    """A client that may ask many things at once."""
    with Client(domain) as client:
        yield client


@pytest.mark.parametrize("name", ["list_drop_simulations", "get_statistics"])
def test_none_of_many_requests_at_once_is_lost(busy, name):
    fields = [{} if "list" in name else {"part_id": f"nobody {k}"} for k in range(300)]
    for fields_, future in [
        (fields_, busy.send(name, **fields_)) for fields_ in fields
    ]:
        answer = wait_for(future)
        assert not fields_ or f"'{fields_['part_id']}'" in answer.message


def test_parts_come_and_go_while_others_ask(busy, cell):
    names = [new_id() for _ in range(8)]
    ended = threading.Event()

    def ask():
        while not ended.is_set():
            cell.call("list_drop_simulations")

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        for _ in range(3):
            futures = [
                busy.send("estimate", part=flat(WEDGE, name), method="csae")
                for name in names
            ]
            assert all(wait_for(future).success for future in futures)
            futures = [busy.send("forget_part", part_id=name) for name in names]
            assert all(wait_for(future).success for future in futures)
    finally:
        ended.set()
        thread.join()


@pytest.mark.long
def test_a_thousand_meshes_as_fast_as_can_be(tuned, node):
    """Each is taken or counted as overrun; memory stays bounded, and a request does not
    wait.
    """
    health = Health(tuned)
    publisher = MeshPublisher(tuned).matched()
    ball = np.random.default_rng(3).standard_normal((1200, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    vertices, triangles = shapes.hull_mesh(ball * (0.02, 0.03, 0.04))
    publisher.publish(
        flat(WEDGE, "first")
    )  # else the node would not know what it has missed
    latched(tuned, "first")
    overrun = int(health.line("parts")[1]["overrun"])
    counts_before = (
        memory(node.process.pid, "VmRSS"),
        len(recorded(node.log_directory, "part_mesh")),
    )
    sizes = 1.0 + 1e-3 * np.arange(1000)
    tuned.service("estimate")
    with standing(node.process.pid):
        publisher.publish(
            *[
                flat((size * vertices, triangles), f"part {number % 8}")
                for number, size in enumerate(sizes)
            ]
        )
        future = tuned.send("estimate", part=flat(WEDGE, "asked for"))
    digest = library_part((sizes[-1] * vertices, triangles)).digest
    last = until(
        lambda: (
            (candidate := latched(tuned, "part 7")).part_digest == digest and candidate
        )
    )
    answer, shown_at = (
        Time.from_msg(statistics.header.stamp)
        for statistics in (wait_for(future).statistics, last)
    )
    assert answer < shown_at
    assert memory(node.process.pid, "VmHWM") - counts_before[0] < MOST_GROWTH
    _, values = health.line("parts", lambda _, values: values["meshes waiting"] == "0")
    recorded_meshes = (
        len(recorded(node.log_directory, "part_mesh")) - counts_before[1] - 1
    )
    assert recorded_meshes > 0 and recorded_meshes + int(
        values["overrun"]
    ) - overrun == len(sizes)
