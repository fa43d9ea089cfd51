"""Ten thousand messages and requests that are not quite right, without a node.

Each is taken or refused in one line; whatever else comes out is a fault.
"""

from __future__ import annotations

import os
import struct
import subprocess
import sys
from random import Random

import pytest
from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import ObservedParts, PartMesh, PoseCounts
from shape_msgs.msg import Mesh

from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.ros.messages.part_messages import (
    MOST_DESERIALIZED,
    MOST_NESTED,
    request_of_mesh_bytes,
    request_of_message,
    request_of_part_bytes,
)
from tests.fuzz.messages.message_bytes import BIG, LITTLE, encoded
from tests.fuzz.messages.message_seeds import MAKERS, Seeds
from tests.fuzz.messages.messages import fuzzed
from tests.volume import few_quick

from .harness.door import DROPPED, REFUSED, REQUESTS, TAKEN, Door
from .harness.parts import WEDGE, flat, mesh

SEED = 1
PARTS, MESHES, COUNTS, SEEN, ASKED = 3500, 2500, 1500, 1500, 450
"""How many of each; together with the requests over ten thousand."""

FEWER = 10
"""A tenth of them in every run of the tests."""

MEGABYTE = 2**20


@pytest.fixture
def door():
    found = Door()
    yield found
    found.close()


class TestGenerator:
    def test_is_deterministic(self):
        for kind in MAKERS:
            once = list(fuzzed(kind, SEED, 50))
            assert once == list(fuzzed(kind, SEED, 50)) != list(fuzzed(kind, SEED + 1, 50))

    @pytest.mark.parametrize("kind", MAKERS)
    def test_sound_messages_are_encoded_as_rclpy_does(self, kind):
        """What rclpy cuts at a zero byte set aside."""
        seeds, compared = Seeds(Random(SEED)), 0
        for _ in range(60):
            message = seeds.make(kind)
            expected = deserialize_message(bytes(serialize_message(message)), kind)
            for order in (LITTLE, BIG) if "\\x00" not in repr(message) else ():
                found = deserialize_message(encoded(message, order), kind)
                assert repr(found) == repr(expected)
                compared += 1
        assert compared > 40

    def test_there_are_ten_thousand(self):
        assert PARTS + MESHES + COUNTS + ASKED * len(REQUESTS) > 10_000


