"""On PYTHONPATH, gives a process a clock that is wrong by the seconds in the file
TRIAL_CLOCK.
"""

import datetime
import os
import threading
import time
from pathlib import Path

FILE = Path(os.environ["TRIAL_CLOCK"])
GLANCE = 0.1
_time_ns = time.time_ns
_shift = int(1e9 * float(FILE.read_text("utf-8")))


def _shifted():
    return _time_ns() + _shift


def _follow():
    global _shift
    while True:
        _shift = int(1e9 * float(FILE.read_text("utf-8") or 0.0))
        time.sleep(GLANCE)


class ShiftedDatetime(datetime.datetime):
    """A date that follows the wrong clock."""

    @classmethod
    def now(cls, tz=None):
        """What the wrong clock shows."""
        return datetime.datetime.fromtimestamp(_shifted() / 1e9, tz)


time.time_ns = _shifted
datetime.datetime = ShiftedDatetime
threading.Thread(target=_follow, daemon=True).start()
