"""Meshes on topics: every way in, copies, and new meshes under an old name."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from geometry_msgs.msg import Inertia, Vector3
from ros_pose_stats_msgs.msg import PartMesh, PoseStatistics
from shape_msgs.msg import Mesh

from ros_pose_stats import shapes
from ros_pose_stats.ros.messages.statistics_messages import is_farewell

from ..harness.cell import MeshPublisher, cell_of, latched
from ..harness.client import until
from ..harness.parts import WEDGE, flat, library_part, mesh, nested, new_id, whole
from ..harness.readers import message_of, on_topic, raw_of

TOPICS = "[/cad/bracket, gear=/cad/wheel, early=/cad/early]"
BOX = shapes.box(20.0, 30.0, 40.0)


def scaled(factor):
    vertices, triangles = WEDGE
    return factor * vertices, triangles


@pytest.fixture(scope="module")
def started(domain, tmp_path_factory):
    """A node and a client that had published before the node was there."""
    from ..harness.cell import QuickClient

    with QuickClient(domain, "/meshes/pose_stats") as early:
        MeshPublisher(early, latched=True).publish(flat(WEDGE, "early part"))
        MeshPublisher(early, "/cad/early", Mesh, latched=True).publish(mesh(BOX))
        folder = tmp_path_factory.mktemp("bags")
        with cell_of(domain, folder, "meshes", mesh_topics=TOPICS, mesh_unit=0.001) as cell:
            yield cell


@pytest.fixture
def client(started):
    node, client = started
    yield client
    node.assert_sound()


@pytest.fixture
def recorded_meshes(started):
    """Meshes of a part in the bag so far."""
    node, _ = started

    def of(part_id):
        found = [message_of(on_topic("part_mesh"), data)
                 for data in raw_of(node.log_directory, on_topic("part_mesh"))]
        return [message for message in found if message.part_id == part_id]

    return of


@pytest.fixture(scope="module")
def publisher(started):
    return MeshPublisher(started[1]).matched()


class TestWaysIn:
    @pytest.mark.parametrize("make", [flat, nested])
    @pytest.mark.parametrize("is_latched", [False, True])
    def test_part_mesh(self, client, make, is_latched):
        part_id = new_id()
        MeshPublisher(client, latched=is_latched).matched().publish(make(WEDGE, part_id))
        assert latched(client, part_id).part_digest == library_part(WEDGE).digest

    @pytest.mark.parametrize(("topic", "part_id", "is_latched"), [
        ("/cad/bracket", "bracket", False), ("/cad/wheel", "gear", True)])
    def test_mesh_on_mesh_topics(self, client, topic, part_id, is_latched):
        MeshPublisher(client, topic, Mesh, latched=is_latched).matched().publish(mesh(BOX))
        assert latched(client, part_id).part_digest == library_part(BOX, unit="mm").digest

    @pytest.mark.parametrize(("part_id", "expected"), [
        ("early part", library_part(WEDGE)), ("early", library_part(BOX, unit="mm"))])
    def test_a_latched_publisher_that_was_there_before(self, client, part_id, expected):
        assert latched(client, part_id).part_digest == expected.digest

    def test_a_nameless_part_is_named_by_its_digest(self, client, publisher):
        surface = scaled(1.23)
        digest = library_part(surface).digest
        publisher.publish(flat(surface))
        assert latched(client, f"mesh_{digest[:12]}").part_digest == digest

    def test_unit_and_mass_properties(self, client, publisher):
        part_id = new_id()
        inertia = Inertia(m=0.2, com=Vector3(x=0.02, y=0.014, z=0.007), ixx=2e-5, ixy=1e-6,
                          ixz=-2e-6, iyy=3e-5, iyz=5e-7, izz=4e-5)
        publisher.publish(flat(scaled(1000.0), part_id, unit=0.001, inertia=inertia))
        tensor = np.array([[2e-5, 1e-6, -2e-6], [1e-6, 3e-5, 5e-7], [-2e-6, 5e-7, 4e-5]])
        expected = library_part(scaled(1000.0), unit=0.001, mass=0.2, inertia=tensor,
                                center_of_mass=(0.02, 0.014, 0.007))
        assert latched(client, part_id).part_digest == expected.digest


class TestCopies:
    def test_of_the_same_mesh_are_ignored(self, client, publisher, recorded_meshes):
        part_id = new_id()
        with client.late_joiner() as joiner:
            publisher.publish(*[flat(WEDGE, part_id)] * 100)
            last = new_id()
            publisher.publish(flat(WEDGE, last))
            joiner.wait(last)
            assert len(joiner.of(part_id)) == 1
        assert len(recorded_meshes(part_id)) == 1

    def test_with_the_same_digest_in_another_unit_are_ignored(
            self, client, publisher, recorded_meshes):
        part_id = new_id()
        publisher.publish(flat(WEDGE, part_id))
        before = latched(client, part_id)
        assert client.good("estimate", part=flat(scaled(2.0), part_id, unit=0.5)
                           ).statistics.part_digest == before.part_digest
        assert whole(latched(client, part_id)) == whole(before)
        assert len(recorded_meshes(part_id)) == 1

    def test_from_a_plain_and_a_latched_publisher(self, client, publisher, recorded_meshes):
        part_id = new_id()
        publisher.publish(flat(WEDGE, part_id))
        before = latched(client, part_id)
        MeshPublisher(client, latched=True).matched().publish(nested(WEDGE, part_id))
        last = new_id()
        publisher.publish(flat(WEDGE, last))
        latched(client, last)
        assert whole(latched(client, part_id)) == whole(before)
        assert len(recorded_meshes(part_id)) == 1


class TestNewMeshes:
    def test_a_hundred_under_one_name_beside_nineteen_parts(self, client, publisher):
        parts = [new_id() for _ in range(20)]
        publisher.publish(*[flat(scaled(1.0 + 0.01 * k), part_id)
                            for k, part_id in enumerate(parts)])
        for part_id in parts:
            latched(client, part_id)
        factors = 2.0 + 0.01 * np.arange(100)
        with client.late_joiner() as joiner:
            joiner.wait(parts[0])
            publisher.publish(*[flat(scaled(factor), parts[0]) for factor in factors])
            end = library_part(scaled(factors[-1])).digest
            joiner.wait(parts[0], lambda message: message.part_digest == end)
            told = joiner.of(parts[0])
        assert len({message.part_digest for message in told}) > 50
        assert all(b.revision > a.revision for a, b in pairwise(told))
        self._look_as_late_joiner(client, parts, end)

    @staticmethod
    def _look_as_late_joiner(client, parts, end):
        others = [one.part_id for one in client.good("get_statistics").statistics
                  if one.part_id not in parts]
        for other in others:
            client.good("forget_part", part_id=other)
        found = {}

        def take(message):
            if not is_farewell(message):  # latched for a moment
                found.setdefault(message.part_id, message)

        subscription = client.subscribe(
            PoseStatistics, f"{client.prefix}/pose_statistics", take, latched=True,
            depth=len(parts) + len(others))
        until(lambda: set(parts) <= found.keys(), "all parts")
        client.node.destroy_subscription(subscription)
        assert set(found) == set(parts)
        assert found[parts[0]].part_digest == end
        assert all(found[part_id].part_digest == library_part(scaled(1.0 + 0.01 * k)).digest
                   for k, part_id in enumerate(parts) if k)

    def test_back_to_an_earlier_mesh(self, client, publisher, recorded_meshes):
        part_id = new_id()
        for factor in (1.0, 2.0) * 3:
            message = flat(scaled(factor), part_id)
            client.good("estimate", part=message)
        shown = client.good("get_statistics", part_id=part_id).statistics[0]
        client.good("estimate", part=flat(WEDGE, part_id))
        again = client.good("get_statistics", part_id=part_id).statistics[0]
        assert again.part_digest == library_part(WEDGE).digest
        assert again.revision > shown.revision
        assert again.header.stamp.sec <= shown.header.stamp.sec  # from memory
        digests = [library_part((np.reshape(message.vertices, (-1, 3)), WEDGE[1])).digest
                   for message in recorded_meshes(part_id)]
        assert len(digests) == len(set(digests)) == 2

    def test_a_forgotten_part_that_comes_again_has_a_higher_revision(self, client, publisher):
        part_id = new_id()
        for factor in (1.0, 2.0, 3.0):
            client.good("estimate", part=flat(scaled(factor), part_id))
        before = latched(client, part_id).revision
        client.good("forget_part", part_id=part_id)
        publisher.publish(flat(scaled(4.0), part_id))
        assert latched(client, part_id).revision > before

    def test_other_wishes_for_the_same_mesh(self, client, publisher):
        part_id = new_id()
        publisher.publish(flat(WEDGE, part_id))
        before = latched(client, part_id)
        publisher.publish(flat(WEDGE, part_id, restitution=0.2, drop_height=1.0))
        shown = until(lambda: (found := latched(client, part_id)).restitution == 0.2 and found)
        assert shown.part_digest == before.part_digest
        assert shown.revision > before.revision

    def test_message_times_do_not_matter(self, client):
        message = PartMesh()
        message.header.stamp.sec = -5
        message.header.frame_id = "anywhere"
        part = flat(WEDGE, new_id())
        part.header = message.header
        assert client.good("estimate", part=part).statistics.part_digest
