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

"""Between part messages and what the core works on; pure functions.

rclpy makes a Python object of every vertex and triangle, a second for a large mesh.
Here the arrays are seen in place instead: little-endian plain CDR (XCDR1) with its
4-byte header, in which primitives are aligned to their own size, counted from behind
the header.
"""

from array import array
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import ObservedParts, PartMesh
from shape_msgs.msg import Mesh

from ...base.errors import MeshError, RequestError
from . import part_requests, times

LITTLE_ENDIAN_CDR = b"\x00\x01"
HEADER = 4
TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")  # of the inertia, row by row
# At the end: Fast CDR leaves room for empty sequences that it does not write.
MAX_PADDING = 16


class NotPlainCdrError(Exception):
    """The bytes are in another encapsulation, or not what they should be."""


class ObservedArrays(NamedTuple):
    """Content of an `ObservedParts`; arrays view the buffer."""

    stamp: int  # nanoseconds
    frame_id: str
    part_id: str
    numbering: int  # 0: as the present result
    poses: NDArray[np.float64]  # (n, 7); position, and orientation x y z w
    confidence: NDArray[np.float64]  # (m,)
    from_pose: int  # -1: fresh landings
    feeder_setting: str


class _Cursor:
    """Reads along a buffer."""

    def __init__(self, data: bytes) -> None:
        if len(data) < HEADER or bytes(data[:2]) != LITTLE_ENDIAN_CDR:
            raise NotPlainCdrError
        self._data = data
        self._position = HEADER

    def array(self, count: int, kind: str) -> NDArray[Any]:
        """The next numbers; none are not aligned for."""
        dtype = np.dtype(kind)
        if not count:
            return np.zeros(0, dtype)
        start = self._position + -(self._position - HEADER) % dtype.itemsize
        self._position = start + count * dtype.itemsize
        if self._position > len(self._data):
            raise NotPlainCdrError
        return np.frombuffer(self._data, dtype, count, start)

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
        """Make sure that all was read, but for the padding of serialisers."""
        if len(self._data) - self._position >= MAX_PADDING:
            raise NotPlainCdrError


def _read_mesh(cursor: _Cursor) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    triangles = cursor.array(3 * cursor.count(), "<u4").reshape(-1, 3)
    return cursor.array(3 * cursor.count(), "<f8").reshape(-1, 3), triangles


def _read_observed_parts(data: bytes) -> ObservedArrays:
    cursor = _Cursor(data)
    # In the order of the message's fields.
    observed = ObservedArrays(
        stamp=cursor.stamp(),
        frame_id=cursor.text(),
        part_id=cursor.text(),
        numbering=int(cursor.array(1, "<u8")[0]),
        poses=cursor.array(7 * cursor.count(), "<f8").reshape(-1, 7),
        confidence=cursor.array(cursor.count(), "<f8"),
        from_pose=int(cursor.array(1, "<i4")[0]),
        feeder_setting=cursor.text(),
    )
    cursor.end()
    return observed


T = TypeVar("T")

# Triangles of a nested mesh in a request; each is a Python object to rclpy.
MAX_NESTED = 10_000
# Bytes of a message for rclpy's deserialiser: they become 25 times as many, 0.3 s a
# MiB.
MAX_DESERIALIZED = 4 * 2**20


def request_of_mesh_bytes(
    data: bytes, part_id: str, unit: float
) -> part_requests.PartRequest:
    """Take a serialised `shape_msgs/Mesh`; raises MeshError, RequestError."""

    def view(data: bytes) -> part_requests.PartRequest:
        cursor = _Cursor(data)
        vertices, triangles = _read_mesh(cursor)
        cursor.end()
        return part_requests.PartRequest(part_id, vertices, triangles, unit)

    return view_message(data, Mesh, view)


def request_of_part_bytes(data: bytes) -> part_requests.PartRequest:
    """Take a serialised `PartMesh`; raises MeshError, RequestError."""
    return view_message(data, PartMesh, _read_part_request)


def observed_parts(data: bytes, max_bytes: int) -> ObservedArrays:
    """Take a serialised `ObservedParts`; raises RequestError."""
    check_size(data, ObservedParts, max_bytes)
    return view_message(data, ObservedParts, _read_observed_parts)


def take_request(message: PartMesh, topic: str) -> part_requests.PartRequest:
    """Take a `PartMesh` that came in a request, and empty it; large ones by `topic`."""
    try:
        for name, max_count in (
            ("triangles", MAX_NESTED),
            ("vertices", 3 * MAX_NESTED),
        ):
            count = len(getattr(message.mesh, name))
            if count > max_count:
                raise RequestError(
                    f"a nested mesh of at most {max_count} {name} in a request",
                    f"{count}",
                    f"publish it on {topic} or use the flat arrays",
                )
        return request_of_part_bytes(serialize_message(message))
    finally:
        message.mesh = Mesh()
        message.vertices = array("d")
        message.triangles = array("I")


