"""More meshes and requests than the node can take at once."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import numpy as np
import pytest

from ros_pose_stats import shapes

from ..harness.cell import Health, MeshPublisher, cell_of, latched
from ..harness.client import until, wait_for
from ..harness.parts import WEDGE, flat, library_part, new_id
from ..harness.readers import on_topic, raw_of

MESHES = 1000
MEGABYTE = 2**20
MOST_GROWTH = 400 * MEGABYTE
"""Of a hundred waiting meshes on either side of the middleware, and what is remembered."""

PATIENT = 15.0
"""Seconds for a quick service on a machine that is busy with others; alone it takes a tenth."""

ROUND = shapes.hull_mesh(
    (lambda points: points / np.linalg.norm(points, axis=1)[:, None])(
        np.random.default_rng(3).standard_normal((1200, 3))) * (0.02, 0.03, 0.04))


def memory(pid, what):
    """A line of a process's status, in bytes."""
    status = Path(f"/proc/{pid}/status").read_text()
    return 1024 * int(status.partition(f"{what}:")[2].split()[0])


@pytest.fixture(scope="module")
def started(domain, tmp_path_factory):
    with cell_of(domain, tmp_path_factory.mktemp("bags"), "flood") as cell:
        yield cell


@pytest.fixture
def node(started):
    yield started[0]
    started[0].assert_sound()


@pytest.fixture
def client(started):
    return started[1]


class Pulse:
    """Asks something quick again and again; how long the longest answer took."""

    def __init__(self, client):
        self._client = client
        self._over = threading.Event()
        self.longest, self.asked = 0.0, 0
        self._thread = threading.Thread(target=self._beat)

    def _beat(self):
        while not self._over.wait(0.02):
            begin = time.monotonic()
            self._client.call("list_drop_simulations")
            self.longest = max(self.longest, time.monotonic() - begin)
            self.asked += 1

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()


@pytest.mark.long
class TestMeshes:
    @pytest.mark.long
    def test_a_thousand_as_fast_as_can_be(self, node, client):
        health = Health(client)
        publisher = MeshPublisher(client).matched()
        publisher.publish(flat(ROUND, "before"))
        latched(client, "before")
        pid = node.process.pid
        before = memory(pid, "VmRSS")
        vertices, triangles = ROUND
        messages = [flat(((1.0 + 1e-3 * k) * vertices, triangles), f"part {k % 8}")
                    for k in range(MESHES)]
        last = library_part(((1.0 + 1e-3 * (MESHES - 1)) * vertices, triangles)).digest
        with Pulse(client) as pulse:
            publisher.publish(*messages)
            until(lambda: latched(client, f"part {(MESHES - 1) % 8}").part_digest == last)
        assert pulse.longest < PATIENT and pulse.asked > 0
        assert memory(pid, "VmHWM") - before < MOST_GROWTH
        _, values = health.line("parts")
        taken = len(raw_of(node.log_directory, on_topic("part_mesh"))) - 1
        assert 0 < taken <= MESHES
        assert taken + int(values["overrun"]) == MESHES
        assert (values["parts"], values["meshes waiting"], values["refused"]) == ("9", "0", "0")

    def test_a_request_does_not_wait_for_the_flood(self, client):
        publisher = MeshPublisher(client).matched()
        vertices, triangles = ROUND
        publisher.publish(*[flat(((2.0 + 1e-3 * k) * vertices, triangles), "stream")
                            for k in range(200)])
        begin = time.monotonic()
        client.good("estimate", part=flat(WEDGE, new_id()))
        assert time.monotonic() - begin < PATIENT
        last = library_part(((2.0 + 1e-3 * 199) * vertices, triangles)).digest
        until(lambda: latched(client, "stream").part_digest == last)


class TestRequests:
    @pytest.mark.parametrize("name", ["list_drop_simulations", "get_statistics"])
    def test_none_of_many_at_once_is_lost(self, client, name):
        coming = [client.send(name, **{} if "list" in name else {"part_id": f"nobody {k}"})
                  for k in range(300)]
        for k, future in enumerate(coming):
            answer = wait_for(future)
            assert "list" in name or f"'nobody {k}'" in answer.message

    @pytest.mark.long
    def test_parts_come_and_go_while_others_ask(self, node, client):
        names = [new_id() for _ in range(8)]
        end = time.monotonic() + 4.0
        with Pulse(client):
            while time.monotonic() < end:
                coming = [client.send("estimate", part=flat(WEDGE, name)) for name in names]
                assert all(wait_for(future).success for future in coming)
                coming = [client.send("forget_part", part_id=name) for name in names]
                coming += [client.send("list_drop_simulations") for _ in range(20)]
                for future in coming:
                    wait_for(future)
        assert node.process.poll() is None
