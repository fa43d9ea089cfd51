"""A few changes, within bounds, that raise the share of wanted poses together.

The estimator chooses them one after the other, and drops that had no say tell what each
gained. What is judged is the outer shape and the centre of mass, not whether the part
can be made.
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
BOUND_SHARES = (
    -1.0,
    -0.5,
    0.5,
    1.0,
)  # shares of the bound by which a feature is changed
CANDIDATES = 12
"""Ways that are estimated anew after the first step: those that gained most alone."""
MOVE_SLACK = 1e-6
"""Share by which outline and centre of mass may seem to move farther for rounding."""


class Step(NamedTuple):
    """A step of a suggestion."""

    # (n,); of each feature, metres or a fraction; those that symmetry ties together
    moves: Array
    estimated: float  # gain over the steps before
    gain: paired_drops.PairedDifference  # the same by drops


@dataclass(frozen=True, eq=False)
class Suggestion:
    """A change of a part that raises the share of its wanted poses."""

    space: changes.DesignSpace
    within: float  # bound of what is moved, metres
    # the one that gains most first; none where nothing was found
    steps: tuple[Step, ...]
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
                                "step": float(step.moves[number]),
                            }
                            for number in np.flatnonzero(step.moves).tolist()
                        ],
                        "estimated": step.estimated,
                        "gain": describe.difference_as_dict(step.gain),
                    }
                    for step in self.steps
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
    """Find up to three changes, within bounds, so that a part rests as wanted.

    Parameters
    ----------
    part : Part
    wanted : sequence of int
        Indices of the accepted poses.
    within : float
        How far the outline, and the centre of mass, may move, metres. A symmetric part
        stays as symmetric as it is.
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
    request = drop_request(drops, seed, 0.0, workers)
    space = changes.DesignSpace(part, scene)
    model = shares.WantedShare(space, wanted)
    changes.check_reach("bound", within, space.body.radius)
    moves, estimates = _find_steps(
        space,
        model,
        within,
        lambda count: on_progress(0.5 * count / MOST_STEPS),
        should_stop,
    )
    parts = [
        space.change(sum(moves[:taken], np.zeros(len(space.features))))
        for taken in range(len(moves) + 1)
    ]
    dropped = model.drop(
        parts,
        request,
        lambda drops_done: on_progress(
            0.5 + 0.5 * drops_done / (request.drops * len(parts))
        ),
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
        outline_shift(space, parts[-1]),
        center_move(space, parts[-1]),
        estimates[0],
        estimates[-1],
        model.lost_poses(parts[-1]),
        paired_drops.paired_difference(dropped[0], dropped[-1]),
        shares.count_share(dropped[0]),
        shares.count_share(dropped[-1]),
        dropped.shape[1],
        request.seed,
        time.perf_counter() - begin,
    )


def _find_steps(
    space: changes.DesignSpace,
    model: shares.WantedShare,
    within: float,
    on_progress: Callable[[int], object],
    should_stop: Callable[[], bool],
) -> tuple[list[Array], list[float]]:
    """Steps, each with the largest gain after those before, and the shares."""
    candidates = [
        (tied, stride * step)
        for tied, step in enumerate(alike.symmetric_steps(space, within))
        for stride in BOUND_SHARES
    ]
    moves: list[Array] = []
    estimates = [model.estimate(space.change_feature(0, 0.0))]
    total_move: Array = np.zeros(len(space.features))

    def gain(move: Array) -> float:
        """Over the steps before; minus infinity beyond the bounds."""
        try:
            changed_part = space.change(total_move + move)
            shift = max(
                outline_shift(space, changed_part), center_move(space, changed_part)
            )
            return (
                model.estimate(changed_part) - estimates[-1]
                if (shift <= within * (1.0 + MOVE_SLACK))
                else -np.inf
            )
        except errors.MeshError:
            return -np.inf

    while candidates and len(moves) < MOST_STEPS:
        gains = [-np.inf if should_stop() else gain(move) for _, move in candidates]
        # Mirror twins gain the same but for rounding: of those the first.
        rank = tolerances.number_equal(
            [-gain for gain in gains], sensitivity.SAME_CHANGE
        )
        order = np.argsort(rank, kind="stable").tolist()
        best = order[0]
        if gains[best] < LEAST_GAIN:
            break
        moves.append(candidates[best][1])
        total_move = total_move + moves[-1]
        estimates.append(estimates[-1] + gains[best])
        candidates = [
            candidates[k]
            for k in order[:CANDIDATES]
            if candidates[k][0] != candidates[best][0]
        ]
        on_progress(len(moves))
    return moves, estimates


def outline_shift(
    space: changes.DesignSpace, changed_part: changes.ChangedPart
) -> float:
    """How far the outline has moved across the old and new faces, metres."""
    body = space.body
    changed_body = body_of(changed_part.part, space.scene.round_sides)
    shift = changed_part.part.center_of_mass - space.part.center_of_mass
    corners = body.points * body.radius
    changed_corners = changed_body.points * changed_body.radius + shift
    growth = (
        changed_corners @ body.arrays.normal.T - body.arrays.distance * body.radius
    ).max()
    shrinkage = (
        (corners - shift) @ changed_body.arrays.normal.T
        - changed_body.arrays.distance * changed_body.radius
    ).max()
    return float(max(growth, shrinkage, 0.0))


def center_move(space: changes.DesignSpace, changed_part: changes.ChangedPart) -> float:
    """How far the centre of mass has moved, metres, by itself or with the outline."""
    return float(
        np.linalg.norm(changed_part.part.center_of_mass - space.part.center_of_mass)
    )
