"""Variants that lie turned in the frames of their files, and how large poses are."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..mesh.vectors import lengths
from ..resting.poses import RestingPoses
from ..simulation.drops import random_starts

Array = NDArray[np.float64]

FOOTPRINT = slice(0, 3)
"""What of a pose's sizes does not hang on the centre of mass."""

SAME_SIZE = math.log(1.05)
"""Largest logarithm of the ratio of sizes that are nearly the same."""

NEARLY = math.radians(5.0)
MOSTLY, LEAST_ALIKE = 0.75, 3
"""Share of the poses, and number of them, that a changed part must have nearly as before for it to
be found turned in its file; as it lies there, no more than half as many."""

SAME_BODY = 0.003
"""Distance between the surfaces of two exports of one body, in radii: a circle of 48 sides."""

SAME_INERTIA = 0.02
"""Difference between their inertias, as a share of it."""

DIRECTIONS = 256
"""In which surfaces are compared."""

MOST_TURNS = 200
"""Ways to turn one body into another that are tried."""


def size_ratios(first: RestingPoses, second: RestingPoses,
                which: slice = slice(None)) -> Array:
    """Largest logarithm (P, Q) of the ratio of two poses' sizes; see `_sizes`."""
    one, other = (np.log(_sizes(resting)[:, which]) for resting in (first, second))
    return np.asarray(np.abs(one[:, None] - other[None]).max(axis=2))


def _sizes(resting: RestingPoses) -> Array:
    """Area and girth of the outline and highest point, and the height, all as lengths, (P, 4)."""
    rows = []
    for pose in resting.poses:
        x, y = pose.outline.T
        onward = np.roll(x, -1), np.roll(y, -1)
        area = 0.5 * abs(float((x * onward[1] - y * onward[0]).sum()))
        girth = float(np.hypot(onward[0] - x, onward[1] - y).sum())
        rows.append((math.sqrt(area), girth, pose.top, pose.height))
    return np.array(rows)


def find_turn(first: RestingPoses, second: RestingPoses) -> tuple[Array | None, bool]:
    """Rotation from the first frame to the second, and whether both are one and the same body.

    None where the frames are equal, as far as the outer shape tells: a centre of mass that was
    moved to the other side of a symmetric part is a change of the part, not a turn.
    """
    directions = random_starts(1, 0, DIRECTIONS)
    unturned = np.eye(3)
    if _misfit(first, second, unturned, directions, about_center=False) <= SAME_BODY:
        return None, False
    footprint = size_ratios(first, second, FOOTPRINT) <= SAME_SIZE
    ways = [(-_misfit(first, second, turn, directions, about_center=True),
             _count_alike(first, second, footprint, turn), turn) for turn in _turns(first, second)]
    if not ways:
        return None, False
    nearest = max(ways, key=lambda way: way[0])
    if -nearest[0] <= SAME_BODY and _same_inertia(first, second, nearest[2]):
        return nearest[2], True
    _, alike, turn = max(ways, key=lambda way: (way[1], way[0]))
    enough = max(LEAST_ALIKE, MOSTLY * min(len(first.poses), len(second.poses)))
    if alike >= enough and 2 * _count_alike(first, second, footprint, unturned) <= alike:
        return turn, False
    return None, False


def _count_alike(first: RestingPoses, second: RestingPoses, footprint: NDArray[np.bool_],
                 turn: Array) -> int:
    """Poses of the first variant that, turned, are nearly one of the second."""
    downs, others = (np.array([pose.down for pose in one.poses]) for one in (first, second))
    near = (downs @ turn.T) @ others.T >= math.cos(NEARLY)
    return int((near & footprint).any(axis=1).sum())


def _misfit(first: RestingPoses, second: RestingPoses, turn: Array, directions: Array,
            about_center: bool) -> float:
    """Largest distance between the outer shapes once the first is turned, in radii.

    `about_center`: whether the centres of mass are laid on each other; else the shapes as well as
    they fit.
    """
    one, other = first.body, second.body
    away = one.R(directions) * one.radius - other.R(directions @ turn.T) * other.radius
    if not about_center:
        away = away - directions @ np.linalg.lstsq(directions, away, rcond=None)[0]
    return float(np.abs(away).max()) / one.radius


def _same_inertia(first: RestingPoses, second: RestingPoses, turn: Array) -> bool:
    one = first.body.radius ** 2 * (turn @ first.inertia @ turn.T)
    other = second.body.radius ** 2 * second.inertia
    return bool(np.abs(one - other).max() <= SAME_INERTIA * np.abs(one).max())


def _turns(first: RestingPoses, second: RestingPoses) -> Iterator[Array]:
    """Rotations that lay two poses of the first variant on two of the second.

    Of the poses with the fewest equals in the second variant, so that there are few ways.
    """
    same = size_ratios(first, second) <= SAME_SIZE
    equals = same.sum(axis=1)
    downs, others = (np.array([pose.down for pose in one.poses]) for one in (first, second))
    order = np.argsort(np.where(equals > 0, equals, len(others) + 1), kind="stable")
    lead = int(order[0])
    across = lengths(np.cross(downs[lead], downs[order]))
    aside = order[across > 0.1]
    if not aside.size:
        return
    along, tried = int(aside[0]), 0
    for one in np.flatnonzero(same[lead]).tolist():
        for other in np.flatnonzero(same[along]).tolist():
            if abs(downs[lead] @ downs[along] - others[one] @ others[other]) > 0.05:
                continue
            yield _frame(others[one], others[other]) @ _frame(downs[lead], downs[along]).T
            tried += 1
            if tried == MOST_TURNS:
                return


def _frame(first: Array, second: Array) -> Array:
    """Orthonormal columns, the first along one vector, the second in its plane with another."""
    across = np.cross(first, second)
    across = across / np.linalg.norm(across)
    return np.stack((first, np.cross(across, first), across), axis=1)
