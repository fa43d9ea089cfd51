"""Features of a component of {r < E}, from its additive measures and its place in the tree."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..array_types import Array, Flags, Index
from ..body.convex_body import BodyArrays
from ..compilation import kernel
from ..levels.merge_tree import MergeTree
from ..vectors import dot, point_at

# columns of a component's additive measures (6,)
AREA: Final = 0    # solid angle with r < level
AROUND: Final = 1  # with R < level
HELD: Final = 2    # of the faces that hold
LEVER: Final = 3   # that times the log of the inertia about `down` over the mean one
SWEPT: Final = 4   # turns of the edges' arcs over their angles; with `ROLLED` from `arc_sums`
ROLLED: Final = 5  # over their lengths
MEASURES: Final = 6

# features of a component at a level
LOG_AREA: Final = 0       # log of the share of the sphere with r < level
SHARE_R: Final = 1        # that of R over it
LOG_SHARE_R: Final = 2    # and its log
DEPTH: Final = 3          # depth over level
LEVEL: Final = 4
LOWEST: Final = 5         # lowest height
INERTIA: Final = 6        # mean log of the inertia about `down` over the mean one
LOG_HELD: Final = 7       # log of the solid angle of the faces that hold
LOG_ROLLED: Final = 8     # log of the turns over the arcs' lengths, over the root of the area
LOG_SWEPT: Final = 9      # the same over their angles
LOG_DEPTH: Final = 10
AREA_NEAR: Final = 11     # by `joined_soon`: of the area
AREA_FAR: Final = 12
HELD_NEAR: Final = 13     # and of the faces that hold
HELD_FAR: Final = 14
FEATURES: Final = 15

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
def write_features(row: Array, measures: Array, level: float, lowest: float) -> None:
    """Turn additive measures of a component into the features above, but for those joined soon."""
    area = max(measures[AREA], 0.0) / (4.0 * math.pi)
    around = max(measures[AROUND], 0.0) / (4.0 * math.pi)
    root = math.sqrt(area + SMALLEST)
    row[LOG_AREA] = math.log(area + SMALLEST)
    row[SHARE_R] = min(around / (area + SMALLEST), 1.0)
    row[LOG_SHARE_R] = max(math.log(around + SMALLEST) - row[LOG_AREA], RAREST)
    row[DEPTH] = (level - lowest) / level
    row[LEVEL] = level
    row[LOWEST] = lowest
    row[INERTIA] = measures[LEVER] / max(measures[HELD], SMALLEST)
    row[LOG_HELD] = max(math.log(measures[HELD] / (4.0 * math.pi) + SMALLEST), FAINTEST)
    row[LOG_ROLLED] = math.log(max(measures[ROLLED], SHORTEST) / root)
    row[LOG_SWEPT] = math.log(max(measures[SWEPT], SHORTEST) / root)
    row[LOG_DEPTH] = math.log(row[DEPTH] + SHALLOWEST)


@kernel
def joined_soon(found: Array, tree: MergeTree, wanted: Flags, of: int, rise: float,
                column: int) -> None:
    """Log of a measure with that of all that joins here or soon after, over the component's own.

    What joins higher up counts the less the higher. Where joins tie, it is the same in any order.

    `found` (S - 1, 3, FEATURES): features; `column` of it is written; `of`: feature that is the
    logarithm of the measure; `rise`: of the level, in radii, over which a later join is forgotten.
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
    held, lever = np.zeros(faces + 1), np.zeros(faces + 1)
    for i in range(faces):
        f = tree.face_order[i]
        about = 0.0
        for x in range(3):
            for y in range(3):
                about += body.normal[f, x] * inertia[x, y] * body.normal[f, y]
        together = dot(point_at(body.normal, f), point_at(body.normal, stable[basin[f]]))
        apart = math.acos(min(max(together, -1.0), 1.0))
        share = max(max(0.0, 1.0 - tilt[f] / OUTSIDE) ** 2, max(0.0, 1.0 - apart / ALIKE) ** 2)
        held[i + 1] = held[i] + share * body.angle[f]
        lever[i + 1] = lever[i] + share * body.angle[f] * math.log(about / mean)
    return held, lever


@kernel
def lowest_faces(body: BodyArrays, stable: Index, tree: MergeTree) -> Array:
    """Smallest height (2 S - 1,) of a stable face below each node."""
    leaves = stable.shape[0]
    lowest = np.empty(2 * leaves - 1)
    lowest[:leaves] = body.distance[stable]
    for j in range(leaves - 1):
        lowest[leaves + j] = min(lowest[tree.child[j, 0]], lowest[tree.child[j, 1]])
    return lowest
