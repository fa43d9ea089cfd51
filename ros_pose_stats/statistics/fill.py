"""How many parts of a full plate a gripper can take: those that no other part is too near to.

Parts lie anywhere and turned anyhow, each by itself, as in D. Gudmundsson and K. Goldberg, "Tuning
robotic part feeder parameters to maximize throughput" (ICRA 1997).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..records import Array, Index

PLACES, DIRECTIONS = 6, 96
"""Nodes along half a side of the plate, and directions in which its edge is looked for."""


class PlateFill(NamedTuple):
    """Room on a plate for parts that lie in given shares in their poses."""

    # (K, Q); where another part's centre blocks a part in each pose at each node, over the plate
    blocked: Array
    weight: Array  # (Q,); of the nodes, 1 in all

    def free(self, parts: Index) -> Array:
        """Probabilities (N, K) that none of the others blocks a part, by the parts (N,)."""
        others = parts[:, None, None] - 1.0
        return np.asarray((1.0 - self.blocked) ** others @ self.weight)


def plate_fill(outlines: Sequence[Array], shares: Array, plate: tuple[float, float],
               clearance: float) -> PlateFill:
    """Room on a plate, `plate` metres, over which the parts' centres spread evenly.

    `outlines`: convex silhouettes (k, 2) of the poses (K,), metres; `shares` (K,): of the parts
    that lie in each. A part is blocked where another one is nearer than the clearance. Over their
    turns, centres that are too near have the mean area A_i + A_j + L_i L_j / 2 pi of outlines
    of area A and length L, one of them grown by the clearance; it is taken as a disc and cut off
    at the edges of the plate.
    """
    area, length = np.array([area_and_length(outline) for outline in outlines]).T
    near = area + clearance * length + np.pi * clearance * clearance
    around = (length + 2.0 * np.pi * clearance) / (2.0 * np.pi)
    disc = (near + shares @ area + around * (shares @ length)) / np.pi  # squared radii

    node, weight = np.polynomial.legendre.leggauss(PLACES)
    place = np.stack(np.meshgrid(*((1.0 + node) * 0.25 * side for side in plate)), axis=-1)
    angle = (np.arange(DIRECTIONS) + 0.5) * (2.0 * np.pi / DIRECTIONS)
    course = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    room = np.where(course > 0.0, np.asarray(plate) - place.reshape(-1, 1, 2),
                    place.reshape(-1, 1, 2))
    edge = (room / np.abs(course)).min(axis=-1) ** 2
    inside = np.pi * np.minimum(disc[:, None, None], edge).mean(axis=-1)
    blocked: Array = np.minimum(1.0, inside / (plate[0] * plate[1]))
    return PlateFill(blocked, np.asarray(0.25 * np.outer(weight, weight).ravel(), np.float64))


def area_and_length(outline: Array) -> tuple[float, float]:
    """Area and length of a polygon's boundary."""
    x, y = outline.T
    ahead = np.roll(outline, -1, axis=0)
    return (0.5 * abs(float(x @ ahead[:, 1] - y @ ahead[:, 0])),
            float(np.hypot(*(ahead - outline).T).sum()))
