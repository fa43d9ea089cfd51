"""Parts as messages, and what the library says of the same parts."""

from __future__ import annotations

import itertools
from array import array

import numpy as np
from geometry_msgs.msg import Point
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh, MeshTriangle

from ros_pose_stats import part_from_mesh, shapes

NUMBERS = itertools.count(1)

WEDGE = shapes.hull_mesh(np.array([
    (0.0, 0.0, 0.0), (0.04, 0.0, 0.0), (0.04, 0.03, 0.0), (0.0, 0.03, 0.0), (0.01, 0.005, 0.02),
    (0.03, 0.01, 0.025), (0.012, 0.028, 0.018)]))
"""A body with several stable poses and no symmetry, in metres."""


def fine_box(triangles, length=0.04):
    """A box whose six faces are grids: many triangles, eight corners of the hull.

    Returns
    -------
    vertices : (V, 3) array
        Metres.
    triangles : (T, 3) array
        About as many as were asked for.
    """
    cells = max(1, round((triangles / 12) ** 0.5))
    ticks = np.arange(cells + 1)
    u, v = (grid.ravel() for grid in np.meshgrid(ticks, ticks, indexing="ij"))
    faces = []
    for axis in range(3):
        for side in (0, cells):
            corners = np.empty((len(u), 3), dtype=np.int64)
            corners[:, axis] = side
            corners[:, (axis + 1) % 3], corners[:, (axis + 2) % 3] = (u, v) if side else (v, u)
            faces.append(corners)
    points = np.concatenate(faces)
    names = (points[:, 0] * (cells + 1) + points[:, 1]) * (cells + 1) + points[:, 2]
    _, first, place = np.unique(names, return_index=True, return_inverse=True)
    place = place.reshape(6, cells + 1, cells + 1)
    a, b, c, d = place[:, :-1, :-1], place[:, 1:, :-1], place[:, 1:, 1:], place[:, :-1, 1:]
    rows = np.concatenate([np.stack(one, -1).reshape(-1, 3) for one in ((a, b, c), (a, c, d))])
    sides = np.array([1.0, 0.75, 0.5]) * length
    return points[first] / cells * sides, rows.astype(np.uint32)


def new_id():
    """A part_id that no other test uses."""
    return f"part_{next(NUMBERS)}"


def mesh(surface):
    """A `shape_msgs/Mesh`."""
    vertices, triangles = surface
    return Mesh(
        vertices=[Point(x=float(x), y=float(y), z=float(z)) for x, y, z in vertices],
        triangles=[MeshTriangle(vertex_indices=np.array(row, dtype=np.uint32))
                   for row in triangles])


def flat(surface, part_id="", **fields):
    """A `PartMesh` with the flat arrays."""
    vertices, triangles = surface
    message = PartMesh(part_id=part_id, **fields)
    message.vertices = array("d", np.ascontiguousarray(vertices, dtype=np.float64).tobytes())
    message.triangles = array("I", np.ascontiguousarray(triangles, dtype=np.uint32).tobytes())
    return message


def nested(surface, part_id="", **fields):
    """A `PartMesh` with a nested mesh."""
    return PartMesh(part_id=part_id, mesh=mesh(surface), **fields)


def library_part(surface, part_id="", **mass_properties):
    """The part in this process."""
    return part_from_mesh(*surface, part_id=part_id, **mass_properties)


def counts(poses):
    """Counts by index, of messages and of records."""
    return {pose.index: pose.count for pose in poses}


def probabilities(poses):
    return {pose.index: pose.probability for pose in poses}


def whole(message):
    """A message as text: equal messages are, with their NaN."""
    return str(message)
