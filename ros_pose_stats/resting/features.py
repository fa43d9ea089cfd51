"""What of a mesh must be carried into itself by a symmetry: planar regions and corners.

Neither depends on how flat areas were triangulated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kernels.features.surface_features import regions_and_corners
from ..records import Part

Array = NDArray[np.float64]


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
    regions, corners = regions_and_corners(points, part.surface_triangles, tolerance)
    return Features(regions, points[corners])
