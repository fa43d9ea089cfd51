"""Whether a rotation carries the whole surface of a part into itself.

Its planar regions and corners are compared: neither depends on how flat areas were triangulated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kernels.features.surface_features import moments_along, regions_and_corners
from ..kernels.mesh.nearness import FeatureGrid, feature_grid, first_unmatched
from ..records import Part
from ..tolerances import COPLANAR, SYMMETRY
from .convex_body import ConvexBody
from .equilibria import Equilibria, ties

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Features:
    """Planar regions and corners of the full surface, relative to the centre of mass."""

    # (G, 7); centroid, normal times size and size (square root of the area) of each connected
    # planar region, largest first, in radii. The normal is weighed by the size because a small
    # region's normal is known only that well from rounded coordinates
    regions: Array
    corners: Array  # (C, 3); vertices where at least three regions meet


def surface_features(part: Part, radius: float, tolerance: float) -> Features:
    """Planar regions and corners of a part's surface.

    `tolerance`: coplanarity, as a fraction of the radius.
    """
    points = (part.surface_vertices - part.center_of_mass) / radius
    regions, corners = regions_and_corners(points, part.surface_triangles, tolerance)
    return Features(regions, points[corners])


OVERHEAD = 64
"""Cost of setting up one comparison, in features compared."""

PROBES = 12
"""Regions that a candidate must match before the whole surface is compared: the largest,
and those that refuted earlier candidates."""

_ALL = np.empty(0, dtype=np.int64)


def keeps_inertia(part: Part, rotation: Array) -> bool:
    """Whether a rotation carries the inertia into itself."""
    inertia = part.inertia / np.trace(part.inertia)
    return bool(np.abs(rotation @ inertia @ rotation.T - inertia).max() <= SYMMETRY)


class SurfaceTrial:
    """The whole surface of one part, on which rotations are tried."""

    def __init__(self, part: Part, body: ConvexBody) -> None:
        self.features: Features = surface_features(
            part, body.radius, max(COPLANAR, body.tolerance))
        self.regions = feature_grid(self.features.regions, SYMMETRY)
        self.corners = feature_grid(self.features.corners, SYMMETRY)
        self.part = part
        self.probes = list(range(min(PROBES, len(self.features.regions))))
        self.effort = 0

    def refine(self, found: Equilibria, kind: Index) -> Index:
        """Split kinds by moments of the whole surface along each stable face's normal."""
        moments = moments_along(self.features.regions, found.downs)
        return ties(*((moment, 10.0 * SYMMETRY) for moment in moments.T), within=kind)

    def holds(self, rotation: Array) -> bool:
        """Whether the rotation carries surface and inertia into themselves."""
        if not keeps_inertia(self.part, rotation):
            return False
        probes = np.array(self.probes, dtype=np.int64)
        if self._first_unmatched(self.regions, rotation, probes) >= 0:
            return False
        lost = self._first_unmatched(self.regions, rotation, _ALL)
        if lost >= 0:
            self.probes = [lost, *self.probes][:2 * PROBES]
            return False
        return (not len(self.features.corners)
                or self._first_unmatched(self.corners, rotation, _ALL) < 0)

    def _first_unmatched(self, features: FeatureGrid, rotation: Array, chosen: Index) -> int:
        """First feature that meets no like one where the rotation puts it, -1 for none."""
        self.effort += OVERHEAD + (len(chosen) or len(features.rows))
        return first_unmatched(features, rotation, chosen)
