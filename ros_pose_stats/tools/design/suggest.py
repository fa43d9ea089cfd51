# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""A few changes, within bounds, that bring a part nearer to its goal together.

One after the other is chosen: of those that gain most by estimate the one that gains
most by drops. Drops that had no say then tell what each gained. What is judged is the
outer shape and the centre of mass, not whether the part can be made.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
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
    DEFAULT_SEED,
)
from ...core.resting.convex_body import body_of
from ...core.simulation.request import SEEDS, DropRequest, drop_request
from ...core.statistics import feeding
from . import alike, changes, describe, paired_drops, proof, sensitivity, shares
from .goal import Wanted

MOST_STEPS = 3

LEAST_GAIN = 0.003  # estimated gain of a step below which it is not worth making
DROPPED_CANDIDATES = 4  # steps that gain most by estimate, of which drops choose one
BOUND_SHARES = (-1.0, -0.5, 0.5, 1.0)
"""Shares of the bound by which a feature is changed."""
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
    """A change of a part that brings it nearer to its goal."""

    space: changes.DesignSpace
    within: float  # bound of what is moved, metres
    # the one that gains most first; none where nothing was found
    steps: tuple[Step, ...]
    changed: changes.ChangedPart  # the part after all steps
    outline: float  # how far its outline and its centre of mass moved, metres
    center_shift: float
    before: float  # estimated, how far the goal is met
    after: float
    lost: tuple[int, ...]  # wanted poses that are gone
    # by drops, from the same starts, none of which chose the change
    gain: paired_drops.PairedDifference
    dropped_before: feeding.Bounded  # how far the goal is met by these drops
    dropped_after: feeding.Bounded
    drops: int
    seed: int
    seconds: float

    @property
    def gain_error(self) -> float:
        """Standard error of the estimated gain."""
        return sensitivity.effect_error(self.after - self.before, 0.0)

    @property
    def center_of_mass(self) -> Array:
        """Of the changed part, in the frame of the old one, metres."""
        return without_rounding(
            self.changed.part.center_of_mass, self.space.body.radius
        )

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
                "center_of_mass": self.center_of_mass,
                "drops": self.drops,
                "seed": self.seed,
                "seconds": self.seconds,
            }
        )


