"""Changes checked by drops of the part before and after, from the same starts."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from ..simulation.request import DropRequest
from ..statistics.paired_counts import PairedDifference
from .changes import ChangedPart
from .effects import Effect
from .paired_drops import PairedDrops, begin_pairs, drop_more
from .shares import WantedShare

LOOKS: Final = (62, 125, 250, 500, 1000, 2000, 4000)
"""Drops after which the clock is looked at."""

FEW, PATIENCE = 250, 4.0
"""Drops until which so many times the time is granted."""


class CheckDrops(NamedTuple):
    """Drops of a part and of what was made of it."""

    pairs: PairedDrops
    # of the share of the wanted poses, from the first part to each of the others
    differences: list[PairedDifference]
    out_of_time: bool  # whether time ended them before the drops that were asked for


def drop_changed(changed: Sequence[ChangedPart], model: WantedShare, asked: DropRequest,
                 seconds: float | None, on_progress: Callable[[float], object],
                 should_stop: Callable[[], bool]) -> CheckDrops:
    """Drop a part and what was made of it from the same starts.

    What comes out has no say in when it ends: intervals would be too narrow, and changes too
    large.

    `changed`: the part as it is first; `seconds`: after which no more drops are begun, of few four
    times that; None for no bound; `on_progress`: takes the share done.
    """
    parts, begin, late = [one.part for one in changed], time.perf_counter(), False
    pairs = begin_pairs(parts, model.scene, asked.seed)
    for wanted in sorted({min(one, asked.drops) for one in (*LOOKS, asked.drops)}):
        pairs = drop_more(pairs, parts, wanted, workers=asked.workers, should_stop=should_stop)
        on_progress(wanted / asked.drops)
        # The next look takes as long again as all before. Few drops say little.
        patience = PATIENCE if pairs.drops < FEW else 1.0
        late = seconds is not None and (
            2.0 * (time.perf_counter() - begin) > patience * seconds)
        if late or should_stop():
            break
    return CheckDrops(pairs, compare_with_first(pairs, changed, model),
                      late and pairs.drops < asked.drops)


def check_effects(effects: Sequence[Effect], changed: Sequence[ChangedPart], model: WantedShare,
                  asked: DropRequest, seconds: float | None,
                  on_progress: Callable[[float], object], should_stop: Callable[[], bool]
                  ) -> tuple[tuple[Effect, ...], CheckDrops]:
    """Drop the part before and after some changes; see `drop_changed`.

    Returns the same with their checks.
    """
    found = drop_changed(changed, model, asked, seconds, on_progress, should_stop)
    return tuple(replace(effect, check=one)
                 for effect, one in zip(effects, found.differences, strict=True)), found


def compare_with_first(pairs: PairedDrops, changed: Sequence[ChangedPart], model: WantedShare
                       ) -> list[PairedDifference]:
    """Change of the wanted share from the first part to each of the others."""
    accepted = [np.flatnonzero(model.accepted(resting, one.origin)).tolist()
                for resting, one in zip(pairs.resting, changed, strict=True)]
    return [pairs.difference(0, accepted[0], place, accepted[place])
            for place in range(1, len(changed))]
