"""What a change of a part does to the share of the wanted poses: estimated, and checked by drops.

The part is dropped before and after from the same starts.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..records import DropScene
from ..simulation.request import DropRequest
from ..statistics import feeding, paired_counts
from ..version import VERSION
from . import changes, features, paired_drops, shares

SCATTER = 0.005
SCATTER_OF_SLOPE = 0.2
SCATTER_OF_UNEVEN = 0.5
"""Root mean square difference of estimated and dropped changes by one step: of any, as a share of
the change, and as a share of its unevenness (docs/measured/design.md)."""


@dataclass(frozen=True, eq=False)
class Effect:
    """What a change of one feature does to the share of the wanted poses."""

    feature: features.Feature
    number: int  # of the feature
    # numbers of the features that do the same by the part's symmetry, this one first
    alike: tuple[int, ...]
    slope: float  # change of the share a metre, or a unit of stretching, and its standard error
    error: float
    step: float  # the change that helps, metres or a fraction
    change: float  # estimated change of the share by that step
    lost: tuple[int, ...] = ()  # wanted poses that are gone after that step
    # the same change by drops; None where it was not checked
    check: paired_counts.PairedDifference | None = None

    @property
    def helps(self) -> bool:
        """Whether the step raises the share."""
        return self.change > 0.0

    @property
    def contradicted(self) -> bool:
        """Whether drops leave out the estimated change, and do not show one to the same side."""
        if self.check is None or math.isnan(self.check.value):
            return False
        low, high = self.check.low, self.check.high
        same_side = low > 0.0 if self.change > 0.0 else high < 0.0
        return not low <= self.change <= high and not same_side


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What changes of a part do to the share of its wanted poses."""

    space: changes.DesignSpace
    wanted: tuple[int, ...]
    scene: DropScene  # with the drop height in metres
    method: str  # the estimator
    accepted: feeding.Bounded  # estimated share of the wanted poses of the part as it is
    step: float  # the change that is meant, metres; stretching is by the same share of the radius
    effects: tuple[Effect, ...]  # the greatest first, by what their step changes
    drops: int  # of each check
    seed: int
    most_drops: int  # that were asked for
    out_of_time: bool  # whether time ended the checks before that
    seconds: float
    # about the part, the estimate and the wanted poses, each `CODE: sentence`
    warnings: tuple[str, ...] = ()
    version: str = VERSION

    @property
    def share(self) -> float:
        """Estimated share of the wanted poses, without its interval."""
        return self.accepted.value


def effect_error(slope: float, uneven: float) -> float:
    """Standard error of the change by one step.

    `slope`: estimated change by one step; `uneven`: half of how far the changes by two steps are
    from a line: a share that bends or jumps within a step has no single slope.
    """
    return math.hypot(SCATTER, SCATTER_OF_SLOPE * slope, SCATTER_OF_UNEVEN * uneven)


LOOKS = (62, 125, 250, 500, 1000, 2000, 4000)
"""Drops after which the clock is looked at."""

FEW, PATIENCE = 250, 4.0
"""Drops until which so many times the time is granted."""


class CheckDrops(NamedTuple):
    """Drops of a part and of what was made of it."""

    pairs: paired_drops.PairedDrops
    # of the share of the wanted poses, from the first part to each of the others
    differences: list[paired_counts.PairedDifference]
    out_of_time: bool  # whether time ended them before the drops that were asked for


def drop_changed(changed: Sequence[changes.ChangedPart], model: shares.WantedShare,
                 asked: DropRequest,
                 seconds: float | None, on_progress: Callable[[float], object],
                 should_stop: Callable[[], bool]) -> CheckDrops:
    """Drop a part and what was made of it from the same starts.

    What comes out has no say in when it ends: intervals would be too narrow, and changes too
    large.

    `changed`: the part as it is first; `seconds`: after which no more drops are begun, of few four
    times that; None for no bound; `on_progress`: takes the share done.
    """
    parts, begin, late = [one.part for one in changed], time.perf_counter(), False
    pairs = paired_drops.begin_pairs(parts, model.scene, asked.seed)
    for wanted in sorted({min(one, asked.drops) for one in (*LOOKS, asked.drops)}):
        pairs = paired_drops.drop_more(pairs, parts, wanted, workers=asked.workers,
                                       should_stop=should_stop)
        on_progress(wanted / asked.drops)
        # The next look takes as long again as all before. Few drops say little.
        patience = PATIENCE if pairs.drops < FEW else 1.0
        late = seconds is not None and (
            2.0 * (time.perf_counter() - begin) > patience * seconds)
        if late or should_stop():
            break
    return CheckDrops(pairs, compare_with_first(pairs, changed, model),
                      late and pairs.drops < asked.drops)


def check_effects(effects: Sequence[Effect], changed: Sequence[changes.ChangedPart],
                  model: shares.WantedShare,
                  asked: DropRequest, seconds: float | None,
                  on_progress: Callable[[float], object], should_stop: Callable[[], bool]
                  ) -> tuple[tuple[Effect, ...], CheckDrops]:
    """Drop the part before and after some changes; see `drop_changed`.

    Returns the same with their checks.
    """
    found = drop_changed(changed, model, asked, seconds, on_progress, should_stop)
    return tuple(replace(effect, check=one)
                 for effect, one in zip(effects, found.differences, strict=True)), found


def compare_with_first(pairs: paired_drops.PairedDrops, changed: Sequence[changes.ChangedPart],
                       model: shares.WantedShare
                       ) -> list[paired_counts.PairedDifference]:
    """Change of the wanted share from the first part to each of the others."""
    accepted = [np.flatnonzero(model.accepted(resting, one.origin)).tolist()
                for resting, one in zip(pairs.resting, changed, strict=True)]
    return [pairs.difference(0, accepted[0], place, accepted[place])
            for place in range(1, len(changed))]
