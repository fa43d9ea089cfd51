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

"""A growing prefix of drops: counts, errors, when to look, when to stop.

Looking at fixed prefixes only makes the answer independent of workers, chunks and
timing: whatever has been computed beyond a prefix by then has no say in whether it was
enough.
"""

import math
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..records import Index
from ..records.shares import Shares
from . import errors

FIRST_CHECKPOINT = 100
"""Drops before the first look; fewer say little about their own error."""

SMALLEST_STEP = (8, 0.1)
"""A look costs as much as a dozen drops: the next one is at least so many drops away,
and such a share of those done."""

CHECKPOINT_MARGIN = 1.1
"""Drops over those in which the target is reached by the root law: an error that an
estimate has its share in falls slower."""


def next_checkpoint(drops_done: int, drops: int, first: int) -> int:
    """The first prefix longer than `done` that is looked at, at most `drops`.

    They are 100, 150, 225, 337, 505, 757, ..., each one and a half times the one
    before.
    """
    checkpoint = first
    while checkpoint <= drops_done:
        checkpoint = max(checkpoint + 1, checkpoint * 3 // 2)
    return min(checkpoint, drops)


def earliest_checkpoint(drops_done: int, error: float, target_error: float) -> float:
    """The prefix in which the target may be reached, given the bound of this one.

    The error falls at most as the root of the number of drops, so this is a little
    beyond.
    """
    if not math.isfinite(error):
        return math.inf
    drops, share = SMALLEST_STEP
    growth = max(1.0 + share, CHECKPOINT_MARGIN * (error / target_error) ** 2)
    return max(drops_done + drops, math.ceil(drops_done * growth))


def target_reached(bound: float, target_error: float) -> bool:
    """Whether a run stops at this bound; target 0 asks for all drops."""
    return target_error > 0.0 and bound <= target_error


class Judge(NamedTuple):
    """Who knows more about the error of counts than the counts themselves."""

    # from counts (K,) to what they are worth
    judge: Callable[[Index], errors.Judgement]
    # drops before the first look. Later ones come where the target may be reached, at
    # the latest after half as many drops again
    first: int = FIRST_CHECKPOINT
    # seconds between judgements that are only shown: they take tens of milliseconds
    # where poses are many
    pause: float = 0.0


class Prefix:
    """Counts of the first drops of a run, cut where the target is reached."""

    def __init__(
        self, poses: int, drops: int, target_error: float, judge: Judge | None
    ) -> None:
        self.drop_bound = drops
        self.target_error = target_error
        self.counts = np.zeros(poses, dtype=np.int64)
        self.drops = 0
        self.finished = False
        self._judge = judge
        self._last_judgement = -1, errors.Judgement(math.nan, math.inf)
        self._judged_at = -math.inf
        self._first_checkpoint = FIRST_CHECKPOINT if judge is None else judge.first
        self._next_checkpoint = next_checkpoint(0, drops, self._first_checkpoint)

    @property
    def settled_drops(self) -> int:
        """Drops that came to rest."""
        return int(self.counts.sum())

    @property
    def requested_drops(self) -> int:
        """Drops up to the next look; up to the bound where no look can end the run."""
        return self._next_checkpoint if self.target_error > 0.0 else self.drop_bound

    def extend(self, drops: int) -> None:
        """Raise the bound of the run, if this one is higher."""
        self.drop_bound = max(self.drop_bound, drops)
        self.finished = self.drops >= self.drop_bound
        self._next_checkpoint = next_checkpoint(
            self.drops, self.drop_bound, self._first_checkpoint
        )

    def add(self, outcomes: Index) -> int:
        """Lengthen the prefix by outcomes, -1 for unsettled; return how many."""
        begin = 0
        while begin < outcomes.shape[0] and not self.finished:
            end = min(outcomes.shape[0], begin + self._next_checkpoint - self.drops)
            batch = outcomes[begin:end]
            counts = np.bincount(batch + 1, minlength=self.counts.shape[0] + 1)
            self.counts += counts[1:]
            self.drops += batch.shape[0]
            begin = end
            if self.drops == self._next_checkpoint:
                self._check_target()
        return begin

    def _check_target(self) -> None:
        """Finish where the target is reached, else set the next look.

        With a judge there are as few looks as can be, since each takes time.
        """
        checkpoint = math.inf
        if self.target_error > 0.0:
            bound = self.judgement().bound
            self.finished = target_reached(bound, self.target_error)
            if self._judge is not None and not self.finished:
                checkpoint = earliest_checkpoint(self.drops, bound, self.target_error)
        self.finished = self.finished or self.drops >= self.drop_bound
        latest = next_checkpoint(self.drops, self.drop_bound, self._first_checkpoint)
        self._next_checkpoint = int(min(latest, checkpoint))

    def judgement(self) -> errors.Judgement:
        """What the counts are worth, by themselves or by the judge."""
        # A judgement takes as long as a dozen drops.
        if self._last_judgement[0] != self.drops:
            judge = errors.judge_counts if self._judge is None else self._judge.judge
            self._last_judgement = self.drops, judge(self.counts)
            self._judged_at = time.monotonic()
        return self._last_judgement[1]

    def recent_judgement(self) -> errors.Judgement:
        """A judgement to be shown, as old as the judge's pause while drops go on."""
        pause = 0.0 if self._judge is None or self.finished else self._judge.pause
        if time.monotonic() - self._judged_at >= pause:
            return self.judgement()
        return self._last_judgement[1]


def counted_shares(counts: Index) -> Shares:
    """Shares of settled drops (K,) with their errors; NaN without settled drops."""
    settled_drops = int(counts.sum())
    deviations = errors.standard_errors(counts, settled_drops)
    low, high = errors.jeffreys_interval(counts, settled_drops)
    share = np.full(deviations.shape, math.nan)
    if settled_drops:
        share = counts / settled_drops
    if counts.size == 1 and settled_drops:
        low = np.ones(1)
    return Shares(
        share,
        low,
        high,
        deviations,
        counts,
        errors.root_mean_square(deviations),
        errors.largest_error(deviations, errors.DEFAULT_LEVEL),
    )
