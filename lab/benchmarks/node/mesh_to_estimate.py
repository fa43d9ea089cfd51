"""Time from the publishing of a mesh to the latched estimate, beside that of
subscriptions.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from itertools import count
from statistics import median

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import serialize_message
from scipy.spatial import ConvexHull

from lab.bodies.curved import Body
from lab.frame.results import Row, Section
from lab.frame.timing import Contender, Pace, Timings, race
from ros_pose_stats import estimate, part_from_mesh
from ros_pose_stats.node.messages.part_messages import part_message
from ros_pose_stats.node.messages.part_requests import PartRequest

from .client import Client
from .spread import beyond, spread

PART_TOPIC = "/pose_stats/part_mesh"
CAD_TOPIC = "/benchmark/cad"
FLAT = "PartMesh"
STANDARD = "shape_msgs/Mesh"
NEW = "PartMesh, new name"
HULL = "hull"
LIBRARY = "library"

TIMED = (
    "From the publishing of an already serialised mesh to the arrival of its latched "
    "`PoseStatistics`, another mesh each time (larger by a millionth), so nothing is "
    "answered from memory. `PartMesh` has flat arrays; `shape_msgs/Mesh` comes on a "
    "topic of `mesh_topics`; with a new name the part's publisher is new as well and "
    "has to be found by the subscriber. `hull`: `scipy.spatial.ConvexHull` of the same "
    "vertices in the client's process, in turns with the messages; `beyond the hull` "
    "is the median difference. `library`: `part_from_mesh` and `estimate` there, "
    "without messages, bag and process. All vertices of a rounded box are on the hull, "
    "half of those of a ring. The 99th percentile of fewer than 100 runs is the "
    "largest."
)


def mesh_to_estimate(client: Client, bodies: Sequence[Body], pace: Pace) -> Section:
    """Two rows for each body, and one of the first body with ever new names."""
    rows = []
    for body in bodies:
        names = (FLAT, STANDARD, NEW) if body is bodies[0] else (FLAT, STANDARD)
        timings = race([*_scale(body), *senders(client, body, names)], pace)
        rows += [_row(timings, body, name) for name in names]
    return Section(
        "mesh_to_estimate", "From the mesh to the latched estimate", TIMED, tuple(rows)
    )


def _scale(body: Body) -> list[Contender]:
    """Contenders that do the same in this process, for scale."""
    fresh = Fresh(body)

    def library(vertices: NDArray[np.float64]) -> object:
        return estimate(part_from_mesh(vertices, body.triangles), "split")

    library(fresh())  # loads the kernels
    return [Contender(HULL, ConvexHull, fresh), Contender(LIBRARY, library, fresh)]


def senders(client: Client, body: Body, names: Sequence[str]) -> Iterator[Contender]:
    """Contenders through the node; their topics and, but for new names, parts are known
    to it.
    """
    numbers = count()
    for name in names:
        topic = CAD_TOPIC if name == STANDARD else PART_TOPIC
        prepare = _maker(name, Fresh(body), numbers)

        def send(message: tuple[bytes, str], topic: str = topic) -> object:
            return client.publish_until_latched(topic, *message)

        send(prepare())
        yield Contender(name, send, prepare)


def _maker(
    name: str, fresh: Fresh, numbers: count[int]
) -> Callable[[], tuple[bytes, str]]:
    """Return a function that makes message and digest of another mesh at each call."""
    triangles = fresh.body.triangles

    def make() -> tuple[bytes, str]:
        vertices = fresh()
        digest = part_from_mesh(vertices, triangles).digest
        if name == STANDARD:
            return mesh_bytes(vertices, triangles), digest
        part_id = f"ring_{next(numbers)}" if name == NEW else "ring"
        return part_mesh_bytes(part_id, vertices, triangles), digest

    return make


def _row(timings: Timings, body: Body, name: str) -> Row:
    seconds = timings.seconds
    return Row(
        f"{body.name}, {name}",
        {
            **spread(seconds[name]),
            "hull, ms": 1e3 * median(seconds[HULL]),
            "beyond the hull, ms": beyond(seconds[name], seconds[HULL]),
            "library, ms": 1e3 * median(seconds[LIBRARY]),
            "beyond the library, ms": beyond(seconds[name], seconds[LIBRARY]),
        },
    )


STEP = 1e-6


_numbers = count(1)


class Fresh:
    """Slightly larger copies of a body, each of which is new to the node."""

    def __init__(self, body: Body) -> None:
        self.body = body

    def __call__(self) -> NDArray[np.float64]:
        """Vertices of the next copy."""
        return self.body.vertices * (1.0 + STEP * next(_numbers))


def part_mesh_bytes(
    part_id: str, vertices: NDArray[np.float64], triangles: NDArray[np.int64]
) -> bytes:
    """A `PartMesh` with flat arrays, serialised."""
    request = PartRequest(part_id, vertices, triangles.astype(np.uint32))
    return bytes(serialize_message(part_message(request, part_id, 0)))


def mesh_bytes(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> bytes:
    """A `shape_msgs/Mesh`, serialised without an object for each vertex and
    triangle.
    """
    head = struct.pack("<I", len(triangles)) + triangles.astype("<u4").tobytes()
    head += struct.pack("<I", len(vertices))
    head += bytes(-len(head) % 8)
    return b"\x00\x01\x00\x00" + head + vertices.astype("<f8").tobytes()
