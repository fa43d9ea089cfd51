"""Views on serialised meshes beside rclpy's own (de)serialiser."""

from __future__ import annotations

import struct
from array import array

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Inertia, Vector3
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PartMesh, PoseStatistics
from std_msgs.msg import Header

from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.ros.messages.mesh_views import (
    NotPlainCdrError,
    Numbers,
    mesh_numbers,
    part_and_digest_of,
    part_mesh_numbers,
)
from ros_pose_stats.ros.messages.part_messages import (
    request_of_mesh_bytes,
    request_of_part_bytes,
)

from ..harness.parts import WEDGE, flat, mesh, nested

NUMBERS = st.floats(width=64)
COUNTS = st.integers(0, 2**32 - 1)
NAMES = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=20)
SURFACES = st.tuples(
    st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS), max_size=6).map(
        lambda rows: np.array(rows, dtype=np.float64).reshape(-1, 3)),
    st.lists(st.tuples(COUNTS, COUNTS, COUNTS), max_size=6).map(
        lambda rows: np.array(rows, dtype=np.uint32).reshape(-1, 3)))
VECTORS = st.builds(Vector3, x=NUMBERS, y=NUMBERS, z=NUMBERS)
INERTIAS = st.builds(Inertia, m=NUMBERS, com=VECTORS, ixx=NUMBERS, ixy=NUMBERS, ixz=NUMBERS,
                     iyy=NUMBERS, iyz=NUMBERS, izz=NUMBERS)
HEADERS = st.builds(Header, frame_id=NAMES, stamp=st.builds(
    Time, sec=st.integers(-2**31, 2**31 - 1), nanosec=st.integers(0, 10**9 - 1)))
PARTS = st.builds(
    PartMesh, header=HEADERS, part_id=NAMES, mesh=SURFACES.map(mesh),
    vertices=st.lists(NUMBERS, max_size=10).map(lambda values: array("d", values)),
    triangles=st.lists(COUNTS, max_size=10).map(lambda values: array("I", values)),
    unit=NUMBERS, inertia=INERTIAS, restitution=NUMBERS, drop_height=NUMBERS)


def serialized(message):
    return bytes(serialize_message(message))


def numbers_of_message(message):
    """The content of a message as arrays, number by number."""
    inertia, center, stamp = message.inertia, message.inertia.com, message.header.stamp
    scalars = np.array([message.unit, inertia.m, center.x, center.y, center.z, inertia.ixx,
                        inertia.ixy, inertia.ixz, inertia.iyy, inertia.iyz, inertia.izz,
                        message.restitution, message.drop_height])
    return Numbers(10**9 * stamp.sec + stamp.nanosec, message.part_id, *arrays_of(message.mesh),
                   np.asarray(message.vertices), np.asarray(message.triangles), scalars)


def arrays_of(mesh):
    vertices = np.array([(p.x, p.y, p.z) for p in mesh.vertices], dtype=np.float64)
    triangles = np.array([t.vertex_indices for t in mesh.triangles], dtype=np.uint32)
    return vertices.reshape(-1, 3), triangles.reshape(-1, 3)


def assert_same(found, expected):
    assert (found.stamp, found.part_id) == (expected.stamp, expected.part_id)
    for name in ("mesh_vertices", "mesh_triangles", "vertices", "triangles", "scalars"):
        one, other = getattr(found, name), getattr(expected, name)
        assert one.shape == other.shape and one.dtype == other.dtype, name
        assert one.tobytes() == other.tobytes(), name


class TestViews:
    @given(PARTS)
    def test_a_part_is_seen_as_the_deserialiser_has_it(self, message):
        assert_same(part_mesh_numbers(serialized(message)), numbers_of_message(message))

    @given(PARTS)
    def test_the_name_is_found_without_the_rest(self, message):
        named = PoseStatistics(part_id=message.part_id, part_digest="0a1b")
        assert part_and_digest_of(serialized(named)) == (message.part_id, "0a1b")

    @given(SURFACES)
    def test_a_mesh_is_seen_as_it_was(self, surface):
        vertices, triangles = mesh_numbers(serialized(mesh(surface)))
        assert vertices.tobytes() == surface[0].tobytes()
        assert triangles.tobytes() == surface[1].tobytes()
        found = request_of_mesh_bytes(serialized(mesh(surface)), "part", 0.5)
        assert (found.unit, found.restitution, found.drop_height) == (0.5, -1.0, -1.0)

    def test_nothing_is_copied(self):
        data = serialized(flat(WEDGE))
        found = part_mesh_numbers(data)
        assert not found.vertices.flags.owndata and not found.triangles.flags.owndata


def swapped(surface):
    """A `shape_msgs/Mesh` as a big-endian machine serialises it."""
    vertices, triangles = surface
    data = struct.pack(">I", len(triangles)) + triangles.astype(">u4").tobytes()
    data += struct.pack(">I", len(vertices))
    data += bytes(-len(data) % 8) + vertices.astype(">f8").tobytes()
    return b"\0\0\0\0" + data


def refusal_of(take, data):
    """What is said of bytes; nothing if they are a mesh."""
    try:
        take(data)
    except PoseStatsError as refusal:
        return str(refusal)
    return ""


class TestOtherBytes:
    @given(PARTS, st.data())
    def test_a_cut_message_is_refused(self, message, data):
        whole = serialized(message)
        cut = data.draw(st.integers(0, max(len(whole) - 8, 0)))
        with pytest.raises(NotPlainCdrError):
            part_mesh_numbers(whole[:cut])

    @given(st.binary(max_size=200), st.booleans())
    def test_garbage_is_refused_or_a_mesh(self, garbage, headed):
        data = b"\0\1\0\0" * headed + garbage
        for see in (mesh_numbers, part_mesh_numbers, part_and_digest_of):
            try:
                see(data)
            except NotPlainCdrError:
                continue

    @given(st.binary(max_size=120))
    def test_garbage_is_refused_in_one_line(self, garbage):
        for take in (lambda data: request_of_mesh_bytes(data, "part", 1.0),
                     request_of_part_bytes):
            for data in (garbage, b"\0\1\0\0" + garbage):
                assert "\n" not in refusal_of(take, data)

    def test_more_bytes_than_a_message_has(self):
        with pytest.raises(NotPlainCdrError):
            mesh_numbers(serialized(mesh(WEDGE)) + bytes(64))

    def test_counts_beyond_the_end(self):
        for count in (1, 2**31, 2**32 - 1):
            with pytest.raises(NotPlainCdrError):
                mesh_numbers(b"\0\1\0\0" + struct.pack("<I", count) + bytes(4))

    def test_big_endian_goes_through_the_deserialiser(self):
        surface = WEDGE[0], WEDGE[1].astype(np.uint32)
        data = swapped(surface)
        with pytest.raises(NotPlainCdrError):
            mesh_numbers(data)
        found = request_of_mesh_bytes(data, "part", 0.001)
        np.testing.assert_array_equal(found.vertices, surface[0])
        np.testing.assert_array_equal(found.triangles, surface[1])
        assert (found.part_id, found.unit) == ("part", 0.001)

    @pytest.mark.parametrize("make", [flat, nested])
    def test_plain_messages_never_go_through_it(self, monkeypatch, make):
        monkeypatch.delattr("ros_pose_stats.ros.messages.part_messages.deserialize_message")
        found = request_of_part_bytes(serialized(make(WEDGE, "part")))
        np.testing.assert_array_equal(found.vertices, WEDGE[0])
        np.testing.assert_array_equal(found.triangles, WEDGE[1])
