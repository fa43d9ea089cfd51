"""Steps within bounds, one after the other, each the one that gains most by the estimator.

A step is a change that leaves the part as symmetric as it is.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError, RequestError
from ..resting.convex_body import convex_body
from . import alike, changes, shares

Array = NDArray[np.float64]

NOTHING = 1e-6
"""Share of an axis that symmetry leaves, below which it leaves none."""


def tied_steps(space: changes.DesignSpace, within: float) -> Array:
    """Steps (t, n) of the features, each as far as the outline or the centre of mass may move.

    Faces that a rotation of the part carries into each other are changed together. The centre of
    mass moves, and the part is stretched, only along what all rotations leave.
    """
    rotations, images = alike.feature_images(space)
    count = len(space.features)
    corners = space.body.points[np.unique(space.body.arrays.corner)]
    reach = np.abs(corners).max(axis=0) * space.body.radius
    steps = []
    centres = rotations.mean(axis=0).T
    # R E_i R^T has the squares of the i-th column of R on its diagonal.
    stretches = (rotations ** 2).mean(axis=0).T
    for along in _distinct(centres):
        steps.append(np.append(within * along / np.linalg.norm(along), np.zeros(count - 3)))
    for along in _distinct(stretches):
        if _keeps_stretch(rotations, along):
            step = np.zeros(count)
            step[3:6] = within * along / (reach * along).max()
            steps.append(step)
    orbit = alike.first_of_orbits(images)
    for first in np.unique(orbit[6:]).tolist():
        steps.append(np.where(orbit == first, within, 0.0))
    return np.array(steps)


def outline_move(space: changes.DesignSpace, changed: changes.ChangedPart) -> float:
    """How far the outline has moved, metres, measured across the faces before and after."""
    before, after = space.body, convex_body(changed.part, space.round_sides)
    shift = changed.part.center_of_mass - space.part.center_of_mass
    old, new = before.points * before.radius, after.points * after.radius + shift
    beyond = (new @ before.arrays.normal.T - before.arrays.distance * before.radius).max()
    left = ((old - shift) @ after.arrays.normal.T - after.arrays.distance * after.radius).max()
    return float(max(beyond, left, 0.0))


def center_move(space: changes.DesignSpace, changed: changes.ChangedPart) -> float:
    """How far the centre of mass has moved, metres, be it by itself or with the outline."""
    return float(np.linalg.norm(changed.part.center_of_mass - space.part.center_of_mass))


def check_within(within: float, radius: float) -> None:
    """Refuse a bound that is none.

    Raises RequestError if it is not above 0 and at most half the radius.
    """
    if not 0.0 < within <= 0.5 * radius:
        raise RequestError(f"a bound above 0 and at most {500.0 * radius:.3g} mm, half the "
                           "part's radius", f"{1e3 * within:.3g} mm",
                           "give how far the outline may move, in millimetres")


def _distinct(rows: Array) -> list[Array]:
    """Rows that are not nearly zero, and no multiples of those before."""
    found: list[Array] = []
    for row in rows:
        length = float(np.linalg.norm(row))
        if length > NOTHING and all(
                np.linalg.norm(np.cross(row, other)) > NOTHING * length for other in found):
            found.append(row)
    return found


def _keeps_stretch(rotations: Array, along: Array) -> bool:
    """Whether all rotations leave a stretch along the axes as it is."""
    tensor = np.diag(along)
    return bool(np.abs(rotations @ tensor @ rotations.transpose(0, 2, 1) - tensor).max()
                < 10.0 * NOTHING)


LEAST_GAIN = 0.003
"""Estimated gain of a step below which it is not worth making."""

STRIDES = (0.5, 1.0)
"""Shares of the bound by which a feature is changed at a time."""

MOST_STEPS = 12
LOOKED_AT = 8
"""Steps that are estimated anew after each, those that gained most before."""

SLACK = 1e-6
"""Share by which outline and centre of mass may seem to move farther for rounding."""


class Climb:
    """One step after the other, each the one that gains most by the estimator.

    The share by the part that is reached is `share`, by the part as it is `base`.
    """

    def __init__(self, space: changes.DesignSpace, model: shares.WantedShare, within: float
                 ) -> None:
        self._space, self._model, self._within = space, model, within
        self._tied = tied_steps(space, within)
        self._level: Array = np.zeros(len(self._tied))
        self.base = self.share = model.estimate(space.change_one(0, 0.0))

    @property
    def steps(self) -> Array:
        """Of each feature (n,)."""
        return np.asarray(self._level @ self._tied)

    @property
    def taken(self) -> tuple[tuple[int, ...], ...]:
        """Features of each tied step that was taken; those first without which most is lost."""
        worth = {}
        for one in np.flatnonzero(self._level).tolist():
            without = self._level.copy()
            without[one] = 0.0
            worth[one] = self.share - self._estimate(without)
        return tuple(tuple(np.flatnonzero(self._tied[one]).tolist())
                     for one in sorted(worth, key=lambda one: -worth[one]))

    def climb(self, progress: Callable[[int], object], stop: Callable[[], bool]) -> None:
        """Take steps until none gains enough, then leave out those that did not pay."""
        gains = {(step, sign * stride): np.inf for step in range(len(self._tied))
                 for stride in STRIDES for sign in (1.0, -1.0)}
        for taken in range(MOST_STEPS):
            best = self._best(gains, stop)
            if stop() or best is None or gains[best] < LEAST_GAIN:
                break
            self._level = self._with(best)
            self.share += gains[best]
            progress(taken + 1)
        for one in np.flatnonzero(self._level).tolist():
            without = self._level.copy()
            without[one] = 0.0
            share = self._estimate(without)
            if share > self.share - LEAST_GAIN:
                self._level, self.share = without, share

    def _best(self, gains: dict[tuple[int, float], float], stop: Callable[[], bool]
              ) -> tuple[int, float] | None:
        """The step with the largest gain; those that gained little before are looked at last."""
        ranked = sorted(gains, key=lambda one: -gains[one])
        best: tuple[int, float] | None = None
        for place, one in enumerate(ranked):
            if stop() or (best is not None and place >= LOOKED_AT
                          and gains[best] >= max(gains[one], LEAST_GAIN)):
                break
            gains[one] = self._estimate(self._with(one)) - self.share
            if best is None or gains[one] > gains[best]:
                best = one
        return best

    def _with(self, one: tuple[int, float]) -> Array:
        level = self._level.copy()
        level[one[0]] += one[1]
        return level

    def _estimate(self, level: Array) -> float:
        """Share at some levels (t,) of the steps; minus infinity beyond the bounds."""
        if np.abs(level).max(initial=0.0) > 1.0:
            return -np.inf
        steps = level @ self._tied
        try:
            changed = self._space.change(steps)
            if self._within * (1.0 + SLACK) < max(outline_move(self._space, changed),
                                                  center_move(self._space, changed)):
                return -np.inf
            return self._model.estimate(changed)
        except MeshError:
            return -np.inf
