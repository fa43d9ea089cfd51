"""A few changes, within bounds, that raise the share of wanted poses together.

The estimator chooses them one after the other, and drops that had no say tell what each gained.
What is judged is the outer shape and the centre of mass, not whether the part can be made.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base import errors
from ...core import tolerances
from ...core.records import Array, DropScene, Part
from ...core.records.plain_values import with_units, without_rounding
from ...core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
)
from ...core.resting.convex_body import body_of
from ...core.simulation.request import drop_request
from ...core.statistics import feeding
from . import alike, changes, describe, paired_drops, sensitivity, shares

GAIN_DROPS = 2000  # drops that tell the gains, of the part as it is and after each step
MOST_STEPS = 3

LEAST_GAIN = 0.003  # estimated gain of a step below which it is not worth making
STRIDES = (-1.0, -0.5, 0.5, 1.0)  # shares of the bound by which a feature is changed
LOOKED_AT = 12  # ways that are estimated anew after the first step: those that gained most alone
SLACK = 1e-6  # share by which outline and centre of mass may seem to move farther for rounding


class Step(NamedTuple):
    """A step of a suggestion."""

    moves: Array  # (n,); of each feature, metres or a fraction; those that symmetry ties together
    estimated: float  # gain over the steps before
    gain: paired_drops.PairedDifference  # the same by drops


@dataclass(frozen=True, eq=False)
class Suggestion:
    """A change of a part that raises the share of its wanted poses."""

    space: changes.DesignSpace
    within: float  # bound of what is moved, metres
    steps: tuple[
        Step, ...
    ]  # the one that gains most first; none where nothing was found
    changed: changes.ChangedPart  # the part after all steps
    outline: float  # how far its outline and its centre of mass moved, metres
    center_shift: float
    before: float  # estimated shares
    after: float
    lost: tuple[int, ...]  # wanted poses that are gone
    # by drops, from the same starts, none of which chose the change
    gain: paired_drops.PairedDifference
    dropped_before: feeding.Bounded  # shares by these drops
    dropped_after: feeding.Bounded
    drops: int
    seed: int
    seconds: float

    @property
    def gain_error(self) -> float:
        """Standard error of the estimated gain."""
        return sensitivity.effect_error(self.after - self.before, 0.0)

    def as_dict(self) -> dict[str, Any]:
        """Plain values; lengths in metres, shares as fractions."""
        space = self.space
        return with_units(
            {
                "within": self.within,
                "outline": self.outline,
                "center_shift": self.center_shift,
                "judged": describe.JUDGED,
                "steps": [
                    {
                        "changes": [
                            {
                                **describe.feature_as_dict(space, number),
                                "step": float(one.moves[number]),
                            }
                            for number in np.flatnonzero(one.moves).tolist()
                        ],
                        "estimated": one.estimated,
                        "gain": describe.difference_as_dict(one.gain),
                    }
                    for one in self.steps
                ],
                "estimate": {
                    "before": self.before,
                    "after": self.after,
                    "gain": self.after - self.before,
                    "error": self.gain_error,
                },
                "lost": self.lost,
                "by_drops": {
                    "before": self.dropped_before,
                    "after": self.dropped_after,
                    "gain": describe.difference_as_dict(self.gain),
                },
                "center_of_mass": without_rounding(
                    self.changed.part.center_of_mass, space.body.radius
                ),
                "drops": self.drops,
                "seed": self.seed,
                "seconds": self.seconds,
            }
        )


def suggest(
    part: Part,
    wanted: Sequence[int],
    within: float,
    *,
    drops: int = GAIN_DROPS,
    seed: int | None = None,
    restitution: float = DEFAULT_RESTITUTION,
    drop_height: float | None = None,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
    workers: int | None = None,
    on_progress: Callable[[float], object] = lambda share: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Suggestion:
    """Find up to three changes of a part, within bounds, so that it rests as wanted more often.

    Parameters
    ----------
    part : Part
    wanted : sequence of int
        Indices of the accepted poses.
    within : float
        How far the outline, and the centre of mass, may move, metres. A symmetric part stays as
        symmetric as it is.
    drops : int
        Of the part as it is and after each step, from the same starts.
    seed, restitution, drop_height, cluster_tolerance, round_sides, workers
        As for `simulate`.
    on_progress : callable
        Takes the share done, 0 to 1.
    should_stop : callable
        After True the steps found by then are returned.

    Raises
    ------
    RequestError
        If a value is out of its range or there is no such pose.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    asked = drop_request(drops, seed, 0.0, workers)
    space = changes.DesignSpace(part, scene)
    model = shares.WantedShare(space, wanted)
    changes.check_reach("bound", within, space.body.radius)
    moves, estimates = _climb(
        space,
        model,
        within,
        lambda taken: on_progress(0.5 * taken / MOST_STEPS),
        should_stop,
    )
    parts = [
        space.change(sum(moves[:taken], np.zeros(len(space.features))))
        for taken in range(len(moves) + 1)
    ]
    dropped = model.drop(
        parts,
        asked.drops,
        asked.seed,
        asked.workers,
        lambda done: on_progress(0.5 + 0.5 * done / (asked.drops * len(parts))),
        should_stop,
    )
    steps = tuple(
        Step(
            move,
            estimates[k + 1] - estimates[k],
            paired_drops.paired_difference(dropped[k], dropped[k + 1]),
        )
        for k, move in enumerate(moves)
    )
    return Suggestion(
        space,
        within,
        steps,
        parts[-1],
        outline_move(space, parts[-1]),
        center_move(space, parts[-1]),
        estimates[0],
        estimates[-1],
        model.lost(parts[-1]),
        paired_drops.paired_difference(dropped[0], dropped[-1]),
        shares.counted_share(dropped[0]),
        shares.counted_share(dropped[-1]),
        dropped.shape[1],
        asked.seed,
        time.perf_counter() - begin,
    )