def has_mesh(message: PartMesh) -> bool:
    """Whether a request carries a part."""
    mesh = message.mesh
    arrays = (mesh.triangles, mesh.vertices, message.vertices, message.triangles)
    return any(map(len, arrays)) or message.mesh_resource != ""


def part_message(
    request: part_requests.PartRequest, part_id: str, stamp: int
) -> PartMesh:
    """What goes to the bag: flat arrays as received, under the part's final name."""
    message = PartMesh(
        part_id=part_id,
        vertices=pack_array(request.vertices),
        triangles=pack_array(request.triangles, "I"),
        unit=request.unit,
        body=request.body,
    )
    message.restitution, message.drop_height = request.scene_override
    message.header.stamp = times.time_message(stamp)
    inertia = message.inertia
    inertia.m = request.mass
    for axis, x in zip("xyz", request.center_of_mass.tolist(), strict=True):
        setattr(inertia.com, axis, x)
    tensor = request.inertia[np.triu_indices(3)].tolist()
    for name, moment in zip(TENSOR, tensor, strict=True):
        setattr(inertia, name, moment)
    return message


def pack_array(values: NDArray[Any], code: str = "d") -> Any:
    """A matrix row by row as an `array.array`, which rclpy takes as it is."""
    return array(code, np.ascontiguousarray(values, dtype=np.dtype(code)).tobytes())


def _read_part_request(data: bytes) -> part_requests.PartRequest:
    cursor = _Cursor(data)
    stamp = cursor.stamp()
    cursor.text()  # frame_id
    part_id = cursor.text()
    vertices, triangles = _read_mesh(cursor)
    flat_vertices = cursor.array(cursor.count(), "<f8")
    flat_triangles = cursor.array(cursor.count(), "<u4")
    unit, mass, x, y, z, *tensor, restitution, drop_height = cursor.array(
        13, "<f8"
    ).tolist()
    resource = cursor.text()
    resource_unit = cursor.text()
    body = int(cursor.array(1, "<i4")[0])
    cursor.end()
    name = part_requests.name_suffix(part_id)
    sizes = {
        "mesh": vertices.size + triangles.size,
        "the flat arrays": flat_vertices.size + flat_triangles.size,
        "mesh_resource": len(resource),
    }
    sources = [source for source, size in sizes.items() if size]
    if len(sources) != 1:
        raise MeshError(
            "one of mesh, the flat arrays vertices and triangles, and mesh_resource "
            f"filled{name}",
            " and ".join(sources) or "none",
            "fill exactly one",
        )
    if resource_unit and not resource:
        raise RequestError(
            f"mesh_resource_unit beside a mesh_resource only{name}",
            f"{part_requests.quote_text(resource_unit)} beside {sources[0]}",
            "the unit of arrays is `unit`, in metres",
        )
    if sources == ["the flat arrays"]:
        vertices = _rows(flat_vertices, f"vertices{name}")
        triangles = _rows(flat_triangles, f"triangles{name}")
    return part_requests.PartRequest(
        part_id,
        vertices,
        triangles,
        unit,
        mass,
        np.array([x, y, z]),
        np.array(tensor)[[0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(3, 3),
        (restitution, drop_height),
        stamp,
        resource,
        resource_unit,
        body,
    )


def _rows(values: NDArray[Any], name: str) -> NDArray[Any]:
    if values.size % 3:
        raise MeshError(
            f"a multiple of three numbers in {name}",
            f"{values.size}",
            "x y z a vertex, three vertex numbers a triangle",
        )
    return values.reshape(-1, 3)


def view_message(data: bytes, kind: type, view: Callable[[bytes], T]) -> T:
    """What a message holds, in place if it is in plain CDR; raises RequestError."""
    try:
        return view(data)
    except NotPlainCdrError:
        return view(serialize_message(deserialize(data, kind, MAX_DESERIALIZED)))


def deserialize(data: bytes, kind: type, max_bytes: int) -> Any:
    """The message that bytes are; raises RequestError."""
    check_size(data, kind, max_bytes)
    try:
        return deserialize_message(data, kind)
    except Exception as error:  # the bindings raise what they like
        raise RequestError(
            f"a serialised {kind.__name__}",
            f"{len(data)} bytes that are none ({type(error).__name__})",
            "check the publisher",
        ) from error


def check_size(data: bytes, kind: type, max_bytes: int) -> None:
    """Refuse what is too large for whoever reads it; raises RequestError."""
    if len(data) > max_bytes:
        in_place = (
            "; a mesh in plain little-endian CDR may be larger"
            if kind in (Mesh, PartMesh)
            else ""
        )
        raise RequestError(
            f"a {kind.__name__} of at most {max_bytes} bytes",
            f"{len(data)} bytes",
            f"check the publisher{in_place}",
        )
