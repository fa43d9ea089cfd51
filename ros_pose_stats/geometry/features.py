"""What of a mesh must be carried into itself by a symmetry: planar regions and corners.

Neither depends on how flat areas were triangulated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kernels.coplanar import surface_regions
from ..records import Part

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Features:
    """Planar regions and corners of the full surface, relative to the centre of mass.

    Attributes
    ----------
    regions : (G, 7) array
        Centroid, normal times size and size (square root of the area) of each connected
        planar region, largest first, in radii. The normal is weighed by the size because a
        small region's normal is known only that well from rounded coordinates.
    corners : (C, 3) array
        Vertices where at least three regions meet.
    """

    regions: Array
    corners: Array


def surface_features(part: Part, radius: float, tolerance: float) -> Features:
    """Planar regions and corners of a part's surface.

    Parameters
    ----------
    part : Part
    radius : float
        Metres.
    tolerance : float
        Coplanarity, as a fraction of the radius.
    """
    points = (part.surface_vertices - part.center_of_mass) / radius
    triangles = part.surface_triangles
    a, b, c = (points[triangles[:, i]] for i in range(3))
    vectors = np.asarray(0.5 * np.cross(b - a, c - a), dtype=np.float64)
    areas = np.asarray(np.sqrt((vectors * vectors).sum(axis=1)), dtype=np.float64)
    region = surface_regions(points, triangles, _neighbours(triangles), tolerance)
    count = int(region.max()) + 1
    size = np.bincount(region, areas, count)
    solid = size > 0.0
    centroid = _sums(region, (a + b + c) / 3.0 * areas[:, None], count)[solid] / size[solid, None]
    normal = _sums(region, vectors, count)[solid] / np.sqrt(size[solid, None])
    regions = np.column_stack([centroid, normal, np.sqrt(size[solid])])
    return Features(regions[np.argsort(-size[solid], kind="stable")],
                    points[_corners(triangles, np.where(solid[region], region, -1))])


def _sums(group: Index, values: Array, count: int) -> Array:
    return np.stack([np.bincount(group, values[:, i], count) for i in range(3)], axis=1)


def _neighbours(triangles: Index) -> Index:
    """Triangle (T, 3) across the side opposite to each vertex; -1 where several meet."""
    ends = np.sort(triangles[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
    key = ends[:, 0] * (int(triangles.max()) + 1) + ends[:, 1]
    order = np.argsort(key, kind="stable")
    key = key[order]
    same = np.concatenate([[False], key[1:] == key[:-1], [False]])
    pair = np.flatnonzero(same[1:-1] & ~same[:-2] & ~same[2:])
    first, second = order[pair], order[pair + 1]
    across = np.full(triangles.size, -1, dtype=np.int64)
    across[first], across[second] = second // 3, first // 3
    return across.reshape(-1, 3)


def _corners(triangles: Index, region: Index) -> Index:
    """Vertices that touch at least three regions."""
    used = region >= 0
    count = int(region.max()) + 1
    key = np.unique(triangles[used].ravel() * count + np.repeat(region[used], 3))
    return np.flatnonzero(np.bincount(key // count) >= 3)
