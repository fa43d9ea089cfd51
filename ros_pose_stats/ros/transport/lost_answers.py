"""Notices answers that rclpy throws away, of which it tells by a warning only."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

UNDELIVERED = "failed to send response"
"""How the warning begins."""

# `showwarning` would be the public place, but is put back for the whole process whenever any
# thread catches warnings, as numba does while it compiles.
_machinery: Any = warnings
_of_thread = threading.local()
_show_others = _machinery._showwarnmsg


def _show(warning: warnings.WarningMessage) -> None:
    lost: list[str] | None = getattr(_of_thread, "lost", None)
    if lost is not None and str(warning.message).startswith(UNDELIVERED):
        lost.append(str(warning.message))
    else:
        _show_others(warning)


def catch_losses() -> None:
    """Have `losses` catch what would otherwise be shown on standard error, once a line."""
    global _show_others
    if _machinery._showwarnmsg is not _show:
        _show_others, _machinery._showwarnmsg = _machinery._showwarnmsg, _show
    warnings.filterwarnings("always", message=UNDELIVERED, category=RuntimeWarning)


@contextmanager
def losses() -> Iterator[list[str]]:
    """What rclpy says of answers that this thread sends meanwhile and that are thrown away."""
    catch_losses()  # another thread that catches warnings may have taken the filter away
    outer = getattr(_of_thread, "lost", None)
    lost: list[str] = []
    _of_thread.lost = lost
    try:
        yield lost
    finally:
        _of_thread.lost = outer