def _climb(
    space: changes.DesignSpace,
    model: shares.WantedShare,
    within: float,
    on_progress: Callable[[int], object],
    should_stop: Callable[[], bool],
) -> tuple[list[Array], list[float]]:
    """Steps, each the one that gains most after those before, and the shares without and with."""
    ways = [
        (tied, stride * step)
        for tied, step in enumerate(alike.symmetric_steps(space, within))
        for stride in STRIDES
    ]
    taken: list[Array] = []
    estimates = [model.estimate(space.change_one(0, 0.0))]
    begun: Array = np.zeros(len(space.features))

    def gain(move: Array) -> float:
        """Over the steps before; minus infinity beyond the bounds."""
        try:
            changed = space.change(begun + move)
            moved = max(outline_move(space, changed), center_move(space, changed))
            return (
                model.estimate(changed) - estimates[-1]
                if (moved <= within * (1.0 + SLACK))
                else -np.inf
            )
        except errors.MeshError:
            return -np.inf

    while ways and len(taken) < MOST_STEPS:
        gains = [-np.inf if should_stop() else gain(move) for _, move in ways]
        # Mirror twins gain the same but for rounding: of those the first.
        rank = tolerances.number_equal(
            [-gain for gain in gains], sensitivity.SAME_CHANGE
        )
        order = sorted(range(len(ways)), key=rank.__getitem__)
        best = order[0]
        if gains[best] < LEAST_GAIN:
            break
        taken.append(ways[best][1])
        begun = begun + taken[-1]
        estimates.append(estimates[-1] + gains[best])
        ways = [ways[k] for k in order[:LOOKED_AT] if ways[k][0] != ways[best][0]]
        on_progress(len(taken))
    return taken, estimates


def outline_move(space: changes.DesignSpace, changed: changes.ChangedPart) -> float:
    """How far the outline has moved, metres, measured across the faces before and after."""
    before = space.body
    after = body_of(changed.part, space.scene.round_sides)
    shift = changed.part.center_of_mass - space.part.center_of_mass
    old = before.points * before.radius
    new = after.points * after.radius + shift
    beyond = (
        new @ before.arrays.normal.T - before.arrays.distance * before.radius
    ).max()
    left = (
        (old - shift) @ after.arrays.normal.T - after.arrays.distance * after.radius
    ).max()
    return float(max(beyond, left, 0.0))


def center_move(space: changes.DesignSpace, changed: changes.ChangedPart) -> float:
    """How far the centre of mass has moved, metres, be it by itself or with the outline."""
    return float(
        np.linalg.norm(changed.part.center_of_mass - space.part.center_of_mass)
    )
