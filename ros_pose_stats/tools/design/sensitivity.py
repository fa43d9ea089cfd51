"""How the share of wanted poses changes with each thing that can be changed on a part.

Derivatives come from the fast estimator, fitted over steps to both sides; those that
matter most are checked by drops of the part before and after from the same starts.
"""

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ...base import errors, methods, version
from ...base.text import points, several
from ...core import tolerances
from ...core.estimators import estimate_in
from ...core.records import DropScene, Part
from ...core.records.notes import Note
from ...core.records.plain_values import with_units
from ...core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
)
from ...core.simulation.request import drop_request
from ...core.statistics import feeding, pose_groups
from . import alike, changes, comparison, describe, paired_drops, shares

STEP = 0.05
"""Of the radius, and of stretching as a fraction: a change that a designer would make.
What less does is lost in the estimator's own unevenness (docs/measured/design.md)."""

SAME_CHANGE = 1e-9
"""Changes of a share this close are a tie: by symmetry both ways change it alike."""

CHECKS = 5
CHECK_DROPS = 2000
"""Effects that are checked, and drops of the part before and after for each of them."""

SCATTER = 0.005
SCATTER_OF_SLOPE = 0.2
SCATTER_OF_UNEVEN = 0.5
"""Root mean square difference of estimated and dropped changes by one step: of any, as
a share of the change, and as a share of its unevenness (docs/measured/design.md)."""


