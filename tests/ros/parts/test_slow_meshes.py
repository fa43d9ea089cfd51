"""While a large mesh is checked, others are served; a real node."""

from __future__ import annotations

import pytest

from ..harness.cell import Health, MeshPublisher, cell_of, latched
from ..harness.client import until, wait_for
from ..harness.parts import WEDGE, flat, library_part, new_id
from ..harness.slow import builder_at_work, ellipsoid, is_gone, kill, slivers

SLOW = ellipsoid(120_000)
SLOWISH = ellipsoid(60_000)
MEDIUM = ellipsoid(12_000)


@pytest.fixture(scope="module")
def started(domain, tmp_path_factory):
    with cell_of(domain, tmp_path_factory.mktemp("bags"), "slow") as cell:
        yield cell


@pytest.fixture
def node(started):
    yield started[0]
    started[0].assert_sound()


@pytest.fixture
def client(started):
    """Its parts are forgotten, else each of them would be estimated again in later tests."""
    client = started[1]
    yield client
    for one in client.call("get_statistics").statistics:
        client.call("forget_part", part_id=one.part_id)


@pytest.fixture
def publisher(client):
    return MeshPublisher(client).matched()


def is_known(client, part_id):
    return client.call("get_statistics", part_id=part_id).success


class TestOthers:
    def test_small_meshes_and_known_parts_do_not_wait(self, node, client, publisher):
        known, slow, small, published = (new_id() for _ in range(4))
        client.good("estimate", part=flat(WEDGE, known))
        asked = client.send("estimate", part=flat(SLOW, slow))
        builder_at_work(node.process.pid)
        client.good("estimate", part_id=known, restitution=0.3)
        client.good("estimate", part=flat(WEDGE, small))
        publisher.publish(flat(WEDGE, published))
        latched(client, published)
        assert not asked.done()
        assert wait_for(asked).success
        client.good("estimate", part_id=slow, restitution=0.3)

    def test_of_one_name_the_later_mesh_wins(self, client, publisher):
        part_id, other = new_id(), new_id()
        publisher.publish(flat(SLOW, part_id), flat(WEDGE, part_id), flat(WEDGE, other))
        latched(client, other)
        assert not is_known(client, part_id)
        last = library_part(WEDGE).digest
        until(lambda: latched(client, part_id).part_digest == last)

    @pytest.mark.long
    def test_a_medium_mesh_does_not_wait_until_slow_ones_are_done(self, client):
        slow = [client.send("estimate", part=flat(((1.0 + 0.1 * k) * SLOW[0], SLOW[1]), new_id()))
                for k in range(2)]
        client.good("estimate", part=flat(MEDIUM, new_id()))
        assert not all(one.done() for one in slow)
        assert all(wait_for(one).success for one in slow)

    def test_needles_hold_up_no_small_mesh(self, client):
        """A mesh of needles is small, and keeps whoever checks it for a second."""
        vertices, triangles = slivers(4900)
        needles = [client.send("estimate", part=flat(((1.0 + 0.1 * k) * vertices, triangles)))
                   for k in range(4)]
        client.good("estimate", part=flat(WEDGE, new_id()))
        assert not any(one.done() for one in needles[2:])
        assert all(wait_for(one).success for one in needles)


class TestRoom:
    def test_all_requests_that_wait_share_one_bound_in_bytes(self, client):
        size = SLOWISH[0].nbytes + 12 * len(SLOWISH[1])
        assert not client.set(max_mesh_bytes=size)
        try:
            coming = [client.send("estimate", part=flat(
                ((1.0 + 0.1 * k) * SLOWISH[0], SLOWISH[1]), new_id())) for k in range(6)]
            client.good("estimate", part=flat(WEDGE, new_id()))
            refused = [answer.message for answer in map(wait_for, coming) if not answer.success]
        finally:
            client.set(max_mesh_bytes=2**26)
        assert 3 <= len(refused) <= 5  # one is built and another one waits
        assert all(f"at most {2 * size} bytes of large meshes waiting (2 times max_mesh_bytes)"
                   in message for message in refused)


class TestTheProcess:
    def test_poses_for_another_tolerance_are_found_there(self, node, client):
        part_id = new_id()
        client.good("estimate", part=flat(SLOW, part_id))
        before = latched(client, part_id)
        assert not client.set(cluster_tolerance=0.02)
        try:
            builder_at_work(node.process.pid)
            until(lambda: latched(client, part_id).cluster_tolerance != before.cluster_tolerance)
        finally:
            client.set(cluster_tolerance=before.cluster_tolerance)

    def test_killed_in_the_middle(self, node, client, publisher):
        first, again, published = (new_id() for _ in range(3))
        asked = client.send("estimate", part=flat(SLOW, first))
        kill(builder_at_work(node.process.pid))
        answer = wait_for(asked)
        assert not answer.success
        assert "send the mesh again" in answer.message
        publisher.publish(flat(SLOW, published))
        process = builder_at_work(node.process.pid)
        kill(process)
        Health(client).line("parts", lambda line, _: f"part '{published}'" in line.message
                            and "send the mesh again" in line.message)
        client.good("estimate", part=flat(SLOWISH, again))

    def test_gone_with_a_node_that_is_killed(self, node_of, client_of):
        node = node_of().ready()
        client = client_of()
        asked = client.send("estimate", part=flat(SLOW, "slow"))
        process = builder_at_work(node.process.pid)
        assert not asked.done()
        node.kill()
        assert until(lambda: is_gone(process))
