"""What resting probabilities mean for a feeder that keeps some poses and sends back the rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import RequestError
from ..records import PoseStatistics
from ..statistics.intervals import jeffreys_interval


@dataclass(frozen=True)
class Feeding:
    """A feeder that accepts some poses.

    Each part that is sent back is taken as dropped afresh: its next pose does not depend on
    the last one, so that the number of passes is geometric with the mean 1 / p.

    Attributes
    ----------
    wanted : tuple of int
        `index` of the accepted poses.
    share, low, high : float
        Probability p that a drop ends in one of them, with its 90 % interval.
    rate : float
        Parts dropped a minute, those sent back included; NaN where none was given.
    """

    wanted: tuple[int, ...]
    share: float
    low: float
    high: float
    rate: float = math.nan

    @property
    def accepted(self) -> tuple[float, float, float]:
        """Accepted parts a minute, and the bounds of the 90 % interval."""
        return self.rate * self.share, self.rate * self.low, self.rate * self.high

    @property
    def passes(self) -> tuple[float, float, float]:
        """Passes per accepted part, 1 / p, and its 90 % bounds; infinite where p may be 0."""
        return _inverse(self.share), _inverse(self.high), _inverse(self.low)


def feeding(simulated: PoseStatistics, wanted: Sequence[int], rate: float | None = None
            ) -> Feeding:
    """Ask a simulation how often one of some poses comes up.

    Parameters
    ----------
    simulated : PoseStatistics
        With counts.
    wanted : sequence of int
        `index` of the accepted poses, at least one.
    rate : float, optional
        Parts dropped a minute, above 0.

    Returns
    -------
    Feeding
        The counts of the poses are added before the interval is taken.

    Raises
    ------
    RequestError
        If there is no such pose, or the rate is not above 0.
    """
    refuse_unknown(wanted, len(simulated.poses), rate)
    there = {pose.index: pose.count for pose in simulated.poses}
    chosen = tuple(dict.fromkeys(int(index) for index in wanted))
    settled, count = sum(there.values()), sum(there[index] for index in chosen)
    low, high = jeffreys_interval(count, settled)
    return Feeding(chosen, count / settled if settled else math.nan, float(low), float(high),
                   math.nan if rate is None else float(rate))


def refuse_unknown(wanted: Sequence[int], poses: int, rate: float | None) -> None:
    """Check what a feeder is asked, before anything is dropped.

    Raises
    ------
    RequestError
        If there is no such pose, or the rate is not above 0.
    """
    unknown = [index for index in wanted if not 0 <= index < poses]
    if unknown or not len(wanted):
        raise RequestError(f"poses from 0 to {poses - 1}", ", ".join(map(str, unknown)) or "none",
                           "`ros_pose_stats estimate` lists the poses of a part")
    if rate is not None and not 0.0 < rate < math.inf:
        raise RequestError("a rate above 0 parts a minute", f"{rate}",
                           "count the parts that are dropped, those sent back included")


def _inverse(share: float) -> float:
    return 1.0 / share if share > 0.0 else math.inf
