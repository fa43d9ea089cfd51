"""Time that methods take for a part, on one core."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Mapping, Sequence
from statistics import median
from typing import TypeVar

Call = Callable[[], object]
Result = TypeVar("Result")


def medians(parts: Sequence[Mapping[str, Call]], times: int = 1) -> dict[str, float]:
    """Seconds of each method: the median over parts of the median of a few calls.

    Parameters
    ----------
    parts : sequence of mappings
        For each part, from a method's name to a call of it; the same names everywhere.
    times : int
        Calls of each method for a part, all methods taking turns.
    """
    gc.collect()
    for call in parts[0].values():  # whatever is done once only
        call()
    found: dict[str, list[float]] = {name: [] for name in parts[0]}
    for calls in parts:
        turns = [{name: _once(call) for name, call in calls.items()} for _ in range(times)]
        for name, seconds in found.items():
            seconds.append(median(turn[name] for turn in turns))
    return {name: median(seconds) for name, seconds in found.items()}


def timed(call: Callable[[], Result]) -> tuple[float, Result]:
    """Seconds of a call, the garbage collector held off as in `timeit`, and its result."""
    held = gc.isenabled()
    gc.disable()
    try:
        begin = time.perf_counter()
        result = call()
        return time.perf_counter() - begin, result
    finally:
        if held:
            gc.enable()


def _once(call: Call) -> float:
    return timed(call)[0]  # freeing the result is not timed
