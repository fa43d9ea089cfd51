"""Meshes that are none: refused with a reason to all who may ask, and the next one served."""

from __future__ import annotations

import random
import struct
from array import array

import numpy as np
import pytest
from geometry_msgs.msg import Inertia, Vector3
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh

from ros_pose_stats import shapes

from ..harness.cell import Health, MeshPublisher, cell_of, latched
from ..harness.client import DONE, FAILED, RUNNING, until
from ..harness.parts import WEDGE, flat, library_part, mesh, new_id

VERTICES, TRIANGLES = WEDGE
NAN, INFINITY = float("nan"), float("inf")
MOST_BYTES = 100_000


def changed(place, value):
    vertices = VERTICES.copy()
    vertices[place] = value
    return vertices, TRIANGLES


def pointing(place, value):
    triangles = TRIANGLES.copy()
    triangles[place] = value
    return VERTICES, triangles


def inertia(mass=1.0, com=(0.02, 0.014, 0.007), diagonal=(0.0, 0.0, 0.0)):
    x, y, z = com
    ixx, iyy, izz = diagonal
    return Inertia(m=mass, com=Vector3(x=x, y=y, z=z), ixx=ixx, iyy=iyy, izz=izz)


def both():
    message = flat(WEDGE)
    message.mesh = mesh(WEDGE)
    return message


def uneven(name):
    message = flat(WEDGE)
    values = getattr(message, name)
    setattr(message, name, array(values.typecode, list(values)[:-1]))
    return message


BAD = {
    "nan": (flat(changed((2, 1), NAN)), "nan"),
    "infinite": (flat(changed((0, 0), INFINITY)), "inf"),
    "index out of range": (flat(pointing((1, 1), 77)), "77"),
    "no volume": (flat(changed((slice(None), 2), 0.0)), "thick"),
    "points only": (flat((VERTICES, TRIANGLES[:0])), "triangle"),
    "triangles only": (flat((VERTICES[:0], TRIANGLES)), ""),
    "centre outside": (flat(WEDGE, inertia=inertia(com=(1.0, 1.0, 1.0))), "centre of mass"),
    "impossible inertia": (flat(WEDGE, inertia=inertia(diagonal=(1.0, 0.1, 0.1))), "inertia"),
    "inertia without mass": (
        flat(WEDGE, inertia=inertia(0.0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))), "inertia.m = 0"),
    "negative mass": (flat(WEDGE, inertia=inertia(-2.0)), "-2"),
    "unit 0": (flat(WEDGE, unit=0.0), "unit above 0"),
    "unit negative": (flat(WEDGE, unit=-0.001), "-0.001"),
    "unit nan": (flat(WEDGE, unit=NAN), "nan"),
    "both forms": (both(), "got both"),
    "uneven vertices": (uneven("vertices"), "multiple of three"),
    "uneven triangles": (uneven("triangles"), "multiple of three"),
    "too large": (flat(shapes.cylinder(3000, 1.0, 1.0)), f"at most {MOST_BYTES} bytes"),
    "restitution 1": (flat(WEDGE, restitution=1.0), "restitution"),
    "restitution nan": (flat(WEDGE, restitution=NAN), "restitution"),
    "drop height nan": (flat(WEDGE, drop_height=NAN), "drop height"),
}
NAMES = {"long": "x" * 201, "escape": "part\x1b[31m", "newline": "part\nFATAL"}


@pytest.fixture(scope="module")
def started(domain, tmp_path_factory):
    with cell_of(domain, tmp_path_factory.mktemp("bags"), "bad", max_mesh_bytes=MOST_BYTES,
                 mesh_topics="[/bad/cad]") as (node, client):
        yield node, client, Health(client)


@pytest.fixture
def node(started):
    yield started[0]
    started[0].assert_sound()


@pytest.fixture(scope="module")
def client(started):
    return started[1]


@pytest.fixture(scope="module")
def health(started):
    return started[2]


@pytest.fixture(scope="module")
def publisher(client):
    return MeshPublisher(client).matched()


@pytest.fixture(scope="module")
def mesh_publisher(client):
    return MeshPublisher(client, "/bad/cad", Mesh).matched()


def named(message, part_id):
    message.part_id = part_id
    return message


def refusal_of_start(client, message):
    """Why a simulation is refused, at once, or where the look at the mesh takes long, later."""
    answer = client.call("start_drop_simulation", part=message, drops=10)
    if answer.success:
        ended = until(lambda: (found := client.good(
            "get_drop_simulation", job_id=answer.job_id)).state > RUNNING and found)
        assert ended.state == FAILED
        return ended.message
    return answer.message


