"""What a change of one feature does to the share of the wanted poses, and how sure that is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from ..records import DropScene
from ..statistics.feeding import Bounded
from ..statistics.paired_counts import PairedDifference
from ..version import VERSION
from .changes import DesignSpace
from .features import Feature

SCATTER: Final = 0.005
SCATTER_OF_CUT: Final = 0.012
SCATTER_OF_SLOPE: Final = 0.2
SCATTER_OF_UNEVEN: Final = 0.5
"""Root mean square difference of estimated and dropped changes by one step: of any, of a cut edge,
as a share of the change, and as a share of its unevenness (docs/measured/design.md)."""


@dataclass(frozen=True, eq=False)
class Effect:
    """What a change of one feature does to the share of the wanted poses."""

    feature: Feature
    number: int  # of the feature
    # numbers of the features that do the same by the part's symmetry, this one first
    alike: tuple[int, ...]
    slope: float  # change of the share a metre, or a unit of stretching, and its standard error
    error: float
    # the change that helps, metres or a fraction; of an edge, that which it can be given
    step: float
    change: float  # estimated change of the share by that step
    lost: tuple[int, ...] = ()  # wanted poses that are gone after that step
    # the same change by drops; None where it was not checked
    check: PairedDifference | None = None

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

    space: DesignSpace
    wanted: tuple[int, ...]
    scene: DropScene  # with the drop height in metres
    method: str  # the estimator
    accepted: Bounded  # estimated share of the wanted poses of the part as it is
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


def effect_error(slope: float, uneven: float, *, cut: bool = False) -> float:
    """Standard error of the change by one step.

    `slope`: estimated change by one step; `uneven`: half of how far the changes by two steps are
    from a line: a share that bends or jumps within a step has no single slope; `cut`: whether an
    edge is cut, which the estimator knows least.
    """
    return math.hypot(SCATTER_OF_CUT if cut else SCATTER,
                      SCATTER_OF_SLOPE * slope, SCATTER_OF_UNEVEN * uneven)
