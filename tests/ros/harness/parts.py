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
