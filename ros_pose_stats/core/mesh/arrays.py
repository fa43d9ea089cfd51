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

"""Numbers and triangle meshes that callers pass: checked, then welded and in order."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...base.errors import MeshError
from .. import tolerances
from ..kernels.mesh import connections, measures, nearness
from ..records import Array, Index, Mask

NOT_NUMBERS = (TypeError, ValueError, OverflowError)
"""Errors that the functions below raise for values that are no real numbers."""

# Complex numbers, dates and durations convert to floats, but not without losing their
# meaning.
_NOT_REAL = "cMm"

# Beyond these the fifth power of a length in the inertia leaves the range of float64.
_SMALLEST_EXTENT = 1e-50
_LARGEST_EXTENT = 1e50


def unmask(values: Any) -> NDArray[Any]:
    """Convert to an array; masked entries are missing, so they become NaN."""
    array = np.asarray(values)
    if array.dtype.kind in _NOT_REAL:
        raise TypeError(f"{array.dtype} is no real number")
    if array.dtype == object and any(map(np.iscomplexobj, array.flat)):
        raise TypeError("a complex number is no real number")
    if isinstance(values, np.ma.MaskedArray) and np.any(values.mask):
        numbers: Any = values.astype(np.float64)
        return np.asarray(numbers.filled(np.nan))
    return array


def real_array(values: Any) -> Array:
    """Convert to float64, without a copy where it is that already.

    Too large numbers: infinite.
    """
    # A signalling NaN becomes a quiet one.
    with np.errstate(over="ignore", invalid="ignore"):
        return unmask(values).astype(np.float64, copy=False)


def real_number(value: Any) -> float:
    """Convert one number to a float."""
    if np.ndim(value) > 0:
        raise TypeError("an array is no number")
    return float(real_array(value))


def number_or_nan(value: Any) -> float:
    """Convert one number to a float; NaN for what is none."""
    try:
        return real_number(value)
    except NOT_NUMBERS:
        return np.nan


def check_mesh(
    vertices: ArrayLike, triangles: ArrayLike, unit: float
) -> tuple[Array, NDArray[np.uint32]]:
    """Copy a mesh into arrays of its own.

    Vertices (V, 3) in metres, triangles (T, 3) uint32.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        metres = np.ascontiguousarray(_numbers(vertices, "vertices") * unit)
    if metres.ndim != 2 or metres.shape[1] != 3:
        raise MeshError(
            "vertices of shape (V, 3)",
            f"shape {metres.shape}",
            "give one x y z row a vertex",
        )
    if not np.isfinite(metres).all():
        row = int(np.flatnonzero(~np.isfinite(metres).all(axis=1))[0])
        raise MeshError(
            "finite vertices",
            f"{metres[row].tolist()} at vertex {row}",
            "export the mesh again",
        )
    corners = _indices(triangles, len(metres))
    with np.errstate(over="ignore"):
        extent = extent_of(remove_unused(metres, corners)[0])
    if extent != 0.0 and not _SMALLEST_EXTENT < extent < _LARGEST_EXTENT:
        raise MeshError(
            f"an extent from {_SMALLEST_EXTENT:g} to {_LARGEST_EXTENT:g} m",
            f"{extent:g} m",
            "check the unit",
        )
    return metres, corners


def _numbers(values: ArrayLike, noun: str) -> Array:
    """Make a float64 array of whatever was given."""
    try:
        return real_array(values)
    except NOT_NUMBERS as error:
        raise MeshError(
            f"{noun} as rows of three numbers",
            f"{type(values).__name__} ({error})",
            "give a list of rows or an array",
        ) from error