def suggest(
    part: Part,
    wanted: Wanted,
    within: float,
    *,
    drops: int = sensitivity.CHECK_DROPS,
    seed: int = DEFAULT_SEED,
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
    wanted : sequence of int, or mapping
        Indices of the accepted poses, or wanted shares, as for `sensitivity`.
    within : float
        How far the outline, and the centre of mass, may move, metres. A symmetric part
        stays as symmetric as it is, or as the wanted shares are.
    drops : int
        The most of each part that is dropped: to choose each step, and then of the part
        as it is and after each step. They end as those of `sensitivity` do.
    seed, restitution, drop_height, cluster_tolerance, round_sides, workers
        As for `simulate`.
    on_progress : callable
        Takes the share done, 0 to 1.
    should_stop : callable
        After True the steps found by then are returned.

    Raises
    ------
    RequestError
        If a value is out of its range, or `wanted` is none.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    request = drop_request(drops, seed, 0.0, workers)
    space = changes.DesignSpace(part, scene)
    model = shares.GoalModel(space, wanted)
    changes.check_reach("bound", within, space.body.radius)
    moves, estimates = _find_steps(
        model,
        within,
        replace(request, seed=(request.seed + SEEDS // 2) % SEEDS),
        lambda share: on_progress(0.75 * share),
        should_stop,
    )
    return _suggestion_of(
        model,
        within,
        moves,
        estimates,
        request,
        lambda share: on_progress(0.75 + 0.25 * share),
        should_stop,
        begin,
    )


def _suggestion_of(
    model: shares.GoalModel,
    within: float,
    moves: list[Array],
    estimates: list[float],
    request: DropRequest,
    on_progress: Callable[[float], object],
    should_stop: Callable[[], bool],
    begin: float,
) -> Suggestion:
    """Tell by drops what each of the chosen steps gains, and all of them together."""
    space = model.space
    count = len(moves)
    parts = [
        space.change(sum(moves[:taken], np.zeros(len(space.features))))
        for taken in range(count + 1)
    ]
    proved = proof.prove_gains(
        model,
        parts,
        [*((step, step + 1) for step in range(count)), (0, count)],
        request,
        on_progress,
        should_stop,
    )
    return Suggestion(
        space=space,
        within=within,
        steps=tuple(
            Step(move, estimates[number + 1] - estimates[number], proved.gains[number])
            for number, move in enumerate(moves)
        ),
        changed=parts[-1],
        outline=outline_shift(space, parts[-1]),
        center_shift=center_move(space, parts[-1]),
        before=estimates[0],
        after=estimates[-1],
        lost=model.lost_poses(parts[-1]),
        gain=proved.gains[-1],
        dropped_before=model.goal.counted_fulfilment(proved.classes[0]),
        dropped_after=model.goal.counted_fulfilment(proved.classes[-1]),
        drops=proved.drops,
        seed=request.seed,
        seconds=time.perf_counter() - begin,
    )


class _Candidate(NamedTuple):
    """A way to change a part, of those that symmetry ties together one."""

    tied: int  # features that are changed together
    move: Array  # (n,); of each feature, metres or a fraction


def _find_steps(
    model: shares.GoalModel,
    within: float,
    request: DropRequest,
    on_progress: Callable[[float], object],
    should_stop: Callable[[], bool],
) -> tuple[list[Array], list[float]]:
    """Steps, each with the largest gain after those before, and what is met by then."""
    space = model.space
    candidates = [
        _Candidate(tied, stride * step)
        for tied, step in enumerate(alike.symmetric_steps(space, within, model.goal))
        for stride in BOUND_SHARES
    ]
    moves: list[Array] = []
    estimates = [model.estimate(space.change_feature(0, 0.0))]
    total_move: Array = np.zeros(len(space.features))
    while candidates and len(moves) < MOST_STEPS:
        gains = [
            -np.inf
            if should_stop()
            else _estimate_within(model, within, total_move + candidate.move)
            - estimates[-1]
            for candidate in candidates
        ]
        # Mirror twins gain the same but for rounding: of those the first.
        rank = tolerances.number_equal(
            [-gain for gain in gains], sensitivity.SAME_CHANGE
        )
        order = np.argsort(rank, kind="stable").tolist()
        worth = [k for k in order if gains[k] >= LEAST_GAIN][:DROPPED_CANDIDATES]
        best = _choose_by_drops(
            model,
            total_move,
            [candidates[k].move for k in worth],
            request,
            lambda share: on_progress((len(moves) + share) / MOST_STEPS),
            should_stop,
        )
        if best is None:
            break
        chosen = candidates[worth[best]]
        moves.append(chosen.move)
        total_move = total_move + chosen.move
        estimates.append(estimates[-1] + gains[worth[best]])
        candidates = [
            candidates[k]
            for k in order[:CANDIDATES]
            if candidates[k].tied != chosen.tied
        ]
    return moves, estimates


def _estimate_within(model: shares.GoalModel, within: float, move: Array) -> float:
    """How far a changed part meets the goal; minus infinity beyond the bounds."""
    space = model.space
    try:
        changed_part = space.change(move)
        shift = max(
            outline_shift(space, changed_part), center_move(space, changed_part)
        )
        if shift > within * (1.0 + MOVE_SLACK):
            return -np.inf
        return model.estimate(changed_part)
    except errors.MeshError:
        return -np.inf


def _choose_by_drops(
    model: shares.GoalModel,
    total_move: Array,
    moves: list[Array],
    request: DropRequest,
    on_progress: Callable[[float], object],
    should_stop: Callable[[], bool],
) -> int | None:
    """Number of the move that gains most after those made; None where none is sure."""
    if not moves:
        return None
    proved = proof.prove_gains(
        model,
        [model.space.change(total_move)]
        + [model.space.change(total_move + move) for move in moves],
        [(0, after) for after in range(1, len(moves) + 1)],
        request,
        on_progress,
        should_stop,
    )
    gains = [gain.value if proof.is_gain(gain) else -np.inf for gain in proved.gains]
    best = int(np.argmax(gains))
    return best if np.isfinite(gains[best]) else None


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
