"""Which bags the node begins with."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..recording.raw_reader import newest_run
from .settings import Settings


def bags_to_restore(settings: Settings, repaired: Sequence[Path]) -> list[Path]:
    """Bags that were just mended, for their unfinished jobs, and the newest one, which is last."""
    newest = newest_run(settings.directory()) if settings.directory().is_dir() else None
    bags = sorted(set(repaired) | ({newest} if newest is not None else set()))
    return [bag for bag in bags if newest is None or bag <= newest]
