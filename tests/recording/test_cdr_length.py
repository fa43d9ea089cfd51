"""Where serialised messages end, whatever follows them."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.recording.writer.message_types import (
    SEPARATOR,
    CdrLength,
    MessageType,
    message_type,
)
from tests.recording.bags import string

SHARE = Path(sys.prefix) / "share"

NAME = "a/msg/Top"
DEFINITION = f"\n{SEPARATOR}\n".join((
    """\
int32 ONE=1
uint8 first 7
Odd[] odds  # three bytes each
bool yes
Point[] points
string name 'x # y'
Wide[3] fixed
string<=9[<=4] words
Deep[] deep
uint16[5] five
b/Empty empty
float64[] numbers
int8[<=3] last
""",
    "MSG: a/Odd\nbyte a\nuint16 b\n", "MSG: a/Point\nfloat64 x\nfloat32 y\n",
    "MSG: a/Wide\nfloat64[2] xy\nuint8 c\n", "MSG: a/Deep\nOdd odd\nfloat64[] numbers\nstring s\n",
    "MSG: b/Empty\n"))
KIND = MessageType(NAME, DEFINITION, "")


def array(kind: str, values) -> np.ndarray:
    return np.array(values, dtype=kind)


@pytest.fixture(scope="module")
def serialized():
    """Serialises a message by other people's code."""
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    store.register(typesys.get_types_from_msg(
        DEFINITION.replace("MSG: b/Empty\n", "MSG: b/Empty\nuint8 member\n"), NAME))
    kinds = {name: store.types[f"a/msg/{name}"]
             for name in ("Top", "Odd", "Point", "Wide", "Deep")}

    def serialize(counts: list[int], text: str) -> bytes:
        def odd() -> object:
            return kinds["Odd"](1, 2)

        top = kinds["Top"](
            7, [odd() for _ in range(counts[0])], True,
            [kinds["Point"](1.0, 2.0) for _ in range(counts[1])], text,
            [kinds["Wide"](array("f8", [1, 2]), 3) for _ in range(3)], [text] * counts[2],
            [kinds["Deep"](odd(), array("f8", range(number)), text) for number in counts[3:5]],
            array("u2", range(5)), store.types["b/msg/Empty"](9),
            array("f8", range(counts[5])), array("i1", range(counts[6])))
        return bytes(store.serialize_cdr(top, NAME, little_endian=True))

    return serialize


@given(counts=st.lists(st.integers(0, 20), min_size=7, max_size=7), text=st.text(max_size=9),
       junk=st.binary(max_size=40))
def test_the_message_is_kept_and_nothing_else(serialized, counts, text, junk):
    data = serialized(counts, text)
    assert CdrLength(KIND).trimmed(data + junk) == data


@given(counts=st.lists(st.integers(0, 3), min_size=7, max_size=7), data=st.data())
def test_half_a_message_is_left_as_it_is(serialized, counts, data):
    whole = serialized(counts, "text")
    half = whole[:data.draw(st.integers(0, len(whole)))]
    assert CdrLength(KIND).trimmed(half) == half


@pytest.mark.parametrize("header", [b"\0\0\0\0", b"\0\3\0\0", b"", b"\0\1\0\0"])
def test_what_is_not_understood_is_left_as_it_is(header):
    kind = MessageType("std_msgs/msg/String", "string data\n", "")
    assert CdrLength(kind).trimmed(header + b"\xff\0\0\0a\0\0\0") == header + b"\xff\0\0\0a\0\0\0"


def test_types_that_are_not_understood_are_left_as_they_are():
    kind = MessageType("a/msg/Wide", "string s\nwstring data\n", "")
    data = string("x") + bytes(20)
    assert CdrLength(kind).trimmed(data) == data


@pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning")
class TestRos:
    """What rclpy returns is longer than the message."""

    @pytest.mark.parametrize("poses", [0, 1, 5])
    @pytest.mark.parametrize("outline", [0, 3])
    def test_results(self, poses, outline):
        messages = pytest.importorskip("ros_pose_stats_msgs.msg")
        typesys = pytest.importorskip("rosbags.typesys")
        from rclpy.serialization import deserialize_message, serialize_message

        kind = message_type("ros_pose_stats_msgs/msg/PoseStatistics",
                            lambda package: SHARE / package)
        message = messages.PoseStatistics(part_id="clamp", warnings=["CODE: text"])
        message.poses = [messages.StablePose(pose_id="x" * k, outline=[0.5] * outline)
                         for k in range(poses)]
        trimmed = CdrLength(kind).trimmed(serialize_message(message))
        store = typesys.get_typestore(typesys.Stores.EMPTY)
        store.register(typesys.get_types_from_msg(kind.definition, kind.name))
        read = store.deserialize_cdr(trimmed, kind.name)
        assert len(store.serialize_cdr(read, kind.name)) == len(trimmed)
        assert deserialize_message(bytes(trimmed), messages.PoseStatistics) == message

    def test_a_large_mesh_takes_no_time(self):
        messages = pytest.importorskip("ros_pose_stats_msgs.msg")
        from geometry_msgs.msg import Point
        from rclpy.serialization import serialize_message
        from shape_msgs.msg import MeshTriangle

        kind = message_type("ros_pose_stats_msgs/msg/PartMesh", lambda package: SHARE / package)
        message = messages.PartMesh(part_id="clamp")
        message.mesh.triangles = [MeshTriangle()] * 100_000
        message.mesh.vertices = [Point()] * 50_000
        data = serialize_message(message)
        lengths = CdrLength(kind)
        start = time.process_time()
        for _ in range(10):
            trimmed = lengths.trimmed(data)
        assert time.process_time() - start < 0.1
        assert 0 <= len(data) - len(trimmed) < 16
