"""Whether a rotation carries the whole surface of a part into itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..records import Part
from ..tolerances import COPLANAR, SYMMETRY
from .convex_body import ConvexBody
from .equilibria import Equilibria, ties
from .features import Features, surface_features

Array = NDArray[np.float64]
Index = NDArray[np.int64]

OVERHEAD = 64
"""What setting up one comparison costs, in features compared."""

PROBES = 12
"""Regions that a candidate must match before the whole surface is compared: the largest,
and those that gave earlier candidates away."""


def _squares(vectors: Array) -> Array:
    """Products (N, 9) of the components of vectors (N, 3) with each other."""
    return (vectors[:, :, None] * vectors[:, None, :]).reshape(-1, 9)


class SurfaceTrial:
    """Tries rotations on the whole surface of one part.

    Parameters
    ----------
    part : Part
    body : ConvexBody
    """

    def __init__(self, part: Part, body: ConvexBody) -> None:
        self.features: Features = surface_features(
            part, body.radius, max(COPLANAR, body.tolerance))
        self.regions = cKDTree(self.features.regions)
        self.corners = cKDTree(self.features.corners) if len(self.features.corners) else None
        self.inertia = part.inertia / np.trace(part.inertia)
        self.probes = list(range(min(PROBES, len(self.features.regions))))
        self.effort = 0

    def refine(self, found: Equilibria, kind: Index) -> Index:
        """Split kinds by moments of the whole surface along each stable face's normal."""
        along = found.downs
        square = _squares(along)
        regions = np.ascontiguousarray(self.features.regions[:, :3])
        area = self.features.regions[:, 6:7] ** 2
        facing = self.features.regions[:, 3:6] * self.features.regions[:, 6:7] * area
        pairs = _squares(regions)
        crossed = (facing[:, :, None] * regions[:, None, :]).reshape(-1, 9)
        moments = (
            square @ (pairs.T @ area[:, 0]),
            ((square @ ((area * pairs).T @ regions)) * along).sum(axis=1),
            ((square @ ((area * pairs).T @ pairs)) * square).sum(axis=1),
            along @ facing.sum(axis=0),
            ((along @ (facing.T @ regions)) * along).sum(axis=1),
            ((along @ (facing.T @ pairs)) * square).sum(axis=1),
            ((square @ (crossed.T @ pairs)) * square).sum(axis=1),
        )
        return ties(*((moment, 10.0 * SYMMETRY) for moment in moments), within=kind)

    def holds(self, rotation: Array) -> bool:
        """Whether the rotation carries surface and inertia into themselves."""
        turned = rotation @ self.inertia @ rotation.T
        if np.abs(turned - self.inertia).max() > SYMMETRY:
            return False
        if len(self._unmatched(self.regions, self._image(rotation, self.probes))):
            return False
        every = np.arange(len(self.features.regions))
        lost = self._unmatched(self.regions, self._image(rotation, every))
        if len(lost):
            self.probes = [int(lost[0]), *self.probes][:2 * PROBES]
            return False
        if self.corners is None:
            return True
        return not len(self._unmatched(self.corners, self.features.corners @ rotation.T))

    def _image(self, rotation: Array, chosen: Sequence[int] | Index) -> Array:
        """Some regions after the rotation."""
        regions = self.features.regions[chosen]
        return np.column_stack([regions[:, :3] @ rotation.T, regions[:, 3:6] @ rotation.T,
                                regions[:, 6]])

    def _unmatched(self, features: cKDTree, image: Array) -> Index:
        """Images with no feature of their own where they fall."""
        self.effort += OVERHEAD + len(image)
        gap, partner = features.query(image, distance_upper_bound=SYMMETRY)
        first = np.zeros(len(image), dtype=np.bool_)
        first[np.unique(partner, return_index=True)[1]] = True
        return np.flatnonzero(~(first & np.isfinite(gap)))
