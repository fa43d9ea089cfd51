"""What the records of single drops add up to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .decoding import field


@dataclass
class DropLog:
    """Drops of one part that were recorded one by one.

    Attributes
    ----------
    drops, unsettled : int
    impacts : int
        Of all these drops together.
    seconds : float
        From release to the end, of all these drops together.
    """

    drops: int = 0
    unsettled: int = 0
    impacts: int = 0
    seconds: float = 0.0


class DropCollector:
    """Gathers drop records by the digest of their part."""

    def __init__(self) -> None:
        self.logs: dict[str, DropLog] = {}
        self._seen: set[tuple[str, int, int]] = set()

    def add(self, records: Any) -> None:
        """Take in a DropRecords, unless another bag held the same drops of the same job."""
        poses = np.asarray(field(records, "pose_index", ()), dtype=np.int64)
        piece = (str(field(records, "job_id", "")), int(field(records, "first_drop", 0)),
                 poses.size)
        if piece in self._seen:
            return
        self._seen.add(piece)
        log = self.logs.setdefault(str(field(records, "part_digest", "")), DropLog())
        log.drops += poses.size
        log.unsettled += int(np.count_nonzero(poses < 0))
        log.impacts += int(np.sum(field(records, "impacts", ()), dtype=np.int64))
        log.seconds += float(np.sum(field(records, "seconds", ()), dtype=np.float64))
