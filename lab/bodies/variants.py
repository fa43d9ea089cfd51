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

"""The same body given differently: turned, moved, rounded, in another order, cut finer.

A surface is a pair of vertices (V, 3) and outward triangles (T, 3).
"""

import numpy as np
from scipy.spatial.transform import Rotation


def rotation(seed):
    """Random rotation matrix."""
    return Rotation.random(random_state=np.random.RandomState(seed)).as_matrix()


def moved(surface, turn=None, offset=(0.0, 0.0, 0.0), scale=1.0):
    """Turned, scaled and then shifted."""
    vertices, triangles = surface
    turned = vertices if turn is None else vertices @ np.asarray(turn).T
    return turned * scale + np.asarray(offset), triangles


def size(surface):
    """Largest extent along the axes."""
    return float(np.ptp(surface[0], axis=0).max())


def in_float32(surface):
    """Coordinates as an STL file stores them."""
    vertices, triangles = surface
    return vertices.astype(np.float32).astype(np.float64), triangles


def shuffled(surface, seed):
    """Vertices and triangles in another order, each triangle from another corner."""
    random = np.random.default_rng(seed)
    vertices, triangles = surface
    order = random.permutation(len(vertices))
    mixed = np.argsort(order)[triangles][random.permutation(len(triangles))]
    start = random.integers(3, size=len(mixed))[:, None]
    return vertices[order], np.take_along_axis(
        mixed, (start + np.arange(3)) % 3, axis=1
    )


def subdivided(surface):
    """Each triangle cut into four at the middles of its edges."""
    vertices, triangles = surface
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    middle = vertices[unique].mean(axis=1)
    a, b, c = triangles.T
    ab, bc, ca = (index.reshape(-1, 3) + len(vertices)).T
    fine = np.concatenate(
        [
            np.column_stack(corners)
            for corners in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        ]
    )
    return np.vstack((vertices, middle)), fine


def starred(surface, seed):
    """Each triangle cut into three at a random point in it."""
    vertices, triangles = surface
    weights = np.random.default_rng(seed).dirichlet((3.0, 3.0, 3.0), len(triangles))
    inner = np.einsum("tc,tcx->tx", weights, vertices[triangles])
    a, b, c = triangles.T
    new = len(vertices) + np.arange(len(triangles))
    fine = np.concatenate(
        [
            np.column_stack(corners)
            for corners in ((a, b, new), (b, c, new), (c, a, new))
        ]
    )
    return np.vstack((vertices, inner)), fine


def printed(surface, digits=6):
    """As a text file holds it."""
    vertices, triangles = surface
    return np.array(
        [[float(f"{x:.{digits}g}") for x in row] for row in vertices]
    ), triangles


def joined(*surfaces):
    """Several surfaces as one mesh."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in surfaces[:-1])])
    return (
        np.vstack([vertices for vertices, _ in surfaces]),
        np.vstack(
            [
                np.asarray(triangles) + start
                for (_, triangles), start in zip(surfaces, starts, strict=True)
            ]
        ),
    )
