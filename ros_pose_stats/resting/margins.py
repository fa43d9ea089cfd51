"""How far a pose reaches: to the tilt that ends it, and among its own faces."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..kernels.body.equilibria import ways_out
from .clusters import Clusters
from .convex_body import foot_directions
from .equilibria import Equilibria

Array = NDArray[np.float64]


def tilt_margins(found: Equilibria, grouped: Clusters) -> Array:
    """Smallest tilt (P,) that takes the part out of each pose, radians.

    A single face is left over the side that is nearest to the foot of the centre of mass. From a
    pose of several faces the part rolls or slips within the pose first: such a pose is left
    where its basin ends, and the tilt is that from the nearest face that the part rests on.
    """
    arrays = found.body.arrays
    pose_of_face = np.full(found.body.faces, -1, dtype=np.int64)
    pose_of_face[found.faces] = grouped.pose
    margins = np.full(grouped.lowest.shape[0], np.pi / 2.0)
    several = np.bincount(grouped.pose) > 1
    sides = ways_out(arrays, found.arrays.basin, pose_of_face)
    faces = arrays.face[sides]
    alone = ~several[pose_of_face[faces]]
    tilts = np.arctan2(arrays.inset[sides], arrays.distance[faces])
    np.minimum.at(margins, pose_of_face[faces[alone]], tilts[alone])
    for pose in np.flatnonzero(several).tolist():
        margins[pose] = min(np.pi / 2.0, _tilt_to_border(found, grouped, pose))
    return margins


def _tilt_to_border(found: Equilibria, grouped: Clusters, pose: int) -> float:
    """Smallest angle between a face that the part rests on and a side where the basin ends."""
    arrays = found.body.arrays
    here = grouped.pose[found.rank[found.arrays.basin]] == pose
    sides = np.flatnonzero(here[arrays.face] & ~here[arrays.face[arrays.twin]])
    if not len(sides):
        return math.inf
    feet = foot_directions(found.body, sides)
    rests = found.downs[grouped.near & (grouped.pose == pose)]
    chord = float(cKDTree(rests).query(feet)[0].min())
    return 2.0 * math.asin(min(1.0, 0.5 * chord))


def spread(found: Equilibria, grouped: Clusters, members: list[int]) -> float:
    """Largest angle between two faces that the part rests on in a pose, radians."""
    downs = found.downs[[member for member in members if grouped.near[member]]]
    if len(downs) == 1:
        return 0.0
    # The direction farthest from another one is the nearest to its opposite.
    gap, partner = cKDTree(downs).query(-downs)
    first = int(np.argmin(gap))
    chord = float(np.linalg.norm(downs[first] - downs[partner[first]]))
    return 2.0 * math.asin(min(1.0, 0.5 * chord))