def _indices(triangles: ArrayLike, vertex_count: int) -> NDArray[np.uint32]:
    """Triangles (T, 3) as uint32, each number below `vertex_count`."""
    try:
        numbers = unmask(triangles)
    except ValueError as error:
        raise MeshError(
            "triangles of shape (T, 3)", f"{error}", "split polygons into triangles"
        ) from error
    except TypeError as error:
        raise MeshError(
            "triangles as rows of three numbers",
            f"{error}",
            "give a list of rows or an array of integers",
        ) from error
    if numbers.size == 0:
        raise MeshError(
            "at least four triangles", "none", "a point cloud is not a part"
        )
    if numbers.ndim != 2 or numbers.shape[1] != 3:
        raise MeshError(
            "triangles of shape (T, 3)",
            f"shape {numbers.shape}",
            "split polygons into triangles",
        )
    if numbers.dtype.kind not in "iu":
        numbers = _numbers(numbers, "triangles")
        is_whole = np.isfinite(numbers) & (np.floor(numbers) == numbers)
        if not is_whole.all():
            row, column = (int(k[0]) for k in np.nonzero(~is_whole))
            raise MeshError(
                "whole vertex numbers",
                f"{numbers[row, column]} in triangle {row}",
                "give integers",
            )
    if numbers.min() < 0 or numbers.max() >= vertex_count:
        is_outside = (numbers < 0) | (numbers >= vertex_count)
        row, column = (int(k[0]) for k in np.nonzero(is_outside))
        raise MeshError(
            f"vertex numbers from 0 to {vertex_count - 1}",
            f"{int(numbers[row, column])} in triangle {row}",
            "count vertices from 0",
        )
    return np.ascontiguousarray(numbers.astype(np.uint32))


def weld(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """Merge vertices within `WELD` of the extent and drop collapsed triangles.

    Returns the first of coincident vertices; the very array given when nothing changes.
    """
    vertices, triangles = remove_unused(vertices, triangles)
    if len(triangles) == 0:
        return vertices, triangles
    low, high = measures.bounds(vertices)
    extent = float((high - low).max())
    if extent == 0.0:
        return vertices[:1], triangles[:0]
    representative = nearness.first_of_coincident(
        vertices, low, tolerances.WELD * extent
    )
    kept, remaining = connections.merge_corners(representative, triangles)
    if len(kept) == len(vertices) and len(remaining) == len(triangles):
        return vertices, triangles
    return vertices[kept], remaining


def mask_of(rows: NDArray[Any], count: int) -> Mask:
    """Which of so many rows (count,) are among some, given by number."""
    mask = np.zeros(count, dtype=bool)
    mask[rows] = True
    return mask


def remove_collapsed(triangles: NDArray[Any]) -> NDArray[Any]:
    """Leave out triangles with a repeated corner."""
    a, b, c = triangles.T
    is_whole = (a != b) & (b != c) & (c != a)
    return triangles if is_whole.all() else triangles[is_whole]


def remove_unused(
    vertices: Array, triangles: NDArray[Any]
) -> tuple[Array, NDArray[Any]]:
    """Leave out vertices of no triangle; the very arrays given when there are none."""
    is_used = mask_of(triangles.ravel(), len(vertices))
    if is_used.all():
        return vertices, triangles
    return vertices[is_used], (np.cumsum(is_used) - 1)[triangles]


def extent_of(points: Array) -> float:
    """Largest extent of points (N, 3) along an axis, N at least 1."""
    low, high = measures.bounds(np.ascontiguousarray(points))
    return float((high - low).max())


def sort_triangles(triangles: Index) -> Index:
    """Triangles in the order of their corners, whatever order a modeller had."""
    lowest_corner = triangles.argmin(axis=1)[:, None]
    rows = np.take_along_axis(triangles, (lowest_corner + np.arange(3)) % 3, axis=1)
    return np.asarray(rows[np.lexsort(rows.T[::-1])])


def coordinate_rounding(vertices: ArrayLike, triangles: NDArray[np.uint32]) -> float:
    """Largest rounding error of the coordinates (V, 3), in their unit.

    Those that are all float32 numbers come from a file that stores no more (STL,
    mostly).
    """
    points = remove_unused(real_array(vertices), triangles)[0]
    magnitude, is_single = measures.coordinate_digits(np.ascontiguousarray(points))
    if magnitude < float(np.finfo(np.float32).max) and is_single:
        return magnitude * 2.0**-24
    return magnitude * 2.0**-53
