"""What cameras counted, added up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .copies import Copies, fingerprint
from .decoding import field

Index = NDArray[np.int64]
MOST = 1 << 48
"""Parts that no camera counts; a number beyond it is damage."""


@dataclass(frozen=True, eq=False)
class CameraCounts:
    """All counts of one part, numbering and plate together.

    Each message counts what came since the one before.

    Attributes
    ----------
    part_id, part_digest : str
        The digest is empty where the camera did not know it.
    cluster_tolerance : float
        With which the camera numbered the poses, as a fraction of the radius; negative where
        it did not say.
    plate : str
    drop_height : float
        Metres; NaN where the camera did not know it.
    messages : int
    begin, end : int
        Time of the first and the last message, nanoseconds since 1970.
    index, count : (k,) arrays of int
        Poses, rising, and the parts seen in each.
    unclassified : int
        Parts seen in no stable pose.
    """

    part_id: str
    part_digest: str
    cluster_tolerance: float
    plate: str
    drop_height: float
    messages: int
    begin: int
    end: int
    index: Index
    count: Index
    unclassified: int

    @property
    def classified(self) -> int:
        """Parts seen in a stable pose."""
        return int(self.count.sum())

    @property
    def unclassified_share(self) -> float:
        """Fraction of all parts seen; NaN where none was."""
        total = self.classified + self.unclassified
        return self.unclassified / total if total else math.nan


@dataclass
class _About:
    """What messages add up to beside the poses."""

    begin: int
    end: int
    messages: int = 0
    unclassified: int = 0


class CountCollector:
    """Adds up PoseCounts messages, each once.

    Attributes
    ----------
    refused : int
        Messages whose arrays were not of one length.
    """

    def __init__(self) -> None:
        self.copies = Copies()
        self.refused = 0
        self._sums: dict[tuple[Any, ...], dict[int, int]] = {}
        self._about: dict[tuple[Any, ...], _About] = {}

    def add(self, message: Any, source: int, stamp: int, log_time: int) -> None:
        """Take in a PoseCounts; see `Copies.is_copy`."""
        index, count = list(field(message, "index", ())), list(field(message, "count", ()))
        if len(index) != len(count):
            self.refused += 1
            return
        unclassified = int(field(message, "unclassified", 0))
        if max(count, default=0) > MOST or unclassified > MOST:
            raise OverflowError(f"more than {MOST} parts")
        of = _what_was_counted(message)
        if self.copies.is_copy(fingerprint(of, index, count, unclassified), source, stamp,
                               log_time):
            return
        time = stamp or log_time
        sums = self._sums.setdefault(of, {})
        for pose, parts in zip(index, count, strict=True):
            sums[pose] = sums.get(pose, 0) + parts
        about = self._about.setdefault(of, _About(time, time))
        about.messages += 1
        about.begin, about.end = min(about.begin, time), max(about.end, time)
        about.unclassified += unclassified

    def counts(self) -> list[CameraCounts]:
        """Everything so far."""
        return [self._one(of, sums, self._about[of]) for of, sums in self._sums.items()]

    @staticmethod
    def _one(of: tuple[Any, ...], sums: dict[int, int], about: _About) -> CameraCounts:
        part_id, digest, tolerance, plate, height = of
        index = np.array(sorted(sums), dtype=np.int64)
        count = np.array([sums[pose] for pose in index.tolist()], dtype=np.int64)
        return CameraCounts(part_id, digest, tolerance, plate,
                            math.nan if height is None else height, about.messages,
                            about.begin, about.end, index, count, about.unclassified)


def _what_was_counted(message: Any) -> tuple[Any, ...]:
    height = float(field(message, "drop_height", -1.0))
    return (str(field(message, "part_id", "")), str(field(message, "part_digest", "")),
            round(float(field(message, "cluster_tolerance", -1.0)), 12),
            str(field(message, "plate", "")),
            round(height, 9) if math.isfinite(height) and height >= 0.0 else None)
