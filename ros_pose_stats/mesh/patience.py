"""How long a check may take where somebody has a better place for what takes longer."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

_of_thread = threading.local()


class TakesLongError(Exception):
    """The time is over; nothing is known of the mesh yet."""


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Have `check_patience` raise in this thread once so many seconds have passed."""
    _of_thread.until = time.monotonic() + seconds
    try:
        yield
    finally:
        _of_thread.until = math.inf


def check_patience() -> None:
    """Go on only while there is time.

    Raises TakesLongError.
    """
    if time.monotonic() > getattr(_of_thread, "until", math.inf):
        raise TakesLongError
