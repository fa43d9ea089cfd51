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

"""Parts as messages, and what the library says of the same parts."""

import itertools
from array import array

import numpy as np
import trimesh
from geometry_msgs.msg import Inertia, Point, Vector3
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh, MeshTriangle

from ros_pose_stats import part_from_mesh

NUMBERS = itertools.count(1)

_HULL = trimesh.convex.convex_hull(
    np.array(
        [
            (0.0, 0.0, 0.0),
            (0.04, 0.0, 0.0),
            (0.04, 0.03, 0.0),
            (0.0, 0.03, 0.0),
            (0.01, 0.005, 0.02),
            (0.03, 0.01, 0.025),
            (0.012, 0.028, 0.018),
        ]
    )
)
WEDGE = np.asarray(_HULL.vertices), np.asarray(_HULL.faces)
"""A body with several stable poses and no symmetry, in metres."""


def scaled(factor):
    """The wedge in another size."""
    return factor * WEDGE[0], WEDGE[1]


def fine_box(triangles, length=0.04):
    """A box of 4 : 3 : 2 whose faces are grids of about so many triangles, with eight
    corners.
    """
    cells = max(1, round((triangles / 12) ** 0.5))
    u, v = (grid.ravel() for grid in np.mgrid[: cells + 1, : cells + 1])
    corner = np.flatnonzero((u < cells) & (v < cells))
    below = corner + cells + 1
    right = corner + 1
    top = np.concatenate(
        [np.stack((corner, below, right), 1), np.stack((right, below, below + 1), 1)]
    )
    face = np.column_stack((u, v, np.full(u.shape, cells)))
    turned = [np.roll(face, axis, axis=1) for axis in range(3)]
    sides = [
        *turned,
        *(cells - corners for corners in turned),
    ]  # seen through the middle
    faces = [top, top, top, *3 * [top[:, ::-1]]]
    points = np.concatenate(sides)
    rows = np.concatenate([face + k * len(u) for k, face in enumerate(faces)])
    _, first, inverse = np.unique(
        points, axis=0, return_index=True, return_inverse=True
    )
    return (
        points[first] / cells * (length, 0.75 * length, 0.5 * length),
        inverse.ravel()[rows].astype(np.uint32),
    )


def new_id():
    """A part_id that no other test uses."""
    return f"part_{next(NUMBERS)}"


def mesh(surface):
    """A `shape_msgs/Mesh`."""
    vertices, triangles = surface
    return Mesh(
        vertices=[Point(x=float(x), y=float(y), z=float(z)) for x, y, z in vertices],
        triangles=[
            MeshTriangle(vertex_indices=np.array(row, dtype=np.uint32))
            for row in triangles
        ],
    )


def flat(surface, part_id="", **fields):
    """A `PartMesh` with the flat arrays."""
    vertices, triangles = surface
    message = PartMesh(part_id=part_id, **fields)
    message.vertices = array(
        "d", np.ascontiguousarray(vertices, dtype=np.float64).tobytes()
    )
    message.triangles = array(
        "I", np.ascontiguousarray(triangles, dtype=np.uint32).tobytes()
    )
    return message


def nested(surface, part_id="", **fields):
    """A `PartMesh` with a nested mesh."""
    return PartMesh(part_id=part_id, mesh=mesh(surface), **fields)


def inertia_of(part):
    """Mass properties of a part as a message."""
    x, y, z = part.inertia.tolist()
    com = Vector3(**dict(zip("xyz", part.center_of_mass.tolist(), strict=True)))
    return Inertia(
        m=part.mass, com=com, ixx=x[0], ixy=x[1], ixz=x[2], iyy=y[1], iyz=y[2], izz=z[2]
    )


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


def prism(sides, radius, length):
    """A regular prism along z, with the corners of its ends on circles."""
    hull = trimesh.creation.cylinder(radius, length, sections=sides)
    return np.asarray(hull.vertices), np.asarray(hull.faces)
