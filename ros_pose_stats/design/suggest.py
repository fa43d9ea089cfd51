"""A combination of changes, within bounds, that raises the share of wanted poses.

The estimator chooses, and drops that had no say tell what was gained. What is judged is the outer
shape and the centre of mass, not whether the part can be made.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..records import Array, DropScene, Mask, Part, scene as scenes
from ..simulation.request import drop_request
from ..statistics import errors, feeding, paired_counts
from ..version import VERSION
from . import changes, effects
from .climb import MOST_STEPS, Climb, center_move, check_within, outline_move
from .shares import WantedShare

GAIN_DROPS = 4000
GAIN_SECONDS = 5.0
"""Drops that tell the gain, and the time after which no more are begun."""


@dataclass(frozen=True, eq=False)
class Suggestion:
    """A change of a part that raises the share of its wanted poses."""

    space: changes.DesignSpace
    wanted: tuple[int, ...]
    scene: DropScene  # with the drop height in metres
    within: float  # bound of what is moved, metres
    steps: Array  # (n,); of each feature, metres or a fraction; all 0 where nothing was found
    # features that were changed, those tied together in one, the one that gains most first
    taken: tuple[tuple[int, ...], ...]
    changed: changes.ChangedPart  # the part after
    outline: float  # how far its outline and its centre of mass moved, metres
    center_shift: float
    before: float  # estimated shares
    after: float
    gain_error: float  # standard error of the estimated gain
    lost: tuple[int, ...]  # wanted poses that are gone
    # by drops, from the same starts, none of which chose the change
    gain: paired_counts.PairedDifference
    dropped_before: feeding.Bounded  # shares by these drops
    dropped_after: feeding.Bounded
    drops: int
    seed: int
    most_drops: int  # that were asked for
    out_of_time: bool  # whether time ended the drops before that
    seconds: float
    version: str = VERSION


def suggest(part: Part, wanted: Sequence[int], within: float, *, drops: int | None = None,
            seed: int | None = None, restitution: float = scenes.DEFAULT_RESTITUTION,
            drop_height: float | None = None,
            cluster_tolerance: float = scenes.DEFAULT_CLUSTER_TOLERANCE,
            round_sides: int = scenes.DEFAULT_ROUND_SIDES, workers: int | None = None,
            on_progress: Callable[[float], object] | None = None,
            should_stop: Callable[[], bool] | None = None) -> Suggestion:
    """Combine changes of a part, within bounds, so that it comes to rest as wanted more often.

    Parameters
    ----------
    part : Part
    wanted : sequence of int
        Indices of the accepted poses.
    within : float
        How far the outline, and the centre of mass, may move, metres. A symmetric part stays as
        symmetric as it is.
    drops : int, optional
        Of the part before and after. Default: 4 000, and no more are begun after five seconds.
    seed, restitution, drop_height, cluster_tolerance, round_sides, workers
        As for `simulate`.
    on_progress : callable, optional
        Takes the share done, 0 to 1.
    should_stop : callable, optional
        After True the best change by then is returned.

    Raises
    ------
    RequestError
        If a value is out of its range or there is no such pose.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    asked = drop_request(GAIN_DROPS if drops is None else drops, seed, 0.0, workers, None)
    space = changes.DesignSpace(part, cluster_tolerance, round_sides)
    model = WantedShare(space, wanted, scene)
    check_within(within, space.body.radius)
    stop = should_stop or (lambda: False)
    progress = on_progress or (lambda done: None)
    climb = Climb(space, model, within)
    climb.climb(lambda taken: progress(0.5 * taken / MOST_STEPS), stop)
    after = space.change(climb.steps)
    parts = [space.change_one(0, 0.0), after]
    done = effects.drop_changed(parts, model, asked, GAIN_SECONDS if drops is None else None,
                                lambda share: progress(0.5 + 0.5 * share), stop)
    pairs = done.pairs
    shares = [_share(pairs.is_in(place, np.flatnonzero(
        model.accepted(resting, one.origin)).tolist()))
        for place, (resting, one) in enumerate(zip(pairs.resting, parts, strict=True))]
    gained = climb.share - climb.base
    return Suggestion(
        space, tuple(np.flatnonzero(model.kept).tolist()), model.scene, within, climb.steps,
        climb.taken, after, outline_move(space, after), center_move(space, after),
        climb.base, climb.share, effects.effect_error(gained, 0.0), model.lost(after),
        done.differences[0], shares[0], shares[1], pairs.drops, asked.seed, asked.drops,
        done.out_of_time, time.perf_counter() - begin)


def _share(is_in: Mask) -> feeding.Bounded:
    count, total = int(is_in.sum()), is_in.size
    low, high = errors.jeffreys_interval(count, total)
    return feeding.Bounded(count / total if total else float("nan"), float(low), float(high))
