"""How far a run of drops is."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from .statistics import PoseStatistics


@dataclass(frozen=True, eq=False)
class DropProgress:
    """State of a run of drops, as told to `on_progress`.

    Attributes
    ----------
    drops : int
        Length of the contiguous prefix that is done.
    bound : int
        Drops asked for.
    unsettled : int
        Of those done.
    expected_error : float
        As it is now, a fraction; NaN before anything has settled.
    target_error : float
        0 where all drops are wanted.
    seconds : float
        Since the run began.
    statistics : callable
        Makes the `PoseStatistics` so far.
    """

    drops: int
    bound: int
    unsettled: int
    expected_error: float
    target_error: float
    seconds: float
    statistics: Callable[[], PoseStatistics]

    @property
    def rate(self) -> float:
        """Drops a second; NaN before the first."""
        return self.drops / self.seconds if self.drops and self.seconds > 0.0 else math.nan

    @property
    def seconds_left(self) -> float:
        """Expected, taking into account that the error falls with the root of the drops."""
        wanted = float(self.bound)
        if self.target_error > 0.0 and math.isfinite(self.expected_error):
            more = (self.expected_error / self.target_error) ** 2
            wanted = min(wanted, self.drops * more)
        return max(0.0, wanted - self.drops) / self.rate if self.drops else math.nan
