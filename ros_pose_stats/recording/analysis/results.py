"""The results that a bag holds for one part: what they said, and how it changed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...methods import OBSERVED, SIMULATION
from ...records.scene import Numbering, describe_scene

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class PoseTable:
    """Geometry of a part's poses in one numbering, in the order of their index."""

    index: Index  # (K,)
    group: Index
    down: Array  # (K, 3); unit vectors in the part frame
    height: Array  # (K,); metres
    top: Array
    margin: Array  # (K,); radians
    barrier: Array
    spread: Array


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a method says about a part: of each scene the result that knows most.

    That is the simulation with the most settled drops, or the newest estimate.
    """

    method: str
    restitution: float  # as asked for
    drop_height: float  # metres; NaN where the method ignores it
    plate: str  # name of the plate; empty where none was given
    time: int  # nanoseconds since 1970
    drops: int
    unsettled: int
    seed: int
    expected_error: float  # fractions; NaN where unknown
    largest_error: float
    plate_error: float
    seconds: float  # that computing took
    job_id: str
    version: str
    final: bool
    probability: Array  # (K,); in the order of the pose table
    probability_low: Array
    probability_high: Array
    standard_error: Array
    count: Index  # (K,) int; drops that came to rest in each pose; 0 for an estimate

    @property
    def scene(self) -> str:
        """How high and how bouncy, in one sentence."""
        return describe_scene(self.restitution, self.drop_height)

    @property
    def key(self) -> tuple[str, float | None, float | None]:
        """What tells predictions apart; a method that ignores the drop height is blind."""
        if math.isnan(self.drop_height):
            return self.method, None, None
        return self.method, self.restitution, self.drop_height

    @property
    def counted(self) -> bool:
        """Whether the probabilities are counts of drops, with an error of their own."""
        return self.method == SIMULATION and bool(self.count.any())

    @property
    def errors(self) -> Array:
        """Standard errors (K,); from the expected error where none are told, NaN without that."""
        spread = self.probability * (1.0 - self.probability)
        if np.isfinite(self.standard_error).all() or not spread.sum() > 0.0:
            return self.standard_error
        return np.asarray(self.expected_error * np.sqrt(spread * spread.size / spread.sum()))

    def knows_more_than(self, other: Prediction) -> bool:
        """Whether this one should stand for their common scene."""
        mine, others = self.drops - self.unsettled, other.drops - other.unsettled
        return (mine, self.time) >= (others, other.time)


@dataclass(frozen=True, eq=False)
class ResultHistory:
    """All results of a part in one numbering, by time."""

    numbering: Numbering
    poses: PoseTable
    time: Index  # (n,) int; nanoseconds since 1970
    method: NDArray[np.str_]  # (n,) str
    restitution: Array  # (n,); the latter in metres, NaN where the method ignores it
    drop_height: Array
    drops: Index  # (n,)
    unsettled: Index
    expected_error: Array  # (n,); fractions; NaN where unknown
    largest_error: Array
    # (n,); whether it was a job's last word; whether subscribers got it or a caller alone
    final: Flags
    latched: Flags
    prediction: Index  # (n,) int; which of the predictions speaks for its method and scene
    probability: Array  # (n, K)
    predictions: tuple[Prediction, ...]  # one a method and scene, in the order of first appearance

    @property
    def largest_change(self) -> Array:
        """Largest change of a probability since the result before, (n,); NaN for the first."""
        found = np.full(len(self.time), math.nan)
        if len(self.time) > 1:
            found[1:] = np.abs(np.diff(self.probability, axis=0)).max(axis=1, initial=0.0)
        return found

    @property
    def scene(self) -> list[str]:
        """Of each result, how high and how bouncy, in one sentence."""
        return [describe_scene(*each) for each in zip(
            self.restitution.tolist(), self.drop_height.tolist(), strict=True)]

    @property
    def scenes(self) -> list[str]:
        """Different scenes, in the order of first appearance; methods blind to them have none."""
        return list(dict.fromkeys(one.scene for one in self.predictions
                                  if not math.isnan(one.drop_height)))

    @property
    def foretold(self) -> tuple[Prediction, ...]:
        """Those that have not learnt from counts, so that counts can judge them."""
        return tuple(one for one in self.predictions if one.method != OBSERVED)

    @property
    def leading(self) -> Prediction:
        """The prediction to go by: the largest simulation, else the newest estimate."""
        best, *others = self.foretold or self.predictions
        for one in others:
            if one.knows_more_than(best):
                best = one
        return best
