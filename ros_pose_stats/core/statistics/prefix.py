"""What a growing prefix of drops says: counts, errors, when to look, and whether it is enough.

Looking at fixed prefixes only makes the answer independent of workers, chunks and timing:
whatever has been computed beyond a prefix by then has no say in whether it was enough.
"""

import math
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..records import Index, statistics
from . import errors

FIRST_CHECKPOINT = (
    100  # drops before the first look; fewer say little about their own error
)

LEAST_STEPS = (8, 0.1)
"""A look costs as much as a dozen drops: the next one is at least so many drops away, and such a
share of those done."""

AHEAD = 1.1
"""Drops over those in which the target is reached by the root law: an error that an estimate has
its share in falls slower."""


def next_checkpoint(done: int, drops: int, first: int = FIRST_CHECKPOINT) -> int:
    """The first prefix longer than `done` that is looked at, at most `drops`.

    They are 100, 150, 225, 337, 505, 757, ..., each one and a half times the one before.
    """
    checkpoint = first
    while checkpoint <= done:
        checkpoint = max(checkpoint + 1, checkpoint * 3 // 2)
    return min(checkpoint, drops)


def sooner_checkpoint(done: int, error: float, target_error: float) -> float:
    """The prefix in which the target may be reached, seen from one whose bound is this error.

    The error falls at most as the root of the number of drops, so this is a little beyond.
    """
    if not math.isfinite(error):
        return math.inf
    drops, share = LEAST_STEPS
    wanted = max(1.0 + share, AHEAD * (error / target_error) ** 2)
    return max(done + drops, math.ceil(done * wanted))


def target_reached(bound: float, target_error: float) -> bool:
    """Whether a run stops where its error keeps this bound; target 0 asks for all drops."""
    return target_error > 0.0 and bound <= target_error


class Judge(NamedTuple):
    """Who knows more about the error of counts than the counts themselves."""

    judge: Callable[[Index], errors.Judged]  # from counts (K,) to what they are worth
    # drops before the first look. Later ones come where the target may be reached, at the latest
    # after half as many drops again
    first: int = FIRST_CHECKPOINT
    # seconds between judgements that are only shown: they take tens of milliseconds where poses
    # are many
    pause: float = 0.0


class Prefix:
    """Counts of the contiguous prefix of a run of `drops`, cut where the target is reached."""

    def __init__(
        self, poses: int, drops: int, target_error: float, judge: Judge | None = None
    ) -> None:
        self.bound = drops
        self.target_error = target_error
        self.counts = np.zeros(poses, dtype=np.int64)
        self.drops = 0
        self.finished = False
        self._judge = judge
        self._judged = -1, errors.Judged(math.nan, math.inf)
        self._judged_at = -math.inf
        self._first = FIRST_CHECKPOINT if judge is None else judge.first
        self._next = next_checkpoint(0, drops, self._first)

    @property
    def settled(self) -> int:
        """Drops that came to rest."""
        return int(self.counts.sum())

    @property
    def wanted(self) -> int:
        """Drops up to the next look; up to the bound where no look can end the run."""
        return self._next if self.target_error > 0.0 else self.bound

    def extend(self, drops: int) -> None:
        """Raise the bound of the run, if this one is higher."""
        self.bound = max(self.bound, drops)
        self.finished = self.drops >= self.bound
        self._next = next_checkpoint(self.drops, self.bound, self._first)

    def add(self, outcomes: Index) -> int:
        """Lengthen the prefix by outcomes, -1 for unsettled; return how many were still wanted."""
        begin = 0
        while begin < outcomes.shape[0] and not self.finished:
            end = min(outcomes.shape[0], begin + self._next - self.drops)
            some = outcomes[begin:end]
            self.counts += np.bincount(some + 1, minlength=self.counts.shape[0] + 1)[1:]
            self.drops += some.shape[0]
            begin = end
            if self.drops == self._next:
                self._look()
        return begin

    def _look(self) -> None:
        """Finish where it is enough, else set the next look; a judge's are as few as can be."""
        sooner = math.inf
        if self.target_error > 0.0:
            bound = self.judged().bound
            self.finished = target_reached(bound, self.target_error)
            if self._judge is not None and not self.finished:
                sooner = sooner_checkpoint(self.drops, bound, self.target_error)
        self.finished = self.finished or self.drops >= self.bound
        self._next = int(
            min(next_checkpoint(self.drops, self.bound, self._first), sooner)
        )

    def judged(self) -> errors.Judged:
        """What the counts are worth, by themselves or by the judge."""
        if self._judged[0] != self.drops:  # a judgement takes as long as a dozen drops
            judge = errors.judge_counts if self._judge is None else self._judge.judge
            self._judged = self.drops, judge(self.counts)
            self._judged_at = time.monotonic()
        return self._judged[1]

    def recently_judged(self) -> errors.Judged:
        """The same, to be shown: while drops go on, a judge's may be as old as its pause."""
        if (
            self._judge is None
            or self.finished
            or (time.monotonic() - self._judged_at >= self._judge.pause)
        ):
            return self.judged()
        return self._judged[1]


def counted_shares(counts: Index) -> statistics.Shares:
    """Shares of settled drops (K,) with their errors; NaN as long as nothing has settled."""
    settled = int(counts.sum())
    deviations = errors.standard_errors(counts, settled)
    low, high = (
        (np.ones(1), np.ones(1))
        if counts.size == 1 and settled
        else errors.jeffreys_interval(counts, settled)
    )
    share = counts / settled if settled else np.full(deviations.shape, math.nan)
    return statistics.Shares(
        share,
        low,
        high,
        deviations,
        counts,
        errors.root_mean_square(deviations),
        errors.largest_error(deviations, errors.DEFAULT_LEVEL),
    )
