"""Views of numpy on meshes as they lie in a serialised message.

rclpy makes a Python object of every vertex and triangle, a second for a large mesh. Here the
arrays are seen in place instead: little-endian plain CDR (XCDR1) with its 4-byte header, in
which primitives are aligned to their own size, counted from behind the header.
"""

import struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

LITTLE_ENDIAN_CDR = b"\x00\x01"
HEADER = 4
MOST_ROOM = 16
"""Fast CDR reckons with an alignment of empty sequences that it does not write, which comes to
eight bytes behind a `PartMesh`."""


class NotPlainCdrError(Exception):
    """The bytes are in another encapsulation, or not what they should be."""


class Numbers(NamedTuple):
    """Content of a `PartMesh`; arrays view the buffer."""

    stamp: int  # nanoseconds
    part_id: str
    mesh_vertices: NDArray[np.float64]  # (V, 3)
    mesh_triangles: NDArray[np.uint32]  # (T, 3) uint32
    vertices: NDArray[np.float64]  # (N,)
    triangles: NDArray[np.uint32]  # (M,) uint32
    # (13,); unit, mass, centre of mass (3), ixx, ixy, ixz, iyy, iyz, izz, restitution, drop_height
    scalars: NDArray[np.float64]


class ObservedNumbers(NamedTuple):
    """Content of an `ObservedParts`; arrays view the buffer."""

    stamp: int  # nanoseconds
    frame_id: str
    part_id: str
    poses: NDArray[np.float64]  # (n, 7); position, and orientation x y z w
    confidence: NDArray[np.float64]  # (m,)


SCALARS = 13
NO_FLOATS = np.zeros(0)
NO_COUNTS = np.zeros(0, dtype=np.uint32)


class _Cursor:
    """Reads along a buffer."""

    def __init__(self, data: bytes) -> None:
        if len(data) < HEADER or bytes(data[:2]) != LITTLE_ENDIAN_CDR:
            raise NotPlainCdrError
        self._data = data
        self._at = HEADER

    def count(self) -> int:
        """The next uint32."""
        self._align(4)
        return int(struct.unpack_from("<I", self._data, self._advance(4))[0])

    def stamp(self) -> int:
        """The next time, in nanoseconds."""
        seconds = int(np.int32(np.uint32(self.count())))
        return 10**9 * seconds + self.count()

    def text(self) -> str:
        """The next string, which ends in a zero byte."""
        length = self.count()
        begin = self._advance(length)
        try:
            return bytes(self._data[begin:begin + max(length - 1, 0)]).decode("utf-8")
        except UnicodeDecodeError as error:
            raise NotPlainCdrError from error

    def floats(self, count: int) -> NDArray[np.float64]:
        """The next float64 numbers; none are not aligned for."""
        return self._array(count, "<f8", 8) if count else NO_FLOATS

    def counts(self, count: int) -> NDArray[np.uint32]:
        """The next uint32 numbers."""
        return self._array(count, "<u4", 4) if count else NO_COUNTS

    def end(self) -> None:
        """Make sure that all was read, but for what serialisers leave room for at the end."""
        if len(self._data) - self._at >= MOST_ROOM:
            raise NotPlainCdrError

    def _array(self, count: int, kind: str, size: int) -> Any:
        self._align(size)
        begin = self._advance(count * size)
        return np.frombuffer(self._data, dtype=kind, count=count, offset=begin)

    def _align(self, size: int) -> None:
        self._at += -(self._at - HEADER) % size

    def _advance(self, length: int) -> int:
        begin = self._at
        self._at += length
        if self._at > len(self._data):
            raise NotPlainCdrError
        return begin


def _mesh(cursor: _Cursor) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    triangles = cursor.counts(3 * cursor.count()).reshape(-1, 3)
    return cursor.floats(3 * cursor.count()).reshape(-1, 3), triangles


def mesh_numbers(data: bytes) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """See vertices and triangles of a serialised `shape_msgs/Mesh`, or raise NotPlainCdrError."""
    cursor = _Cursor(data)
    surface = _mesh(cursor)
    cursor.end()
    return surface


def part_mesh_numbers(data: bytes) -> Numbers:
    """See a serialised `ros_pose_stats_msgs/PartMesh`; see `mesh_numbers`."""
    cursor = _Cursor(data)
    stamp = cursor.stamp()
    cursor.text()  # frame_id
    part_id = cursor.text()
    mesh_vertices, mesh_triangles = _mesh(cursor)
    vertices = cursor.floats(cursor.count())
    triangles = cursor.counts(cursor.count())
    scalars = cursor.floats(SCALARS)
    cursor.end()
    return Numbers(stamp, part_id, mesh_vertices, mesh_triangles, vertices, triangles, scalars)


def observed_numbers(data: bytes) -> ObservedNumbers:
    """See a serialised `ros_pose_stats_msgs/ObservedParts`; see `mesh_numbers`."""
    cursor = _Cursor(data)
    stamp, frame_id, part_id = cursor.stamp(), cursor.text(), cursor.text()
    poses = cursor.floats(7 * cursor.count()).reshape(-1, 7)
    confidence = cursor.floats(cursor.count())
    cursor.end()
    return ObservedNumbers(stamp, frame_id, part_id, poses, confidence)
