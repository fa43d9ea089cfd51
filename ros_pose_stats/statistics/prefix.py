"""What a growing prefix of drops says: counts, errors, and whether it is enough."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .blocks import BlockSums
from .errors import expected_error, standard_errors
from .intervals import jeffreys_interval
from .stopping import FIRST_CHECKPOINT, next_checkpoint, sooner_checkpoint, target_reached

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Judge:
    """Who knows more about the error of counts than the counts themselves.

    Attributes
    ----------
    error : callable
        From counts (K,) to the error that is compared with the target, a fraction.
    means : str
        What that error is, for a sentence.
    first : int
        Drops before the first look. Later ones come where the target may be reached, at the
        latest after half as many drops again.
    pause : float
        Seconds between judgements that are only shown: they take tens of milliseconds where
        poses are many.
    """

    error: Callable[[Index], float]
    means: str = "expected error"
    first: int = FIRST_CHECKPOINT
    pause: float = 0.0


class Prefix:
    """Counts of the contiguous prefix of a run, cut where the target is reached.

    Parameters
    ----------
    poses : int
        K, the number of poses.
    drops : int
        The bound of the run.
    target_error : float
        Stop at the first checkpoint with at most this expected error; 0 for never.
    blocks : bool
        Whether the drops come in independently rotated blocks, whose scatter then gives the
        errors in place of the binomial ones.
    judge : Judge, optional
        Tells the error in their place.
    """

    def __init__(self, poses: int, drops: int, target_error: float, blocks: bool,
                 judge: Judge | None = None) -> None:
        self.bound = drops
        self.target_error = target_error
        self.counts = np.zeros(poses, dtype=np.int64)
        self.drops = 0
        self.finished = False
        self._sums = BlockSums(poses) if blocks else None
        self._judge = judge
        self._judged = -1, math.nan
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

    def add(self, outcomes: Index) -> int:
        """Lengthen the prefix; return how many of the drops were still wanted.

        Parameters
        ----------
        outcomes : (n,) array of int
            Index of the pose of each next drop; -1 where it did not settle.
        """
        begin = 0
        while begin < outcomes.shape[0] and not self.finished:
            end = min(outcomes.shape[0], begin + self._next - self.drops)
            self._count(outcomes[begin:end])
            begin = end
            if self.drops == self._next:
                self._look()
        return begin

    def _look(self) -> None:
        """Finish where it is enough, else set the next look; a judge's are as few as can be."""
        sooner = math.inf
        if self.target_error > 0.0:
            error = self.expected_error()
            self.finished = target_reached(error, self.target_error)
            if self._judge is not None and not self.finished:
                sooner = sooner_checkpoint(self.drops, error, self.target_error)
        self.finished = self.finished or self.drops >= self.bound
        self._next = int(min(next_checkpoint(self.drops, self.bound, self._first), sooner))

    def _count(self, outcomes: Index) -> None:
        self.counts += np.bincount(outcomes + 1, minlength=self.counts.shape[0] + 1)[1:]
        self.drops += outcomes.shape[0]
        if self._sums is not None:
            self._sums.add(outcomes)

    def standard_errors(self) -> Array:
        """Of each pose's count / settled, (K,); NaN as long as nothing has settled."""
        factor = 1.0 if self._sums is None else self._sums.factor()
        return math.sqrt(factor) * standard_errors(self.counts, self.settled)

    def expected_error(self) -> float:
        """Root mean square of the standard errors, or what the judge says."""
        if self._judge is not None:
            if self._judged[0] != self.drops:  # a judgement takes as long as a dozen drops
                self._judged = self.drops, self._judge.error(self.counts)
                self._judged_at = time.monotonic()
            return self._judged[1]
        return expected_error(self.standard_errors())

    def recent_error(self) -> float:
        """The same, to be shown: while drops go on, a judge's may be as old as its pause."""
        if self._judge is None or self.finished or (
                time.monotonic() - self._judged_at >= self._judge.pause):
            return self.expected_error()
        return self._judged[1]

    def interval(self) -> tuple[Array, Array]:
        """Bounds (K,) of the 90 % Jeffreys intervals."""
        if self.counts.shape[0] == 1 and self.settled:
            return np.ones(1), np.ones(1)
        factor = np.ones(1) if self._sums is None else self._sums.factors()
        return jeffreys_interval(self.counts / factor, self.settled / factor)
