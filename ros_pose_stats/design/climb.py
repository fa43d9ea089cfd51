"""Steps within bounds, one after the other, each the one that gains most by the estimator."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from .changes import DesignSpace
from .shares import WantedShare
from .tied_steps import center_move, is_forward, outline_move, tied_steps

Array = NDArray[np.float64]

LEAST_GAIN: Final = 0.003
"""Estimated gain of a step below which it is not worth making."""

STRIDES: Final = (0.5, 1.0)
"""Shares of the bound by which a feature is changed at a time."""

MOST_STEPS: Final = 12
LOOKED_AT: Final = 8
"""Steps that are estimated anew after each, those that gained most before."""

SLACK: Final = 1e-6
"""Share by which outline and centre of mass may seem to move farther for rounding."""


class Climb:
    """One step after the other, each the one that gains most by the estimator.

    The share by the part that is reached is `share`, by the part as it is `base`.
    """

    def __init__(self, space: DesignSpace, model: WantedShare, within: float, *,
                 edges: bool = True) -> None:
        self._space, self._model, self._within = space, model, within
        self._tied = tied_steps(space, within)
        if not edges:
            self._tied = self._tied[~is_forward(space, self._tied)]
        self._forward = is_forward(space, self._tied)
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
        if np.abs(level).max(initial=0.0) > 1.0 or level[self._forward].min(initial=0.0) < 0.0:
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
