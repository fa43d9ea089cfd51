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

"""Meshes as files have them, before NumPy is loaded: made in the reading process."""

import array
from itertools import pairwise
from typing import NamedTuple

Rows = tuple[float, ...]
"""Three rows of a matrix (4, 4), one after the other."""

IDENTITY: Rows = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
"""Rows of a matrix that leaves everything in its place."""


class RefusedError(Exception):
    """What was expected, what came, and what to do; never what the file says."""


class RawMesh:
    """Coordinates, three a vertex, and numbers of vertices, three a triangle."""

    def __init__(self) -> None:
        self.vertices = array.array("d")
        self.corners = array.array("q")

    def add_polygon(self, polygon: list[int]) -> None:
        """Add the triangles of a face from its first vertex on."""
        for second, third in pairwise(polygon[1:]):
            self.corners.extend((polygon[0], second, third))

    def check_corners(self) -> None:
        """Refuse triangles between vertices that are not there."""
        count = len(self.vertices) // 3
        corners = self.corners
        if corners and not 0 <= min(corners) <= max(corners) < count:
            raise RefusedError(
                "triangles between vertices of their object",
                "others",
                "export it again",
            )


class RawScene(NamedTuple):
    """What a file holds."""

    meshes: list[RawMesh]
    placed: list[tuple[int, Rows]]  # number of a mesh, and the matrix that places it
    unit: float | None = None  # metres, as the file declares


def scene_of(mesh: RawMesh) -> RawScene:
    """A file of one mesh."""
    return RawScene([mesh], [(0, IDENTITY)])


def multiply(first: Rows, second: Rows) -> Rows:
    """The matrix that does the second, then the first."""
    if first is IDENTITY or second is IDENTITY:
        return second if first is IDENTITY else first
    return tuple(
        sum(first[4 * row + k] * second[4 * k + column] for k in range(3))
        + (first[4 * row + 3] if column == 3 else 0.0)
        for row in range(3)
        for column in range(4)
    )
