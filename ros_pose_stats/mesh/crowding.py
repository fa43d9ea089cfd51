"""Whether thousands of corners of a convex hull share one face.

Qhull handles coplanar points by merging facets, and each merge walks around the whole facet: a
ring of 1000 corners takes it 0.1 s, one of 25 000 minutes. Such a ring is seen in a sample of
the points: many of the sample's corners share a face too.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

Array = NDArray[np.float64]

CROWD: Final = 1000
"""Corners of one face from which on Qhull takes longer than it does for so many other points."""

_SAMPLE: Final = 512
_FEW: Final = 6  # corners of a face in the sample that chance alone may put there

COUNTED: Final = 1e-10
"""Points this close to a face, as a fraction of the size, are counted with it."""


def crowded(points: Array) -> bool:
    """Whether a face of the hull has more than about `CROWD` corners.

    Parameters
    ----------
    points : (N, 3) array
        Of size one.
    """
    if len(points) <= CROWD:
        return False
    # Drawn, not taken in steps, which might pick from one ring of a regular mesh only.
    drawn = np.random.default_rng(0).integers(len(points), size=_SAMPLE)
    try:
        hull = ConvexHull(points[drawn])
    except QhullError:
        return True  # almost all points lie in one plane
    # A face that was cut into triangles has its plane with each of them.
    planes, triangles = np.unique(hull.equations, axis=0, return_counts=True)
    often = np.argsort(-triangles, kind="stable")[:6]
    suspect = often[(triangles[often] + 2 > _FEW)
                    & ((triangles[often] + 2) * len(points) > CROWD * _SAMPLE)]
    return any(_corners_on(points, planes[k]) > CROWD for k in suspect.tolist())


def _corners_on(points: Array, plane: Array) -> int:
    """Number of corners of the polygon around the points on a plane; 0 if more lie beyond."""
    off = points @ plane[:3] + plane[3]
    if off.max() > COUNTED:
        return 0
    there = points[off > -COUNTED]
    across = np.delete(there, int(np.abs(plane[:3]).argmax()), axis=1)
    drawn = np.random.default_rng(0).integers(len(across), size=_SAMPLE)
    try:
        # Of points all over a polygon few are corners, in a sample as in all.
        if len(ConvexHull(across[drawn]).vertices) * len(across) < CROWD * _SAMPLE:
            return 0
        return len(ConvexHull(across).vertices)
    except QhullError:
        return 0  # on a line
