"""By what the poses of a part are numbered."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .decoding import read_field


class Numbering(NamedTuple):
    """With equal ones, and an equal digest, the same index is the same pose."""

    # share of the centre of mass's height, as rounded by `numbering_of`; NaN where it is not known
    cluster_tolerance: float
    round_sides: int  # 0: round surfaces as the file has them

    def __str__(self) -> str:
        """For people."""
        tolerance = self.cluster_tolerance
        told = "unknown" if math.isnan(tolerance) else f"{tolerance:.12g}"
        return f"cluster_tolerance {told} and round_sides {self.round_sides}"

    def agrees(self, other: Numbering) -> bool:
        """Whether both are known and equal."""
        return self == other and not math.isnan(self.cluster_tolerance)


def numbering_of(message: Any) -> Numbering:
    """What a PoseStatistics or PoseCounts says; older ones took round surfaces as they are.

    The tolerance is rounded to 12 digits, for senders that put it through a text.
    """
    tolerance = float(f"{float(read_field(message, 'cluster_tolerance', math.nan)):.12g}")
    # One object for all that are not known: a NaN as a key equals itself alone.
    return Numbering(tolerance if math.isfinite(tolerance) else math.nan,
                     int(read_field(message, "round_sides", 0)))
