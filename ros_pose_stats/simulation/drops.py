"""Drops of a prepared body in SI units, one call of the kernel at a time."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.drops.drop import run_drops
from ..kernels.drops.layout import (
    DURATION,
    ENDING,
    ENERGY,
    IMPACT_COUNT,
    POSE,
    TAPE,
    TOUCHED,
    TRAPPED,
    DropRules,
)
from ..mesh.vectors import turn_vectors
from ..records import DropScene
from ..records.scene import DEFAULT_DROP_RADII, GRAVITY
from ..tolerances import MOST_STEPS, SLOW, SOFT, TOUCHING, TRUNCATION
from .drop_body import PreparedBody

Array = NDArray[np.float64]
Index = NDArray[np.int64]

NO_TAPE: Array = np.zeros((0, TAPE))


@dataclass(frozen=True, eq=False)
class DropOutcomes:
    """What became of consecutive drops.

    Attributes
    ----------
    pose : (n,) array of int
        `index` of the pose that it came to rest in; -1 where it did not settle.
    impacts : (n,) array of int
        Single impacts.
    seconds : (n,) array
        From release to when the outcome was certain.
    energy_left : (n,) array
        Mechanical energy then, the plate at 0, in m g radius.
    trapped : (n,) array of bool
        The outcome was certain before it came to rest.
    touched : (n,) array of bool
        Released touching the plate, since the drop height was too low to fit.
    """

    pose: Index
    impacts: Index
    seconds: Array
    energy_left: Array
    trapped: NDArray[np.bool_]
    touched: NDArray[np.bool_]

    def first(self, count: int) -> DropOutcomes:
        """Of the first `count` drops."""
        return DropOutcomes(*(getattr(self, entry.name)[:count] for entry in fields(self)))


class DropChunk(NamedTuple):
    """Single drops as they are counted.

    Attributes
    ----------
    first : int
        Number of the first one.
    downs : (n, 3) array
        Unit vectors in the part frame that point down at release.
    outcomes : DropOutcomes
    """

    first: int
    downs: Array
    outcomes: DropOutcomes


def drop_rules(scene: DropScene, radius: float, *, to_rest: bool = False) -> DropRules:
    """Scene and the thresholds of `tolerances` as the kernels take them.

    Parameters
    ----------
    scene : DropScene
    radius : float
        Metres.
    to_rest : bool
        Go on when the outcome is decided.
    """
    return DropRules(float(scene.restitution), release_height(scene, radius) / radius, to_rest,
                     TRUNCATION, TOUCHING, SLOW, SOFT, MOST_STEPS)


def release_height(scene: DropScene, radius: float) -> float:
    """Height of the centre of mass at release, metres."""
    return DEFAULT_DROP_RADII * radius if scene.drop_height is None else float(scene.drop_height)


def run(body: PreparedBody, rules: DropRules, downs: Array, tape: Array = NO_TAPE) -> DropOutcomes:
    """Drop a body from starting directions.

    Parameters
    ----------
    body : PreparedBody
    rules : DropRules
    downs : (n, 3) array
        Unit vectors in part axes that point vertically down at release.
    tape : (T, 14) array
        For the last drop; see `kernels.drops.layout`.
    """
    ups = np.ascontiguousarray(-turn_vectors(downs, body.axes))
    outcome = np.empty((ups.shape[0], 5), dtype=np.int64)
    measure = np.empty((ups.shape[0], 2))
    run_drops(body.arrays, rules, ups, outcome, measure, tape)
    return DropOutcomes(outcome[:, POSE], outcome[:, IMPACT_COUNT],
                        measure[:, DURATION] * math.sqrt(body.radius / GRAVITY),
                        measure[:, ENERGY], outcome[:, ENDING] == TRAPPED,
                        outcome[:, TOUCHED] == 1)
