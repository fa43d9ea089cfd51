"""The node under a clock that somebody else sets: `python -m tests.soak.node.shifted_clock`.

The first argument is a file with the seconds by which the clock is wrong.
"""

from __future__ import annotations

import datetime as dates
import sys
import threading
import time
from pathlib import Path
from typing import Any

GLANCE = 0.1
_time_ns = time.time_ns
_shift = 0


def shifted() -> int:
    """Nanoseconds since the epoch, as the wrong clock has them."""
    return _time_ns() + _shift


class ShiftedDatetime(dates.datetime):
    """A date that follows the wrong clock."""

    @classmethod
    def now(cls, tz: Any = None) -> Any:
        """What the wrong clock shows."""
        return dates.datetime.fromtimestamp(shifted() / 1e9, tz)


def _read(file: Path) -> None:
    global _shift
    _shift = int(1e9 * float(file.read_text() or 0.0))


def _follow(file: Path) -> None:
    while True:
        _read(file)
        time.sleep(GLANCE)


def main() -> int:
    """Run the node."""
    file = Path(sys.argv.pop(1))
    _read(file)
    time.time_ns = shifted
    dates.datetime = ShiftedDatetime  # type: ignore[misc]
    threading.Thread(target=_follow, args=(file,), daemon=True).start()
    from ros_pose_stats.commands.node import main as run

    return run()


if __name__ == "__main__":
    raise SystemExit(main())
