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

"""Which changes of a part bring it nearer to its goal, one at a time.

The fast estimator finds what is worth a try, by steps to both sides. Drops of the part
before and after, from the same starts, tell what gains: that alone is listed, drawn and
recommended.
"""

import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ...base import errors, version
from ...base.text import points, several
from ...core import tolerances
from ...core.planning.auto import auto
from ...core.records import Array, DropScene, Part, PoseStatistics
from ...core.records.notes import Note
from ...core.records.plain_values import with_units
from ...core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    DEFAULT_SEED,
)
from ...core.records.statistics import require_same_part
from ...core.simulation.request import DropRequest, drop_request
from ...core.statistics import feeding, pose_groups
from . import alike, changes, describe, paired_drops, proof, shares
from .goal import Goal, Wanted

STEP = 0.05
"""Of the radius, and of stretching as a fraction: a change that a designer would make.
What less does is lost in the estimator's own unevenness (docs/measured/design.md)."""

SAME_CHANGE = 1e-9
"""Changes of a share this close are a tie: by symmetry both ways change it alike."""

CHECKS = 6
CHECK_DROPS = 20_000
"""Effects that are checked, and the most drops of the part before and after each."""

SCATTER = 0.005
SCATTER_OF_SLOPE = 0.2
SCATTER_OF_UNEVEN = 0.5
"""Root mean square difference of estimated and dropped changes by one step: of any, as
a share of the change, and as a share of its unevenness (docs/measured/design.md)."""


@dataclass(frozen=True, eq=False)
class Effect:
    """What a change of one feature does."""

    feature: changes.Feature
    number: int  # of the feature
    # numbers of the features that do the same by the part's symmetry, this one first
    alike: tuple[int, ...]
    # change of the share a metre, or a unit of stretching, and its standard error
    slope: float
    error: float
    step: float  # the change that helps by estimate, metres or a fraction
    change: float  # estimated change of the share by that step
    lost: tuple[int, ...] = ()  # wanted poses that are gone after that step
    # the same change by drops; None where it was not checked
    check: paired_drops.PairedDifference | None = None

    @property
    def is_promising(self) -> bool:
        """Whether the estimated gain is more than its error."""
        return self.change > self.error * abs(self.step)

    @property
    def gains(self) -> bool:
        """Whether drops show a gain."""
        return self.check is not None and proof.is_gain(self.check)

    @property
    def contradicted(self) -> bool:
        """Whether drops exclude the estimated change, and show none to its side."""
        if self.check is None or math.isnan(self.check.value) or self.gains:
            return False
        return not self.check.low <= self.change <= self.check.high

    @property
    def remark(self) -> str:
        """In words, why drops do not show that it gains; "" where they do."""
        if self.check is None or self.gains:
            return ""
        return describe.CONTRADICTED if self.contradicted else describe.UNSURE


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What changes of a part do to how far it meets its goal."""

    space: changes.DesignSpace
    goal: Goal
    scene: DropScene  # with the drop height in metres
    method: str  # that tells how far the part as it is meets its goal
    accepted: feeding.Bounded  # how far it does
    class_shares: Array  # (C,); share of each class of the goal
    # the change that is meant, metres; stretching is by the same share of the radius
    step: float
    effects: tuple[Effect, ...]  # the greatest first, by the estimate of their step
    drops: int  # of the part before, and after each checked step
    seed: int
    seconds: float
    # of the answer, and about the wanted poses
    warnings: tuple[Note, ...] = ()

    @property
    def wanted(self) -> tuple[int, ...]:
        """Wanted poses, rising."""
        return self.goal.wanted_poses

    @property
    def share(self) -> float:
        """Share of the wanted poses, without its interval."""
        return self.accepted.value

    @property
    def checked(self) -> list[tuple[Effect, paired_drops.PairedDifference]]:
        """Effects with their checks, the greatest gain by drops first."""
        checked = [
            (effect, effect.check)
            for effect in self.effects
            if effect.check is not None
        ]
        return sorted(
            checked,
            key=lambda pair: -math.inf if math.isnan(pair[1].value) else pair[1].value,
            reverse=True,
        )

    @property
    def gains(self) -> list[tuple[Effect, paired_drops.PairedDifference]]:
        """Effects whose gain drops show, with their checks, the greatest first.

        What is drawn and recommended comes from here.
        """
        return [pair for pair in self.checked if pair[0].gains]

    def describe_goal(self) -> str:
        """What is wanted, and how far the part as it is meets that, in words."""
        met = ""
        if self.goal.has_shares:
            met = "met to "
        value, low, high = (100.0 * share for share in self.accepted)
        return (
            f"wanted {self.goal.describe()}: {met}{value:.1f} % "
            f"[{low:.1f} to {high:.1f} %] by {self.method}"
        )

    def describe_gain(self) -> str:
        """The change that gains most, in words, of those whose gain is sure."""
        if self.gains:
            effect, check = self.gains[0]
            step = describe.name_step(self.space, effect.number, effect.step)
            return (
                f"gains most: {step}: {points(check.value)} points by drops "
                f"({points(check.low)} to {points(check.high)}), "
                f"{points(effect.change)} by estimate"
            )
        if self.checked:
            steps = "step"
            if len(self.checked) > 1:
                steps = f"{len(self.checked)} steps"
            ending = "; more drops may"
            if all(proof.is_known(check) for _, check in self.checked):
                ending = f", to {100.0 * proof.KNOWN_GAIN:g} points"
            return (
                f"no gain is sure: of the best {steps} by estimate, {self.drops} drops "
                f"show none{ending}"
            )
        promising = [effect for effect in self.effects if effect.is_promising]
        if promising:
            return (
                f"no step was dropped: {several(len(promising), 'step')} may gain by "
                f"estimate, up to {points(promising[0].change)} points"
            )
        percent = 100.0 * self.step / self.space.body.radius
        return (
            f"nothing to gain: no step of {1e3 * self.step:.3g} mm or {percent:.3g} % "
            "gains more than its own error by estimate"
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values; lengths in metres, shares as fractions, NaN as None.

        The `unit` of an effect is that of its step, `slope_unit` that of its slope and
        its error.
        """
        space = self.space
        return with_units(
            {
                "part_id": space.part.part_id,
                "part_digest": space.part.digest,
                "radius": space.body.radius,
                "method": self.method,
                **asdict(self.scene),
                "wanted": self.wanted,
                "target": self._target_as_dict(),
                "share": self.accepted.value,
                "share_low": self.accepted.low,
                "share_high": self.accepted.high,
                "step": self.step,
                "effects": [
                    {
                        **describe.feature_as_dict(space, effect.number),
                        "alike": len(effect.alike),
                        "slope": effect.slope,
                        "error": effect.error,
                        "slope_unit": "1/m" if effect.feature.is_length else "1",
                        "step": effect.step,
                        "change": effect.change,
                        "lost": effect.lost,
                        "gains": effect.gains,
                        "contradicted": effect.contradicted,
                        "check": None
                        if effect.check is None
                        else describe.difference_as_dict(effect.check),
                    }
                    for effect in self.effects
                ],
                "drops": self.drops,
                "seed": self.seed,
                "seconds": self.seconds,
                "warnings": self.warnings,
                "version": version.VERSION,
            }
        )

    def _target_as_dict(self) -> list[dict[str, Any]] | None:
        """Wanted and estimated shares by class; None where one sum is wanted."""
        if not self.goal.has_shares:
            return None
        return [
            {
                "poses": self.goal.poses(number),
                "wanted_share": float(self.goal.shares[number]),
                "share": float(self.class_shares[number]),
            }
            for number in range(1, self.goal.shares.size)
        ]


