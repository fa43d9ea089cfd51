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

"""Variants of a part dropped from the same starts, so that chance cancels.

Drop k of every variant begins with the same direction down, in the part's own frame;
where a variant is turned in the frame of its file, so is the direction. The drops of
one start form a pair. Where both parts of a pair come to rest alike it says nothing
about a difference, so only pairs that part count.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import bdtr, ndtri

from ...core.mesh.vectors import turn_vectors
from ...core.records import Array, DropScene, Mask, Part
from ...core.resting.poses import poses_in
from ...core.simulation import chunks, drop_body, drops as motions
from ...core.statistics import feeding
from ...core.statistics.errors import DEFAULT_LEVEL, jeffreys_interval

NO_OUTCOMES = np.zeros((2, 0), dtype=np.int64)


class PairedDrops:
    """Outcomes of the same starts for several variants.

    All are released at the height of the scene, or at 20 radii of the first, whose
    drops are those of `simulate`. `workers`: threads; `turns`: for each the rotation
    from the first one's frame to its own, None where these are equal.
    """

    def __init__(
        self,
        parts: Sequence[Part],
        scene: DropScene,
        seed: int,
        workers: int,
        should_stop: Callable[[], bool],
        turns: Sequence[Array | None] = (),
    ) -> None:
        self.parts = parts
        self.seed = seed
        self._workers = workers
        self._should_stop = should_stop
        self.resting = tuple(poses_in(part, scene) for part in parts)
        self.scene = replace(
            scene, drop_height=scene.release_height(self.resting[0].body.radius)
        )
        # (V, n): pose that each variant came to rest in, or -1; whether it was released
        # touching
        self.outcome = np.zeros((len(parts), 0), dtype=np.int64)
        self.touched = self.outcome
        self._turns = turns or (None,) * len(parts)

    @property
    def drops(self) -> int:
        """Starts so far."""
        return int(self.outcome.shape[1])

    @property
    def is_settled(self) -> Mask:
        """Starts (n,) from which every variant came to rest; only these count."""
        return np.asarray((self.outcome >= 0).all(axis=0))

    def is_in(self, variant: int, poses: Iterable[int]) -> Mask:
        """From which settled starts a variant came to rest in one of some poses."""
        return np.isin(self.outcome[variant, self.is_settled], list(poses))

    def drop_until(self, drops: int, on_progress: Callable[[int], object]) -> None:
        """Drop all variants from the next starts, until there are so many.

        `on_progress` takes the drops made of all variants together.
        """
        if self._should_stop():
            return
        done = self.outcome.size
        outcomes_by_variant = []
        for variant in range(len(self.parts)):
            outcomes_so_far = []
            for outcomes in self._drop(variant, drops):
                outcomes_so_far.append(np.stack((outcomes.pose, outcomes.touched)))
                done += outcomes.pose.size
                on_progress(done)
            outcomes_by_variant.append(
                np.concatenate([NO_OUTCOMES, *outcomes_so_far], axis=1)
            )
        common_drops = min(outcomes.shape[1] for outcomes in outcomes_by_variant)
        added = np.stack(
            [outcomes[:, :common_drops] for outcomes in outcomes_by_variant], axis=1
        )
        self.outcome, self.touched = np.concatenate(
            ((self.outcome, self.touched), added), axis=2
        )

    def _drop(self, variant: int, drops: int) -> Iterator[motions.DropOutcomes]:
        first_body = drop_body.drop_body(self.parts[0], self.scene)
        body = drop_body.drop_body(self.parts[variant], self.scene)
        turn = self._turns[variant]
        rules = motions.drop_rules(self.scene, body.radius)
        begin = self.drops

        def drop(first: int, count: int) -> motions.DropOutcomes:
            starts = motions.release_directions(
                first_body, self.seed, begin + first, count
            )
            return motions.compute_drops(
                body, rules, starts if turn is None else turn_vectors(starts, turn.T)
            )

        return chunks.DropWorkers(
            drop, drops - self.drops, self._workers, self._should_stop
        ).outcomes_in_order()


def count_share(happened: Mask) -> feeding.Bounded:
    """How often something happened, with its 90 % interval."""
    count = int(happened.sum())
    total = happened.size
    low, high = jeffreys_interval(count, total)
    return feeding.Bounded(count / total if total else 0.0, float(low), float(high))


class PairedDifference(NamedTuple):
    """How much more often one thing happened than another in the same trials."""

    value: float  # share of the second less that of the first; NaN without trials
    standard_error: float  # of the value
    low: float  # interval of the difference
    high: float
    gained: int  # trials in which only the second happened, and only the first
    lost: int
    trials: int
    # chance of trials that differ this much if none is more frequent, exact: `gained`
    # of `gained + lost` as in the tosses of a fair coin (McNemar's test)
    p_value: float


def paired_difference(
    first: Mask,
    second: Mask,
    level: float = DEFAULT_LEVEL,
    offset: float = 0.0,
    variance: float = 0.0,
) -> PairedDifference:
    """Compare how often two things happened in the same trials (n,).

    The interval, of confidence `level`, is that of Agresti and Min, "Simple improved
    confidence intervals for comparing matched proportions", Statistics in Medicine 24
    (2005): half a trial of each kind is added. `offset` and `variance` are added to the
    difference and to its variance; with them the chance is that of a normal
    distribution.
    """
    gained = int((second & ~first).sum())
    lost = int((first & ~second).sum())
    if first.size == 0:
        return PairedDifference(math.nan, math.nan, -1.0, 1.0, 0, 0, 0, 1.0)
    z = -float(ndtri(0.5 * (1.0 - level)))
    share, error = _difference_and_error(gained, lost, first.size)
    middle, spread = _difference_and_error(gained + 0.5, lost + 0.5, first.size + 2.0)
    value = share + offset
    error = math.hypot(error, math.sqrt(variance))
    spread = math.hypot(spread, math.sqrt(variance))
    chance = chance_of_split(gained, lost)
    if offset or variance:
        chance = math.erfc(abs(value) / (spread * math.sqrt(2.0)))
    return PairedDifference(
        value,
        error,
        max(-1.0, middle + offset - z * spread),
        min(1.0, middle + offset + z * spread),
        gained,
        lost,
        first.size,
        chance,
    )


def _difference_and_error(
    gained: float, lost: float, trials: float
) -> tuple[float, float]:
    """Difference of the shares and its standard error."""
    value = (gained - lost) / trials
    return value, math.sqrt(max(0.0, (gained + lost) / trials - value * value) / trials)


def chance_of_split(gained: int, lost: int) -> float:
    """Two-sided chance that a fair coin splits its tosses at least as unevenly."""
    if gained + lost == 0:
        return 1.0
    return min(1.0, 2.0 * float(bdtr(min(gained, lost), gained + lost, 0.5)))


def adjust_together(p_values: ArrayLike) -> Array:
    """Chances (K,) of tests, all wrong as seldom as one (Holm 1979)."""
    chances = np.asarray(p_values, dtype=np.float64)
    order = np.argsort(chances, kind="stable")
    steps = np.maximum.accumulate(
        chances[order] * (chances.size - np.arange(chances.size))
    )
    adjusted = np.empty_like(chances)
    adjusted[order] = np.minimum(steps, 1.0)
    return adjusted