def assert_good_ones_are_served(client, publisher):
    part_id = new_id()
    publisher.publish(flat(WEDGE, part_id))
    assert latched(client, part_id).part_digest == library_part(WEDGE).digest


class TestServices:
    @pytest.mark.parametrize("kind", BAD)
    def test_refused_by_estimate_and_in_the_log(self, node, client, kind):
        message, said = BAD[kind]
        part_id = new_id()
        told = client.refused("estimate", part=named(message, part_id))
        assert said in told and told in node.says(f"request for '{part_id}'").log
        assert not client.call("get_statistics", part_id=part_id).success

    def test_refused_by_start_and_in_diagnostics(self, node, client, health):
        reasons = {}
        for message, _ in BAD.values():
            part_id = new_id()
            reasons[part_id] = refusal_of_start(client, named(message, part_id))
        line, values = health.line("parts", lambda line, values: part_id in line.message)
        assert line.level == line.WARN
        listed = "\n".join(value for key, value in values.items() if key.startswith("refused "))
        for part_id, reason in reasons.items():
            assert f"request for '{part_id}': {reason}" in listed
        assert DONE not in client.call("list_drop_simulations").state

    @pytest.mark.parametrize("kind", NAMES)
    def test_names(self, node, client, kind):
        told = client.refused("estimate", part=flat(WEDGE, NAMES[kind]))
        assert "part_id of at most 200 printable characters" in told
        assert told in node.says(told).log
        assert "\x1b[31m" not in node.log and "\nFATAL" not in node.log

    def test_neither_form(self, client):
        assert "part_id of a known part" in client.refused("estimate", part=PartMesh())

    def test_the_next_one_is_served(self, client):
        assert client.good("estimate", part=flat(WEDGE, new_id())).statistics.poses


class TestTopics:
    def test_all_kinds(self, node, client, health, publisher):
        before = int(health.line("parts")[1]["refused"])
        for message, _ in BAD.values():
            publisher.publish(named(message, new_id()))
        publisher.publish(PartMesh(), flat(WEDGE, NAMES["escape"]))
        expected = before + len(BAD) + 2
        _, values = health.line("parts", lambda _, values: int(values["refused"]) >= expected)
        listed = [value for key, value in values.items() if key.startswith("refused ")]
        for said in [*[said for _, said in BAD.values()][2:], "got neither", "printable"]:
            assert any("~/part_mesh" in one and said in one for one in listed), said
            assert any("~/part_mesh" in one and "mesh refused: " in one and said in one
                       for one in node.lines)
        assert_good_ones_are_served(client, publisher)

    def test_a_flood_of_the_same_bad_mesh_is_logged_once(self, node, client, publisher):
        message = named(flat(WEDGE, unit=-7.5), new_id())
        publisher.publish(*[message] * 50)
        node.says("-7.5")
        assert_good_ones_are_served(client, publisher)
        assert node.log.count("got -7.5") == 1

    def test_garbage_bytes(self, node, client, health, publisher, mesh_publisher):
        random.seed(7)
        good, one_mesh = serialize_message(flat(WEDGE)), serialize_message(mesh(WEDGE))
        before = int(health.line("parts")[1]["refused"])
        garbage = [random.randbytes(size) for size in (5, 16, 64, 999)]
        garbage += [b"\0\1\0\0" + random.randbytes(size) for size in (4, 8, 64, 999)]
        garbage += [b"\0\1\0\0" + b"\xff" * size for size in (16, 64)]
        for data in garbage:
            publisher.publish(data)
            mesh_publisher.publish(data)
        publisher.publish(*[good[:size] for size in range(8, len(good) - 8, 61)])
        mesh_publisher.publish(*[one_mesh[:size] for size in range(4, len(one_mesh) - 8, 61)])
        assert_good_ones_are_served(client, publisher)
        mesh_publisher.publish(mesh(WEDGE))
        latched(client, "cad")
        refused = int(health.line("parts")[1]["refused"])
        assert refused - before > 2 * len(garbage)

    def test_other_bytes_first(self, client, mesh_publisher):
        """A mesh from a machine that has the most significant byte first."""
        doubled = 2.0 * VERTICES
        data = struct.pack(">I", len(TRIANGLES)) + TRIANGLES.astype(">u4").tobytes()
        data += struct.pack(">I", len(VERTICES))
        data += bytes(-len(data) % 8) + np.ascontiguousarray(doubled, dtype=">f8").tobytes()
        mesh_publisher.publish(b"\0\0\0\0" + data)
        expected = library_part((doubled, TRIANGLES)).digest
        until(lambda: latched(client, "cad").part_digest == expected, "the mesh")