@dataclass(frozen=True, eq=False)
class Effect:
    """What a change of one feature does to the share of the wanted poses."""

    feature: changes.Feature
    number: int  # of the feature
    # numbers of the features that do the same by the part's symmetry, this one first
    alike: tuple[int, ...]
    # change of the share a metre, or a unit of stretching, and its standard error
    slope: float
    error: float
    step: float  # the change that helps, metres or a fraction
    change: float  # estimated change of the share by that step
    lost: tuple[int, ...] = ()  # wanted poses that are gone after that step
    # the same change by drops; None where it was not checked
    check: paired_drops.PairedDifference | None = None

    @property
    def helps(self) -> bool:
        """Whether the step raises the share by more than the error of that."""
        return self.change > self.error * abs(self.step)

    @property
    def contradicted(self) -> bool:
        """Whether drops exclude the estimated change, and show none to its side."""
        if self.check is None or math.isnan(self.check.value):
            return False
        return (
            self.check.low <= 0.0
            and not self.check.low <= self.change <= self.check.high
        )


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What changes of a part do to the share of its wanted poses."""

    space: changes.DesignSpace
    wanted: tuple[int, ...]
    scene: DropScene  # with the drop height in metres
    method: str  # the estimator
    accepted: (
        feeding.Bounded
    )  # estimated share of the wanted poses of the part as it is
    # the change that is meant, metres; stretching is by the same share of the radius
    step: float
    effects: tuple[Effect, ...]  # the greatest first, by what their step changes
    drops: int  # of each check
    seed: int
    seconds: float
    # about the part, the estimate and the wanted poses
    warnings: tuple[Note, ...] = ()

    @property
    def share(self) -> float:
        """Estimated share of the wanted poses, without its interval."""
        return self.accepted.value

    @property
    def best(self) -> list[Effect]:
        """Effects whose step helps, the one that helps most first."""
        return [
            effect for effect in self.effects if effect.helps
        ]  # they are in that order

    @property
    def checked(self) -> list[tuple[Effect, paired_drops.PairedDifference]]:
        """Effects with their checks, in the same order."""
        return [
            (effect, effect.check) for effect in self.best if effect.check is not None
        ]

    def describe_gain(self) -> str:
        """The change that gains most, in words, of those whose gain is beyond chance.

        The drops do not choose the step, so their interval is what it says.
        """
        checked = self.checked
        if not checked and self.best:
            return self._gain_in_words(self.best[0])
        chances = paired_drops.adjust_together([check.p_value for _, check in checked])
        for (effect, check), chance in zip(checked, chances, strict=True):
            if check.value > 0.0 and chance <= comparison.LEVEL:
                return (
                    f"{self._gain_in_words(effect)}, {points(check.value)} by drops "
                    f"({points(check.low)} to {points(check.high)})"
                )
        if checked:
            return (
                f"no gain is sure: of the best {several(len(checked), 'step')}, tested "
                f"together, {self.drops} drops show none; more drops may"
            )
        percent = 100.0 * self.step / self.space.body.radius
        return (
            f"nothing to gain: no step of {1e3 * self.step:.3g} mm or {percent:.3g} % "
            "raises the share by more than its own error"
        )

    def _gain_in_words(self, effect: Effect) -> str:
        step = describe.name_step(self.space, effect.number, effect.step)
        return f"gains most by estimate: {step}: {points(effect.change)} points"

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


def effect_error(slope: float, uneven: float) -> float:
    """Standard error of the estimated change by one step, `slope`.

    `uneven`: half of how far the changes to both sides are from a line.
    """
    return math.hypot(SCATTER, SCATTER_OF_SLOPE * slope, SCATTER_OF_UNEVEN * uneven)


def sensitivity(
    part: Part,
    wanted: Sequence[int],
    *,
    step: float | None = None,
    checks: int = CHECKS,
    drops: int = CHECK_DROPS,
    seed: int | None = None,
    restitution: float = DEFAULT_RESTITUTION,
    drop_height: float | None = None,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
    workers: int | None = None,
    on_progress: Callable[[float], object] = lambda share: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Sensitivity:
    """How the share of wanted poses changes with centre of mass, proportions and faces.

    Parameters
    ----------
    part : Part
    wanted : sequence of int
        Indices of the accepted poses.
    step : float, optional
        Change that is meant, metres; default: a twentieth of the radius. Stretching is
        by the same share of the radius.
    checks : int
        Effects that are checked by drops: those that raise the share most, by more than
        their error.
    drops : int
        Of the part before, and after, for each check. Each check has drops of its own.
    seed : int, optional
        Of the drops; the same one gives the same counts. Default: a fresh one.
    restitution, drop_height, cluster_tolerance, round_sides, workers
        As for `simulate`.
    on_progress : callable
        Takes the share done, 0 to 1.
    should_stop : callable
        After True what is known by then is returned.

    Raises
    ------
    RequestError
        If a value is out of its range or there is no such pose.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    request = drop_request(drops, seed, 0.0, workers)
    if checks < 0:
        raise errors.RequestError(
            "a number of checks from 0", f"{checks}", "0 drops none of them"
        )
    space = changes.DesignSpace(part, scene)
    model = shares.WantedShare(space, wanted)
    step_length = STEP * space.body.radius if step is None else step
    changes.check_reach("step", step_length, space.body.radius)
    estimate = estimate_in(part, model.scene, methods.AUTO)
    effects = _find_effects(
        space,
        model,
        step_length,
        request.workers,
        lambda share: on_progress(0.5 * share),
        should_stop,
    )
    checked = [number for number, effect in enumerate(effects) if effect.helps][:checks]
    for count, number in enumerate(checked):
        if should_stop():
            break
        first_drop = count * request.drops

        def report(drops_done: int, first_drop: int = first_drop) -> None:
            share = (2 * first_drop + drops_done) / (request.drops * len(checked))
            on_progress(0.5 + 0.25 * share)

        effect = effects[number]
        outcomes = model.drop(
            [space.change_feature(effect.number, step) for step in (0.0, effect.step)],
            request,
            report,
            should_stop,
            first_drop,
        )
        effects[number] = replace(
            effect, check=paired_drops.paired_difference(*outcomes)
        )
    return Sensitivity(
        space,
        model.wanted_poses,
        model.scene,
        estimate.method,
        feeding.accepted_share(pose_groups.pose_shares(estimate), model.wanted_poses),
        step_length,
        tuple(effects),
        request.drops,
        request.seed,
        time.perf_counter() - begin,
        (
            *estimate.warnings,
            *pose_groups.warn_of_lookalikes(estimate, model.wanted_poses),
        ),
    )


def _find_effects(
    space: changes.DesignSpace,
    model: shares.WantedShare,
    step_length: float,
    workers: int,
    on_progress: Callable[[float], object],
    should_stop: Callable[[], bool],
) -> list[Effect]:
    """Effects of all features, the greatest first.

    Those of which no body remains after the step are left out.
    """
    equivalents = alike.first_equivalents(space, model.is_wanted)
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
