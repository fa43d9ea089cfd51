"""Bodies of about a number of triangles, and their serialised messages."""

from __future__ import annotations

import struct
from itertools import count

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import serialize_message

from ros_pose_stats.ros.messages.part_messages import part_message
from ros_pose_stats.ros.parts.part_requests import PartRequest

from ..bodies import Body, rounded_box

STEP = 1e-6
LENGTH = 0.05
"""Metres."""


def ring(triangles: int) -> Body:
    """Flat elliptic ring, a torus: half of its vertices are on the hull."""
    around = max(3, round((triangles / 10) ** 0.5))
    along = max(3, triangles // (2 * around))
    turn = 2.0 * np.pi * np.arange(along)[:, None] / along
    tube = 2.0 * np.pi * np.arange(around)[None, :] / around
    out = 1.0 + 0.3 * np.cos(tube)
    vertices = np.stack((out * np.cos(turn), 0.8 * out * np.sin(turn),
                         np.broadcast_to(0.2 * np.sin(tube), (along, around))), axis=-1)
    i, j = (grid.ravel() for grid in np.indices((along, around)))
    here, beside = i * around + j, i * around + (j + 1) % around
    ahead, across = ((i + 1) % along * around + k for k in (j, (j + 1) % around))
    corners = np.stack((here, ahead, across, here, across, beside), axis=-1)
    return Body(f"ring, {len(here) * 2} triangles", LENGTH * vertices.reshape(-1, 3),
                corners.reshape(-1, 3))


def rounded(triangles: int) -> Body:
    """Rounded box: all of its vertices are on the hull."""
    body = rounded_box(max(1, round((triangles / 8.0) ** 0.5 - 1.5)))
    return Body(f"rounded box, {len(body.triangles)} triangles", LENGTH * body.vertices,
                body.triangles)


_numbers = count(1)


class Fresh:
    """Slightly larger copies of a body: the node has seen none of them."""

    def __init__(self, body: Body) -> None:
        self.body = body

    def __call__(self) -> NDArray[np.float64]:
        """Vertices of the next one."""
        return self.body.vertices * (1.0 + STEP * next(_numbers))


def part_mesh_bytes(part_id: str, vertices: NDArray[np.float64],
                    triangles: NDArray[np.int64]) -> bytes:
    """A `PartMesh` with flat arrays, serialised."""
    request = PartRequest(part_id, vertices, triangles.astype(np.uint32))
    return bytes(serialize_message(part_message(request, part_id, 0)))


def mesh_bytes(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> bytes:
    """A `shape_msgs/Mesh`, serialised without an object for each vertex and triangle."""
    before = struct.pack("<I", len(triangles)) + triangles.astype("<u4").tobytes()
    before += struct.pack("<I", len(vertices))
    before += bytes(-len(before) % 8)
    return b"\x00\x01\x00\x00" + before + vertices.astype("<f8").tobytes()
