"""When a run is looked at, and when it has dropped enough.

Looking at fixed prefixes only makes the answer independent of workers, chunks and timing:
whatever has been computed beyond a prefix by then has no say in whether it was enough.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

FIRST_CHECKPOINT: Final = 100
"""Drops before the first look; fewer say little about their own error."""

LEAST_STEPS: Final = (8, 0.1)
"""A look costs as much as a dozen drops: the next one is at least so many drops away, and such a
share of those done."""

AHEAD: Final = 1.1
"""Drops over those in which the target is reached by the root law: an error that an estimate has
its share in falls slower."""


def next_checkpoint(done: int, drops: int, first: int = FIRST_CHECKPOINT) -> int:
    """The first prefix longer than `done` that is looked at.

    The prefixes are 100, 150, 225, 337, 505, 757, ..., each one and a half times the one
    before, rounded down; and the bound.

    Parameters
    ----------
    done : int
        Length of the prefix behind, 0 <= done.
    drops : int
        The bound of the run, 1 <= drops.
    first : int
        The shortest prefix, 2 <= first.

    Returns
    -------
    int
        At most `drops`; `drops` itself once `done` has reached it.
    """
    checkpoint = first
    while checkpoint <= done:
        checkpoint = checkpoint * 3 // 2
    return min(checkpoint, drops)


def sooner_checkpoint(done: int, error: float, target_error: float) -> float:
    """The prefix in which the target may be reached, seen from one that has this error.

    The error falls at most as the root of the number of drops, so this is a little beyond.

    Parameters
    ----------
    done : int
        Length of the prefix that was looked at, 1 <= done.
    error : float
        There, above the target.
    target_error : float
        As a fraction, above 0.

    Returns
    -------
    float
        A whole number above `done`; infinite where the error says nothing.
    """
    if not math.isfinite(error):
        return math.inf
    drops, share = LEAST_STEPS
    wanted = max(1.0 + share, AHEAD * (error / target_error) ** 2)
    return max(done + drops, math.ceil(done * wanted))


def checkpoints(drops: int) -> Iterator[int]:
    """All prefixes at which a run of at most `drops` drops (>= 1) is looked at, rising.

    The last one is `drops`.
    """
    done = 0
    while done < drops:
        done = next_checkpoint(done, drops)
        yield done


def target_reached(expected_error: float, target_error: float) -> bool:
    """Whether a run stops at the checkpoint where it has this expected error.

    Parameters
    ----------
    expected_error : float
        Of the prefix, as a fraction; NaN (nothing settled yet) never stops a run.
    target_error : float
        As a fraction, 0 <= target_error; 0 asks for all drops.
    """
    return target_error > 0.0 and expected_error <= target_error