def effect_error(slope: float, uneven: float) -> float:
    """Standard error of the estimated change by one step, `slope`.

    `uneven`: half of how far the changes to both sides are from a line.
    """
    return math.hypot(SCATTER, SCATTER_OF_SLOPE * slope, SCATTER_OF_UNEVEN * uneven)


def sensitivity(
    part: Part,
    wanted: Wanted,
    *,
    answer: PoseStatistics | None = None,
    step: float | None = None,
    checks: int = CHECKS,
    drops: int = CHECK_DROPS,
    seed: int = DEFAULT_SEED,
    restitution: float = DEFAULT_RESTITUTION,
    drop_height: float | None = None,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
    workers: int | None = None,
    on_progress: Callable[[float], object] = lambda share: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Sensitivity:
    """Changes of centre of mass, proportions and faces that make a part rest as wanted.

    Parameters
    ----------
    part : Part
    wanted : sequence of int, or mapping
        Indices of the accepted poses; or the wanted share of each pose, as a mapping of
        an index, or of several that are taken together, to a fraction or per cent.
    answer : PoseStatistics, optional
        Of the part as it is, in this scene; default: that of `estimate`.
    step : float, optional
        Change that is meant, metres; default: a twentieth of the radius. Stretching is
        by the same share of the radius.
    checks : int
        Effects that are checked by drops: those that gain most by estimate, by more
        than their error.
    drops : int
        The most of the part before, and after each checked step, from the same starts.
        They end where each gain is known to 1.25 points, 90 % intervals together.
    seed : int
        Of all drops, also those of the default answer, which is by the same seed.
    restitution, drop_height, cluster_tolerance, round_sides, workers
        As for `simulate`.
    on_progress : callable
        Takes the share done, 0 to 1.
    should_stop : callable
        After True what is known by then is returned.

    Raises
    ------
    RequestError
        If a value is out of its range, there is no such pose, the wanted shares are not
        those of all poses with the sum 1 or 100, or the answer is of other poses.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    request = drop_request(drops, seed, 0.0, workers)
    if checks < 0:
        raise errors.RequestError(
            "a number of checks from 0", f"{checks}", "0 drops none of them"
        )
    space = changes.DesignSpace(part, scene)
    model = shares.GoalModel(space, wanted)
    step_length = STEP * space.body.radius if step is None else step
    changes.check_reach("step", step_length, space.body.radius)
    if answer is None:
        answer = auto(
            part,
            seed=request.seed,
            workers=request.workers,
            should_stop=should_stop,
            **asdict(scene),
        )
    require_same_part(answer, part)
    if answer.numbering != scene.numbering.code(part.digest):
        raise errors.RequestError(
            "statistics of the part's poses in this scene",
            "those of other poses",
            "take the same cluster tolerance and round sides for both",
        )
    effects = _find_effects(
        model,
        step_length,
        request.workers,
        lambda share: on_progress(0.5 * share),
        should_stop,
    )
    drops_done = _check_effects(
        model,
        effects,
        checks,
        request,
        lambda share: on_progress(0.5 + 0.5 * share),
        should_stop,
    )
    accepted, class_shares = _part_as_it_is(model.goal, answer)
    return Sensitivity(
        space,
        model.goal,
        model.scene,
        answer.method,
        accepted,
        class_shares,
        step_length,
        tuple(effects),
        drops_done,
        request.seed,
        time.perf_counter() - begin,
        (*answer.warnings, *_warn_of_lookalikes(answer, model.goal)),
    )


def _part_as_it_is(
    goal: Goal, statistics: PoseStatistics
) -> tuple[feeding.Bounded, Array]:
    """How far a part meets its goal, and the share of each class (C,)."""
    shares = pose_groups.pose_shares(statistics)
    if goal.has_shares:
        accepted = goal.estimated_fulfilment(shares)
    else:
        accepted = feeding.share_of_poses(statistics, goal.wanted_poses)
    return accepted, goal.class_shares(shares.probability)


def _warn_of_lookalikes(answer: PoseStatistics, goal: Goal) -> tuple[Note, ...]:
    """Whoever wants shares of single poses knows that others look like them."""
    if goal.has_shares:
        return ()
    return pose_groups.warn_of_lookalikes(answer, goal.wanted_poses)


def _check_effects(
    model: shares.GoalModel,
    effects: list[Effect],
    checks: int,
    request: DropRequest,
    on_progress: Callable[[float], object],
    should_stop: Callable[[], bool],
) -> int:
    """Put checks by drops to the most promising effects; the drops of each part."""
    promising = [
        number for number, effect in enumerate(effects) if effect.is_promising
    ][:checks]
    if not promising:
        return 0
    space = model.space
    changed_parts = [space.change_feature(0, 0.0)] + [
        space.change_feature(effects[number].number, effects[number].step)
        for number in promising
    ]
    proved = proof.prove_gains(
        model,
        changed_parts,
        [(0, after) for after in range(1, len(changed_parts))],
        request,
        on_progress,
        should_stop,
    )
    if proved.drops:
        for number, gain in zip(promising, proved.gains, strict=True):
            effects[number] = replace(effects[number], check=gain)
    return proved.drops


def _find_effects(
    model: shares.GoalModel,
    step_length: float,
    workers: int,
    on_progress: Callable[[float], object],
    should_stop: Callable[[], bool],
) -> list[Effect]:
    """Effects of all features, the greatest first.

    Those of which no body remains after the step are left out.
    """
    space = model.space
    equivalents = alike.first_equivalents(space, model.goal)
    numbers = np.unique(equivalents).tolist()
    base_share = model.estimate(space.change_feature(0, 0.0))
    finished = iter(range(1, len(numbers) + 1))

    def find_effect(number: int) -> Effect | None:
        if should_stop():
            return None
        feature = space.features[number]
        step = step_length if feature.is_length else step_length / space.body.radius
        try:
            parts = [space.change_feature(number, side) for side in (-step, step)]
        except errors.MeshError:
            return None
        finally:
            on_progress(next(finished) / len(numbers))
        inward, outward = (model.estimate(part) - base_share for part in parts)
        slope = 0.5 * (outward - inward)
        error = effect_error(slope, 0.5 * abs(outward + inward))
        is_inward = inward > outward + SAME_CHANGE
        return Effect(
            feature=feature,
            number=number,
            alike=tuple(np.flatnonzero(equivalents == number).tolist()),
            slope=slope / step,
            error=error / step,
            step=-step if is_inward else step,
            change=inward if is_inward else outward,
            lost=model.lost_poses(parts[0] if is_inward else parts[1]),
        )

    with ThreadPoolExecutor(workers) as pool:
        effects = [effect for effect in pool.map(find_effect, numbers) if effect]
    rank = tolerances.number_equal(
        [-abs(effect.change) for effect in effects], SAME_CHANGE
    )
    return [effects[k] for k in np.argsort(rank, kind="stable")]
