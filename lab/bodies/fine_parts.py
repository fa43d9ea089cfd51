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

"""Finely divided parts with teeth, a thread, a bore; lengths in metres."""

import numpy as np
from manifold3d import CrossSection, Manifold, Mesh64

from ros_pose_stats.core.shapes.profiles import unit_circle

from .shapes import lofted

TEETH = 60
TIP = 0.031
ROOT = 0.0265
BORE = 0.006
FACE = 0.010
"""Of the gear: radii, and the width of its teeth."""

TURNS = 16
PITCH = 0.00125
CREST = 0.004
CORE = 0.0033
"""Of the screw's thread: radii of crests and core."""


def surface(body):
    """Vertices and triangles of a solid, welded."""
    mesh = body.to_mesh64()
    first = np.arange(body.num_prop_vert())
    first[np.asarray(mesh.merge_from_vert, dtype=np.int64)] = mesh.merge_to_vert
    return np.array(mesh.vert_properties)[:, :3], first[
        np.asarray(mesh.tri_verts, dtype=np.int64)
    ]


def gear(division=1):
    """A spur gear with a hub and a bore, axis z, its teeth in 0 <= z <= FACE.

    The first tooth is at a quarter of a pitch. Some 30 000 triangles times the square
    of the division.
    """
    steps = 40 * division
    angles = 2.0 * np.pi * np.arange(TEETH * steps) / (TEETH * steps)
    wave = np.clip(0.8 * np.sin(TEETH * angles) + 0.5, 0.0, 1.0)
    outline = (ROOT + (TIP - ROOT) * wave)[:, None] * np.stack(
        [np.cos(angles), np.sin(angles)], 1
    )
    teeth = Manifold.extrude(CrossSection([outline]), FACE, 4 * division)
    hub = Manifold.cylinder(1.6 * FACE, 0.010, circular_segments=192 * division)
    bore = Manifold.cylinder(2.0 * FACE, BORE, circular_segments=192 * division)
    return surface(teeth + hub - bore.translate((0.0, 0.0, -0.2 * FACE)))


def screw(sides=64):
    """A screw with a right-hand thread in z >= 0 and a hexagon head below.

    Some 300 000 triangles with 384 sides.
    """
    rings = TURNS * 24
    heights = np.linspace(0.0, TURNS * PITCH, rings + 1)[:, None]
    angles = 2.0 * np.pi * np.arange(sides) / sides
    phase = (heights / PITCH - angles / (2.0 * np.pi)) % 1.0
    flank = np.clip(1.3 - 1.6 * np.abs(2.0 * phase - 1.0), 0.0, 1.0)
    radii = CORE + (CREST - CORE) * flank
    corners = np.stack(
        np.broadcast_arrays(radii * np.cos(angles), radii * np.sin(angles), heights),
        axis=2,
    )
    ends = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, heights[-1, 0]]])
    vertices, triangles = lofted(corners, ends)
    shank = Manifold(Mesh64(vertices, triangles.astype(np.uint64)))
    head = Manifold.extrude(CrossSection([0.0075 * unit_circle(6)]), 0.0053)
    return surface(shank + head.translate((0.0, 0.0, -0.0053)))
