"""Views of numpy on meshes as they lie in a serialised message.

rclpy makes a Python object of every vertex and triangle, a second for a large mesh. Here the
arrays are seen in place instead: little-endian plain CDR (XCDR1) with its 4-byte header, in
which primitives are aligned to their own size, counted from behind the header.
"""

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


class _Cursor:
    """Reads along a buffer."""

    def __init__(self, data: bytes) -> None:
        if len(data) < HEADER or bytes(data[:2]) != LITTLE_ENDIAN_CDR:
            raise NotPlainCdrError
        self._data, self._at = data, HEADER

    def array(self, count: int, kind: str) -> NDArray[Any]:
        """The next numbers; none are not aligned for."""
        dtype = np.dtype(kind)
        if not count:
            return np.zeros(0, dtype)
        begin = self._at + -(self._at - HEADER) % dtype.itemsize
        self._at = begin + count * dtype.itemsize
        if self._at > len(self._data):
            raise NotPlainCdrError
        return np.frombuffer(self._data, dtype, count, begin)

    def count(self) -> int:
        """The next uint32."""
        return int(self.array(1, "<u4")[0])

    def stamp(self) -> int:
        """The next time, in nanoseconds."""
        seconds = int(self.array(1, "<i4")[0])
        return 10**9 * seconds + self.count()

    def text(self) -> str:
        """The next string, which ends in a zero byte."""
        try:
            return self.array(self.count(), "u1").tobytes()[:-1].decode("utf-8")
        except UnicodeDecodeError as error:
            raise NotPlainCdrError from error

    def end(self) -> None:
        """Make sure that all was read, but for what serialisers leave room for at the end."""
        if len(self._data) - self._at >= MOST_ROOM:
            raise NotPlainCdrError


def _mesh(cursor: _Cursor) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    triangles = cursor.array(3 * cursor.count(), "<u4").reshape(-1, 3)
    return cursor.array(3 * cursor.count(), "<f8").reshape(-1, 3), triangles


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
    vertices = cursor.array(cursor.count(), "<f8")
    triangles = cursor.array(cursor.count(), "<u4")
    scalars = cursor.array(SCALARS, "<f8")
    cursor.end()
    return Numbers(stamp, part_id, mesh_vertices, mesh_triangles, vertices, triangles, scalars)


def observed_numbers(data: bytes) -> ObservedNumbers:
    """See a serialised `ros_pose_stats_msgs/ObservedParts`; see `mesh_numbers`."""
    cursor = _Cursor(data)
    stamp, frame_id, part_id = cursor.stamp(), cursor.text(), cursor.text()
    poses = cursor.array(7 * cursor.count(), "<f8").reshape(-1, 7)
    confidence = cursor.array(cursor.count(), "<f8")
    cursor.end()
    return ObservedNumbers(stamp, frame_id, part_id, poses, confidence)
