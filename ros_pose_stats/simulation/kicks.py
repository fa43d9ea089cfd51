"""States of a part that a plate has just kicked out of one of its poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kernels.drops.layout import P, V, W
from ..mesh.vectors import turn_vectors
from .drop_body import PreparedBody
from .drops import states_at_rest
from .starts import flip_draws

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Kicks:
    """A plate that kicks the part, lying in any of its poses, at points of the contact polygon."""

    body: PreparedBody
    height: float  # energy of a kick over the weight, radii
    # (T, 3); a triangle of a contact polygon, in principal axes: a corner and the sides that leave
    # it
    corner: Array
    first: Array
    second: Array
    # (T,); share of the polygon's area that it and those before it have, plus the pose's index
    end: Array
    begin: Array  # (T,); the same without the triangle itself

    def states(self, seed: int, first: int, count: int) -> Array:
        """States (count, 8) just after kicks first ... first + count - 1, all poses in turn.

        A vertical impulse J acts at a point r drawn uniformly from the contact polygon:
        v = J / m and w = J I^-1 (r x up), with J such that the energy is m g times the height.
        """
        resting, moment = self.body.resting, self.body.arrays.moment
        pose = np.arange(first, first + count) % len(resting.poses)
        lowest = resting.clusters.lowest[pose]
        states = states_at_rest(self.body, resting.equilibria.heights[lowest],
                                resting.equilibria.downs[lowest])
        x, y, z = self._points(pose, flip_draws(seed, first, count)).T
        p, q, r = states[:, P:P + 3].T
        arm = np.stack((y * r - z * q, z * p - x * r, x * q - y * p), axis=1)
        reach = arm * arm / moment
        impulse = np.sqrt(2.0 * self.height / (1.0 + reach[:, 0] + reach[:, 1] + reach[:, 2]))
        states[:, V] = impulse
        states[:, W:W + 3] = impulse[:, None] * arm / moment
        return states

    def _points(self, pose: Index, draws: Array) -> Array:
        """Points (n, 3) of contact polygons from two uniform numbers each."""
        at = np.searchsorted(self.end, pose + draws[:, 0], side="right")
        # A sum that rounds up would be the next pose's.
        at = np.minimum(at, np.searchsorted(self.end, pose + 1.0, side="left"))
        size = self.end[at] - self.begin[at]
        share = np.clip((pose + draws[:, 0] - self.begin[at]) / size, 0.0, 1.0)
        out, along = np.sqrt(share)[:, None], draws[:, 1:]
        return np.asarray(self.corner[at] + out * (
            (1.0 - along) * self.first[at] + along * self.second[at]))


def kicks_of(body: PreparedBody, height: float) -> Kicks:
    """Prepare the contact polygons of a body."""
    resting = body.resting
    faces = resting.equilibria.faces[resting.clusters.lowest]
    rows: list[Array] = []
    ends: list[Array] = []
    for pose, face in enumerate(faces.tolist()):
        polygon = turn_vectors(resting.body.polygon(face), body.axes)
        first, second = polygon[1:-1] - polygon[0], polygon[2:] - polygon[0]
        rows.append(np.stack((np.broadcast_to(polygon[0], first.shape), first, second), axis=1))
        grown = np.cumsum(_areas(first, second))
        grown = grown / grown[-1]
        kept = np.diff(grown, prepend=0.0) > 0.0  # corners on one line span no area
        rows[-1], grown = rows[-1][kept], grown[kept]
        grown[-1] = 1.0
        ends.append(np.stack((pose + np.concatenate(([0.0], grown[:-1])), pose + grown), axis=1))
    corner, first, second = np.moveaxis(np.concatenate(rows), 1, 0)
    begin, end = np.concatenate(ends).T
    return Kicks(body, height, corner, first, second, end, begin)


def _areas(first: Array, second: Array) -> Array:
    (a, b, c), (d, e, f) = first.T, second.T
    x, y, z = b * f - c * e, c * d - a * f, a * e - b * d
    return np.asarray(np.sqrt(x * x + y * y + z * z))
