"""Between part messages and what the core works on; pure functions."""

from array import array
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh

from ...errors import MeshError, RequestError
from . import mesh_views, part_requests, times

T = TypeVar("T")

MOST_NESTED = 10_000  # triangles of a nested mesh in a request; each is a Python object to rclpy
MOST_DESERIALIZED = 4 * 2**20
"""Bytes of a message that has to go through rclpy's deserialiser, in which they may become 25
times as many and take a third of a second for each of them [MiB]."""


def request_of_mesh_bytes(data: bytes, part_id: str, unit: float) -> part_requests.PartRequest:
    """Take a serialised `shape_msgs/Mesh`; raises MeshError, RequestError."""
    vertices, triangles = see(data, Mesh, mesh_views.mesh_numbers)
    return part_requests.PartRequest(part_id, vertices, triangles, unit)


def request_of_part_bytes(data: bytes) -> part_requests.PartRequest:
    """Take a serialised `PartMesh`; raises MeshError, RequestError."""
    return _request(see(data, PartMesh, mesh_views.part_mesh_numbers))


def taken_request(message: PartMesh) -> part_requests.PartRequest:
    """Take a `PartMesh` that came in a request, and let go of what it holds."""
    try:
        for name, most in (("triangles", MOST_NESTED), ("vertices", 3 * MOST_NESTED)):
            count = len(getattr(message.mesh, name))
            if count > most:
                raise RequestError(f"a nested mesh of at most {most} {name} in a request",
                                   f"{count}", "publish it on ~/part_mesh or use the flat arrays")
        return request_of_part_bytes(serialize_message(message))
    finally:
        let_go(message)


def let_go(message: PartMesh) -> None:
    """Let go of the mesh that a message holds."""
    message.mesh, message.vertices, message.triangles = Mesh(), array("d"), array("I")


def mesh_size(message: PartMesh) -> tuple[int, int]:
    """Triangles and vertices that a message holds, about."""
    return (len(message.triangles) // 3 + len(message.mesh.triangles),
            len(message.vertices) // 3 + len(message.mesh.vertices))


def is_given(message: PartMesh) -> bool:
    """Whether a request carries a part."""
    return bool(len(message.mesh.triangles) or len(message.mesh.vertices)
                or len(message.vertices) or len(message.triangles))


def part_message(request: part_requests.PartRequest, part_id: str, stamp: int) -> PartMesh:
    """What goes to the bag: flat arrays as received, under the part's final name."""
    message = PartMesh()
    message.header.stamp = times.time_message(stamp)
    message.part_id = part_id
    message.vertices = flat(request.vertices)
    message.triangles = flat(request.triangles, "I")
    message.unit, message.inertia.m = request.unit, request.mass
    (message.inertia.com.x, message.inertia.com.y,
     message.inertia.com.z) = (float(x) for x in request.center_of_mass)
    tensor = request.inertia
    for name, value in zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
                           tensor[np.triu_indices(3)], strict=True):
        setattr(message.inertia, name, float(value))
    message.restitution, message.drop_height = request.restitution, request.drop_height
    return message


def flat(values: NDArray[Any], code: str = "d") -> Any:
    """A matrix row by row as an `array.array`, which rclpy takes as it is."""
    return array(code, np.ascontiguousarray(values, dtype=np.dtype(code)).tobytes())


def _request(numbers: mesh_views.Numbers) -> part_requests.PartRequest:
    nested = numbers.mesh_vertices.size + numbers.mesh_triangles.size > 0
    flat = numbers.vertices.size + numbers.triangles.size > 0
    if nested == flat:
        filled = "both" if nested else "neither"
        raise MeshError("either mesh or the flat arrays vertices and triangles filled", filled,
                        "fill exactly one of the two")
    vertices, triangles = numbers.mesh_vertices, numbers.mesh_triangles
    if flat:
        vertices = _rows(numbers.vertices, "vertices")
        triangles = _rows(numbers.triangles, "triangles")
    values = numbers.scalars
    inertia = values[[5, 6, 7, 6, 8, 9, 7, 9, 10]].reshape(3, 3)
    return part_requests.PartRequest(
        numbers.part_id, vertices, triangles, float(values[0]), float(values[1]),
        np.array(values[2:5]), inertia, float(values[11]), float(values[12]), numbers.stamp)


def _rows(values: NDArray[Any], name: str) -> NDArray[Any]:
    if values.size % 3:
        raise MeshError(f"a multiple of three numbers in {name}", f"{values.size}",
                        "x y z a vertex, three vertex numbers a triangle")
    return values.reshape(-1, 3)


def see(data: bytes, kind: type, view: Callable[[bytes], T]) -> T:
    """What a message holds, in place if it is in plain CDR; raises RequestError."""
    try:
        return view(data)
    except mesh_views.NotPlainCdrError:
        return view(serialize_message(deserialized(data, kind, MOST_DESERIALIZED)))


def deserialized(data: bytes, kind: type, most: int) -> Any:
    """The message that bytes are; raises RequestError."""
    if len(data) > most:
        raise RequestError(f"a {kind.__name__} of at most {most} bytes", f"{len(data)} bytes",
                           "check the publisher; a mesh in plain little-endian CDR may be larger")
    try:
        return deserialize_message(data, kind)
    except Exception as error:  # the bindings raise what they like
        raise RequestError(f"a serialised {kind.__name__}", f"{len(data)} bytes that are none "
                           f"({type(error).__name__})", "check the publisher") from error
