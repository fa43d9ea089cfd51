"""Features of a component of {r < E}, from its additive measures and its place in the tree."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..body.convex_body import BodyArrays
from ..compilation import kernel
from ..levels.merge_tree import MergeTree

Array = NDArray[np.float64]
Index = NDArray[np.int64]

FEATURES = 15
"""Of a component at a level; see `write_row`."""

OUTSIDE = 0.3
"""Tilt, in radians, from which on a face whose foot lies outside of it holds nothing back."""

ALIKE = 0.15
"""Angle, in radians, to the stable face below from which on a face is another one."""

SMALLEST = 1e-12
"""Share of the sphere that logarithms start from."""

SHALLOWEST = 1e-4
"""Depth over level that logarithms start from."""

NEAR, FAR = 0.01, 0.1
"""Rises of the level, in radii, over which a later join is forgotten."""

FAINTEST = -12.0
RAREST = -8.0
SHORTEST = 1e-9


@kernel
def write_row(row: Array, sums: Array, level: float, lowest: float) -> None:
    """Turn additive measures of a component into features.

    0  log of the share of the sphere with r < level; 1, 2 that of R over it, and its log;
    3  depth over level; 4 level; 5 lowest height; 6 mean log of the inertia about `down` over
    the mean one; 7 log of the solid angle of the faces that hold; 8 log of the turns over the
    lengths of the edges' arcs, over the root of the area; 9 as 8, over their angles;
    10 log of 3; then by `joined_soon` 11, 12 of the area and 13, 14 of the faces that hold.
    """
    area = max(sums[0], 0.0) / (4.0 * math.pi)
    around = max(sums[1], 0.0) / (4.0 * math.pi)
    root = math.sqrt(area + SMALLEST)
    row[0] = math.log(area + SMALLEST)
    row[1] = min(around / (area + SMALLEST), 1.0)
    row[2] = max(math.log(around + SMALLEST) - row[0], RAREST)
    row[3] = (level - lowest) / level
    row[4] = level
    row[5] = lowest
    row[6] = sums[3] / max(sums[2], SMALLEST)
    row[7] = max(math.log(sums[2] / (4.0 * math.pi) + SMALLEST), FAINTEST)
    row[8] = math.log(max(sums[5], SHORTEST) / root)
    row[9] = math.log(max(sums[4], SHORTEST) / root)
    row[10] = math.log(row[3] + SHALLOWEST)


@kernel
def joined_soon(found: Array, tree: MergeTree, wanted: NDArray[np.bool_], of: int, rise: float,
                column: int) -> None:
    """Log of a measure with that of all that joins here or soon after, over the component's own.

    What joins higher up counts the less the higher. Where joins tie, it is the same in any order.

    Parameters
    ----------
    found : (S - 1, 3, FEATURES) array
        Features; `column` of it is written.
    tree, wanted
        As for `split_features`.
    of : int
        Feature that is the logarithm of the measure.
    rise : float
        Of the level, in radii, over which a later join is forgotten.
    column : int
    """
    joins = tree.level.shape[0]
    later = np.zeros(joins)
    for j in range(joins - 1, -1, -1):
        if not wanted[j]:
            continue
        found[j, 2, column] = math.log1p(later[j] / math.exp(found[j, 2, of]))
        for c in range(2):
            added = math.exp(found[j, 1 - c, of]) + later[j]
            found[j, c, column] = math.log1p(added / math.exp(found[j, c, of]))
            below = tree.child[j, c] - joins - 1
            if below >= 0:
                later[below] = math.exp((tree.level[below] - tree.level[j]) / rise) * added


@kernel
def holding_faces(body: BodyArrays, stable: Index, basin: Index, tree: MergeTree,
                  inertia: Array) -> tuple[Array, Array]:
    """Running sums (F + 1,) over `face_order` of the solid angle of the faces that hold.

    A face holds what lands on it if the foot of the centre of mass lies inside, less the
    farther it lies outside, or if it is nearly the stable face below. The second sum is
    weighted by the log of the inertia about the face's normal over the mean one.
    """
    faces = body.distance.shape[0]
    tilt = np.zeros(faces)
    for k in range(body.twin.shape[0]):
        f = body.face[k]
        tilt[f] = max(tilt[f], math.atan2(-body.inset[k], body.distance[f]))
    mean = (inertia[0, 0] + inertia[1, 1] + inertia[2, 2]) / 3.0
    held, turned = np.zeros(faces + 1), np.zeros(faces + 1)
    for i in range(faces):
        f = tree.face_order[i]
        n, b = body.normal[f], body.normal[stable[basin[f]]]
        about = together = 0.0
        for x in range(3):
            together += n[x] * b[x]
            for y in range(3):
                about += n[x] * inertia[x, y] * n[y]
        apart = math.acos(min(max(together, -1.0), 1.0))
        share = max(max(0.0, 1.0 - tilt[f] / OUTSIDE) ** 2, max(0.0, 1.0 - apart / ALIKE) ** 2)
        held[i + 1] = held[i] + share * body.angle[f]
        turned[i + 1] = turned[i] + share * body.angle[f] * math.log(about / mean)
    return held, turned


@kernel
def lowest_faces(body: BodyArrays, stable: Index, tree: MergeTree) -> Array:
    """Smallest height (2 S - 1,) of a stable face below each node."""
    leaves = stable.shape[0]
    lowest = np.empty(2 * leaves - 1)
    lowest[:leaves] = body.distance[stable]
    for j in range(leaves - 1):
        lowest[leaves + j] = min(lowest[tree.child[j, 0]], lowest[tree.child[j, 1]])
    return lowest
