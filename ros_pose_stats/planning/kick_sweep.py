"""The kick that feeds fastest: flips at several kick heights."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from ..records import DropScene, FlipStatistics, Part, PoseStatistics
from ..simulation.flips import check_kick, count_flips, usual_kicks
from ..simulation.request import Watch, drop_request
from ..statistics.feeding import Feeding, drop_afresh, flip_wrong_ones
from ..statistics.pose_shares import pose_shares

SWEEP_FLIPS = 500
"""Flips a pose and kick: enough to see where the fastest one lies."""


class KickFeeding(NamedTuple):
    """What one kick height makes of a feeder."""

    kick_height: float  # metres
    flips: FlipStatistics
    feeding: Feeding


class KickSweep(NamedTuple):
    """What a feeder gets at several kick heights."""

    wanted: tuple[int, ...]  # indices of the poses that are accepted
    rate: float  # parts dropped a minute
    cycle_time: float  # seconds from one kick to the next
    afresh: Feeding  # without kicks: parts that lie wrong are dropped again
    # by rising kick height; those that were complete when the sweep was stopped
    kicks: tuple[KickFeeding, ...]

    @property
    def best(self) -> KickFeeding:
        """The kick with the most accepted parts a minute, of equal ones the lowest.

        There must be one.
        """
        return max(self.kicks, key=lambda one: one.feeding.per_minute.value)

    @property
    def near_best(self) -> tuple[KickFeeding, ...]:
        """The kicks within the error of the best one, itself included."""
        least = self.best.feeding.per_minute.low
        return tuple(one for one in self.kicks if one.feeding.per_minute.value >= least)


def sweep_kicks(part: Part, dropped: PoseStatistics, wanted: Sequence[int], rate: float,
                cycle_time: float, kicks: Sequence[float] | None = None,
                drops: int = SWEEP_FLIPS, seed: int | None = None, workers: int | None = None,
                on_progress: Callable[[int, int], object] | None = None,
                should_stop: Callable[[], bool] | None = None) -> KickSweep:
    """Flip a part with kicks of several heights, and see what a feeder gets.

    All kicks have the same seed, so that they hit the part at the same points, and what is left
    of their difference is less a matter of chance.

    `dropped`: of this part, by any method; the kicks are in its scene; `kicks`: heights, metres;
    default: from a twentieth of the part's radius to five of them; `drops`: flips out of each pose
    at each height; `on_progress`: takes the number of flips done, and of all; `should_stop`: after
    True the sweep ends with the kicks that are complete by then, if any. Raises RequestError if a
    value is out of its range.
    """
    shares = pose_shares(dropped)
    afresh = drop_afresh(shares, wanted, rate)
    scene = DropScene(dropped.restitution, None, dropped.cluster_tolerance, dropped.round_sides)
    heights = sorted({check_kick(one) for one in kicks or usual_kicks(dropped.radius)})
    request, watch = drop_request(drops, seed, 0.0, workers), Watch.of(None, should_stop)
    each = drops * len(dropped.poses)
    found: list[KickFeeding] = []
    for place, height in enumerate(heights):
        def tell(done: int, _: int, before: int = place * each) -> None:
            if on_progress is not None:
                on_progress(before + done, each * len(heights))

        flips = count_flips(part, scene, height, request, watch, tell)
        if flips.flips < each:
            break
        found.append(KickFeeding(height, flips, flip_wrong_ones(
            shares, flips.counts, wanted, rate, cycle_time)))
    return KickSweep(tuple(dict.fromkeys(map(int, wanted))), rate, cycle_time, afresh,
                     tuple(found))
