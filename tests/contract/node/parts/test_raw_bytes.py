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

"""Serialised messages of any machine, and bytes that are no message, on the topics of
meshes.
"""

import random
import struct

import pytest
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh

from ..harness.camera import learnt, lying, picture, seeing
from ..harness.cell import Health, MeshPublisher, latched
from ..harness.client import until
from ..harness.jobs import known_part
from ..harness.parts import WEDGE, flat, library_part, mesh, nested

LITTLE, BIG = "<>"
SIZES = {"double": 8, "uint32": 4, "int32": 4, "uint64": 8}


def encoded(message, order):
    """A message as plain CDR in an order of bytes, with its header of four bytes."""
    data = bytearray()
    _append(data, message, order)
    return (b"\0\1\0\0" if order == LITTLE else b"\0\0\0\0") + bytes(data)


def _number(data, kind, value, order):
    size = SIZES[kind]
    data += bytes(-len(data) % size)
    data += struct.pack(
        order + {"double": "d", "uint32": "I", "int32": "i", "uint64": "Q"}[kind], value
    )


def _append(data, message, order):
    for name, kind in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        if kind in SIZES:
            _number(data, kind, value, order)
        elif kind == "string":
            text = value.encode() + b"\0"
            _number(data, "uint32", len(text), order)
            data += text
        elif kind.startswith("sequence<") or kind.endswith("]"):
            inner = kind.removeprefix("sequence<").rstrip(">").partition("[")[0]
            if kind.startswith("sequence<"):
                _number(data, "uint32", len(value), order)
            for entry in value:
                if inner in SIZES:
                    _number(data, inner, entry, order)
                else:
                    _append(data, entry, order)
        else:
            _append(data, value, order)


class TestOtherMachines:
    @pytest.mark.parametrize("order", [LITTLE, BIG])
    @pytest.mark.parametrize("make", [flat, nested])
    @pytest.mark.parametrize("name", ["p", "par"])  # what follows is aligned otherwise
    def test_parts_in_either_order_of_bytes(self, tuned, make, order, name):
        factor = 1.0 + 0.1 * len(name)
        message = make((factor * WEDGE[0], WEDGE[1]), name, restitution=0.25)
        message.header.frame_id = "cad"
        MeshPublisher(tuned).matched().publish(encoded(message, order))
        answer = latched(tuned, name)
        assert answer.part_digest == library_part((factor * WEDGE[0], WEDGE[1])).digest
        assert answer.restitution == 0.25

    @pytest.mark.parametrize("order", [LITTLE, BIG])
    def test_standard_meshes_in_either_order(self, tuned, order):
        surface = (2.0 + (order == BIG)) * WEDGE[0], WEDGE[1]
        MeshPublisher(tuned, "/tuned/cad", Mesh).matched().publish(
            encoded(mesh(surface), order)
        )
        digest = library_part(surface).digest
        until(lambda: latched(tuned, "cad").part_digest == digest, "the mesh")

    @pytest.mark.parametrize("order", [LITTLE, BIG])
    def test_pictures_of_a_camera_in_either_order(self, tuned, order):
        part_id = known_part(tuned)
        pose = lying(latched(tuned, part_id).poses[0], 0.3)
        message = picture(
            part_id, pose, pose, pose, confidence=[0.9, float("nan"), 0.2]
        )
        seeing(tuned).publish(encoded(message, order))
        assert learnt(tuned, part_id, 1).method == "observed"


def odd_bytes(message):
    """Bytes that are no message, each of another length."""
    chance = random.Random(7)
    whole = bytes(serialize_message(message))
    yield from (chance.randbytes(size) for size in (9, 65, 999))
    yield from (b"\0\1\0\0" + chance.randbytes(size) for size in (10, 83, 1000))
    yield from (b"\0\1\0\0" + b"\xff" * size for size in (20, 87))
    yield from (
        b"\0\1\0\0" + struct.pack("<I", count) + bytes(size)
        for size, count in ((32, 9), (36, 2**31), (40, 2**32 - 1))
    )
    yield from (whole[:size] for size in range(56, len(whole) - 8, 61))


@pytest.mark.parametrize(
    ("topic", "kind", "good"),
    [("~/part_mesh", PartMesh, flat(WEDGE, "cad")), ("/tuned/cad", Mesh, mesh(WEDGE))],
)
def test_bytes_that_are_no_mesh_are_refused_and_the_next_mesh_is_taken(
    tuned, node, topic, kind, good
):
    health = Health(tuned)
    refused_before = int(health.line("parts")[1]["refused"])
    topic = topic.replace("~", tuned.prefix)
    publisher = MeshPublisher(tuned, topic, kind).matched()
    bad = list(odd_bytes(good))
    for data in bad:
        publisher.publish(data)
        node.says(
            f"{topic}: mesh refused: expected a serialised {kind.__name__}, "
            f"got {4 * -(-len(data) // 4)} bytes that are none"
        )
    expected = refused_before + len(bad)
    _, values = health.line(
        "parts", lambda _, values: int(values["refused"]) >= expected
    )
    assert int(values["refused"]) == expected
    publisher.publish(
        bytes(serialize_message(good)) + bytes(64), good
    )  # more than it should have
    assert latched(tuned, "cad").part_digest == library_part(WEDGE).digest


def test_large_messages_of_another_machine_are_refused_for_their_size(tuned, node):
    """The way through the deserialiser would take seconds and much memory."""
    data = struct.pack(">II", 0, 200_000) + bytes(24 * 200_000)
    MeshPublisher(tuned, "/tuned/cad", Mesh).matched().publish(b"\0\0\0\0" + data)
    node.says(f"got {len(data) + 4} bytes")