class TestTopics:
    @pytest.mark.parametrize("count", few_quick([PARTS // FEWER, PARTS], 1))
    def test_part_meshes(self, door, count):
        for data in fuzzed(PartMesh, SEED, count):
            door.part(data)
        door.assert_sound()
        assert door.outcomes[TAKEN] > count // 30 < door.outcomes[REFUSED]

    @pytest.mark.parametrize("count", few_quick([MESHES // FEWER, MESHES], 1))
    def test_meshes(self, door, count):
        for data in fuzzed(Mesh, SEED, count):
            door.mesh(data)
        door.assert_sound()
        assert door.outcomes[TAKEN] > count // 30 < door.outcomes[REFUSED]

    @pytest.mark.parametrize("count", few_quick([COUNTS // FEWER, COUNTS], 1))
    def test_counts(self, door, count):
        for data in fuzzed(PoseCounts, SEED, count):
            door.counts(data)
        door.assert_sound()
        assert door.outcomes[TAKEN] > count // 10 < door.outcomes[REFUSED]


    @pytest.mark.parametrize("count", few_quick([SEEN // FEWER, SEEN], 1))
    def test_parts_seen(self, door, count):
        for number in range(8):
            door.part(bytes(serialize_message(flat(WEDGE, f"part_{number}"))))
        for data in fuzzed(ObservedParts, SEED, count):
            door.observed(data)
        door.assert_sound()
        assert door.outcomes[TAKEN] > count // 30 + 8 < door.outcomes[REFUSED]


@pytest.mark.parametrize("count", few_quick([ASKED // FEWER, ASKED], 1))
@pytest.mark.parametrize("kind", REQUESTS)
def test_requests(door, kind, count):
    door.part(bytes(serialize_message(flat(WEDGE, "part_1"))))
    for data in fuzzed(kind, SEED, count):
        door.ask(kind, data)
    door.assert_sound()
    assert door.outcomes[DROPPED] > count // 10


CLAIM = """
import resource, struct, sys
from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.ros.messages.camera_messages import counts_of_bytes, observed_of_bytes
from ros_pose_stats.ros.messages.part_messages import request_of_mesh_bytes, request_of_part_bytes
take = {"part": request_of_part_bytes, "counts": counts_of_bytes,
        "observed": observed_of_bytes,
        "mesh": lambda data: request_of_mesh_bytes(data, "part", 1.0)}[sys.argv[1]]
data = bytes.fromhex(sys.argv[2]) + bytes(int(sys.argv[3]))
def most():
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
def refused(data):
    try:
        take(data)
    except PoseStatsError:
        return True
    return False
assert refused(bytes(8))
before = most()
print(refused(data), most() - before)
"""


def most_memory(take, start, size):
    """Whether bytes with so many zeros behind them are refused, and the memory that it takes."""
    found = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", CLAIM, take, start.hex(), str(size)],
        check=True, capture_output=True, text=True, env=os.environ)
    refused, grown = found.stdout.split()
    return refused == "True", int(grown)


class TestClaims:
    """Counts of gigabytes cost no more memory than a few times the bytes that came."""

    @pytest.mark.parametrize(("take", "start"), [
        ("mesh", b"\0\1\0\0" + struct.pack("<I", 2**32 - 1)),
        ("mesh", b"\0\1\0\0" + struct.pack("<II", 0, 2**32 - 1)),
        ("mesh", b"\0\0\0\0" + struct.pack(">I", 2**32 - 1)),
        ("mesh", b"\0\1\0\0" + struct.pack("<I", 7 * MEGABYTE)),
        ("part", b"\0\1\0\0" + struct.pack("<IIIBxxxIBxxxI", 0, 0, 1, 0, 1, 0, 2**32 - 1)),
        ("part", b"\0\1\0\0" + struct.pack("<III", 0, 0, 2**32 - 1)),
        ("counts", b"\0\1\0\0" + struct.pack("<III", 0, 0, 2**32 - 1)),
    ])
    def test_of_counts(self, take, start):
        refused, grown = most_memory(take, start, 8 * MEGABYTE)
        assert refused and grown < 4 * 8 * MEGABYTE

    @pytest.mark.parametrize("start", [b"\0\1\0\0" + struct.pack("<IIIII", 0, 0, 0, 0, 2**32 - 1),
                                       b"\0\0\0\0" + struct.pack(">IIIII", 0, 0, 0, 0, 2**32 - 1),
                                       b"\0\0\0\0" + struct.pack(">IIIII", 0, 0, 0, 0, 2**19)])
    def test_of_parts_seen(self, start):
        """In small messages: larger ones are not read."""
        refused, grown = most_memory("observed", start, MEGABYTE // 2)
        assert refused and grown < 32 * MEGABYTE

    def test_of_numbers_that_would_all_become_objects(self):
        """A mesh that is one, but that rclpy's deserialiser would make 25 times as large."""
        size = 32 * MEGABYTE
        start = b"\0\0\0\0" + struct.pack(">II", 0, (size - 8) // 24)
        refused, grown = most_memory("mesh", start, size)
        assert refused and grown < 2 * size

    def test_small_ones_are_read(self):
        data = b"\0\0\0\0" + struct.pack(">II", 0, 0)
        assert request_of_mesh_bytes(data, "part", 1.0).bytes() == 0
        with pytest.raises(PoseStatsError, match=f"at most {MOST_DESERIALIZED} bytes"):
            request_of_mesh_bytes(data + bytes(MOST_DESERIALIZED), "part", 1.0)

    @pytest.mark.parametrize(("name", "most"), [("triangles", MOST_NESTED),
                                                ("vertices", 3 * MOST_NESTED)])
    def test_nested_meshes(self, name, most):
        message = PartMesh(mesh=mesh(WEDGE))
        one = getattr(message.mesh, name)[0]
        setattr(message.mesh, name, [one] * (most + 1))
        with pytest.raises(PoseStatsError, match=f"at most {most} {name}"):
            request_of_message(message)


@pytest.mark.parametrize(("seconds", "nanoseconds"), [
    (2**31 - 1, 2**32 - 1), (-2**31, 0), (-2**31, 2**32 - 1), (2**31 - 1, 0)])
def test_stamps_that_no_clock_shows(door, seconds, nanoseconds):
    message = flat(WEDGE, "part")
    message.header.stamp.sec, message.header.stamp.nanosec = seconds, nanoseconds
    data = bytes(serialize_message(message))
    assert request_of_part_bytes(data).stamp == 10**9 * seconds + nanoseconds
    door.part(data)
    assert door.outcomes == {TAKEN: 1} and REFUSED not in door.outcomes
