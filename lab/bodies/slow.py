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

"""Meshes that are slow to check."""

import numpy as np
import trimesh

from . import shapes

ROUND = shapes.hull_mesh(shapes.sphere_points(1200, 3) * (0.02, 0.03, 0.04))


def smooth_body(triangles, length=0.04):
    """An ellipsoid: every vertex is a corner of the hull, which takes time."""
    rings = max(4, round((triangles / 4) ** 0.5))
    ball = trimesh.creation.uv_sphere(count=[rings, rings])
    return (
        np.asarray(ball.vertices) * [0.5, 0.4, 0.3] * length,
        np.asarray(ball.faces, dtype=np.uint32),
    )


def slivers(triangles, length=0.04):
    """Needles across each other: tetrahedra a million times longer than they are thick.

    Whether they reach into each other is looked for as long as it may be.
    """
    chance = np.random.default_rng(0)
    count = triangles // 4
    ends = chance.uniform(-0.5, 0.5, (2, count, 3)) * length
    offset = chance.normal(size=(2, count, 3)) * 1e-6 * length
    corners = np.stack([ends[0], ends[1], ends[0] + offset[0], ends[0] + offset[1]], 1)
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1])
    corners[volume < 0.0, 2:] = corners[volume < 0.0, 3:1:-1]
    rows = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    starts = 4 * np.arange(count)[:, None, None]
    return corners.reshape(-1, 3), (rows + starts).reshape(-1, 3).astype(np.uint32)
