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

"""Shapes of CAD systems to arrays, by the `tessellate` that all of them have.

FreeCAD, CadQuery and build123d all stand on OpenCASCADE. None of them is imported: a
shape is asked for triangles, first roughly for its size, then as finely as that size
wants.
"""

from typing import Any

import numpy as np

from ...base.errors import MeshError, reason
from ..records import Array, Index
from .arrays import real_array

MILLIMETRE = 1e-3  # of the unit in which CAD systems have their shapes, metres

_ROUGH = 1.0
"""Largest distance from the true surface, in the shape's unit, where only the size is
asked for: OpenCASCADE bounds the angle between facets as well, so that a part which is
smaller than that comes out with all its corners, too."""

_FINE = 1e-3
"""The same as a fraction of the largest extent. It bounds long arcs; rims have some 125
sides, whatever their size, by the angle that the systems bound on their own. A finer
one takes FreeCAD minutes for a torus."""


def tessellate(shape: Any) -> tuple[Array, Index]:
    """Vertices (V, 3) and triangles (T, 3) of a shape, in its own unit.

    `shape.tessellate(tolerance)` returns points and triples of their numbers; the
    points are sequences of three numbers (FreeCAD, build123d), or have `toTuple`
    (CadQuery).
    """
    rough, _ = _tessellation(shape, _ROUGH)
    extent = float(np.ptp(rough, axis=0).max()) if len(rough) else 0.0
    if not extent > 0.0:
        raise MeshError(
            "a shape with a volume",
            f"{type(shape).__name__} without triangles",
            "make sure that the shape was computed",
        )
    return _tessellation(shape, _FINE * extent)


def _tessellation(shape: Any, tolerance: float) -> tuple[Array, Index]:
    try:
        points, corners = shape.tessellate(tolerance)
        coordinates = [
            point.toTuple() if hasattr(point, "toTuple") else tuple(point)
            for point in points
        ]
        return (
            real_array(coordinates).reshape(-1, 3),
            np.array(corners, dtype=np.int64).reshape(-1, 3),
        )
    except Exception as error:  # each CAD system has errors of its own
        raise MeshError(
            "points and triangles from tessellate(tolerance)",
            f"{type(shape).__name__} ({reason(error)})",
            "give vertices and triangles",
        ) from error
