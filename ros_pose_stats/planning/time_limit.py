"""An end to drops after some time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from ..errors import RequestError


class TimeLimit:
    """Ends a run late or when the caller says so, and knows which.

    Parameters
    ----------
    seconds : float
        0 or above; 0 for no limit.
    begin : float
        `time.perf_counter()` at the start.
    should_stop : callable, optional
        The caller's own wish.

    Raises
    ------
    RequestError
        If the seconds are not such a number.
    """

    def __init__(self, seconds: float, begin: float,
                 should_stop: Callable[[], bool] | None) -> None:
        number = isinstance(seconds, (int, float)) and not isinstance(seconds, bool)
        if not number or not 0.0 <= seconds < math.inf:
            raise RequestError("max_seconds from 0 up", f"{seconds!r}", "0 sets no limit")
        self._seconds = seconds
        self._until = begin + seconds if seconds else math.inf
        self._should_stop = should_stop
        self._late = False

    def over(self) -> bool:
        """Whether to stop now."""
        if self._should_stop is not None and self._should_stop():
            return True
        self._late = time.perf_counter() >= self._until
        return self._late

    def warnings(self, drops: int) -> list[str]:
        """One where the time ran out."""
        if not self._late:
            return []
        return [f"TIME_LIMIT: ended after {self._seconds:g} s with {drops} drops done, before "
                f"the target was reached."]
