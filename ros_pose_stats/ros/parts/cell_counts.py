"""What cameras counted of one part on one plate since it was first seen there."""

import threading
from collections import deque
from collections.abc import Mapping
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from ros_pose_stats_msgs.msg import PoseCounts

from ...records import Part
from ...records.scene import Numbering
from ...resting.poses import resting_poses
from ...statistics.chi_square import homogeneity
from ...text import percent
from ..messages.part_requests import shown
from ..refusals import Health

Index = NDArray[np.int64]

RECENT: Final = 400
"""Parts that are compared with all those before."""

CHANCE: Final = 1e-4
"""Below it, a change is more than chance: a cell that does not change alarms once in some
hundred thousand parts."""


class HasPart(Protocol):
    """What gives a part when it is asked for."""

    @property
    def part(self) -> Part:
        """The part itself."""


class Ground(NamedTuple):
    """What counts must have in common to be added: numbers of the poses, and the plate."""

    numbering: Numbering
    plate: str

    def goes_on_as(self, other: "Ground", known: HasPart) -> bool:
        """Whether only `round_sides` is new, and the poses of the part keep their numbers.

        A plate that was fitted may bring sides of its own; what it was fitted to still counts.
        """
        tolerance, sides = self.numbering
        new = other.numbering.round_sides
        return (other == Ground(Numbering(tolerance, new), self.plate)
                and resting_poses(known.part, tolerance, sides).is_numbered_like(
                    resting_poses(known.part, tolerance, new)))


class CellCounts:
    """Counts of a part's poses, and whether the last ones differ from those before."""

    def __init__(self, ground: Ground, total: Index, series: int) -> None:
        self.ground = ground
        self.series = series
        self._total = total.copy()
        self._recent: deque[Index] = deque()
        self._seen = 0
        self._drift: str | None = None
        self._lock = threading.Lock()

    @property
    def total(self) -> Index:
        """Parts (P,) seen in each pose, by `index`."""
        with self._lock:
            return self._total.copy()

    def add(self, counts: PoseCounts) -> int:
        """Add what a camera counted, of poses that the part has; how many parts that is."""
        new = np.zeros_like(self._total)
        for index, count in zip(counts.index, counts.count, strict=True):
            new[index] += count
        seen = int(new.sum())
        if not seen:
            return 0
        with self._lock:
            self._total += new
            self._drift = None
            self._recent.append(new)
            self._seen += seen
            while self._seen - int(self._recent[0].sum()) >= RECENT:
                self._seen -= int(self._recent.popleft().sum())
        return seen

    def drift(self) -> str:
        """How the last parts differ from those before beyond chance; empty if they do not."""
        with self._lock:
            if self._drift is None:
                recent = np.sum(self._recent, axis=0) if self._recent else 0 * self._total
                self._drift = _describe_drift(recent, self._total - recent)
            return self._drift


def _describe_drift(recent: Index, before: Index) -> str:
    if min(recent.sum(), before.sum()) < RECENT:
        return ""
    found = homogeneity(before, recent)
    if not found.p_value < CHANCE:
        return ""
    now, then = recent / recent.sum(), before / before.sum()
    most = int(np.abs(now - then).argmax())
    return (f"of the last {recent.sum()} parts {percent(now[most])} % lie in pose {most}, of the "
            f"{before.sum()} before {percent(then[most])} % did")


def count_health(parts: Mapping[str, CellCounts | None]) -> Health:
    """The line of diagnostics about what cameras counted, and what has changed in it."""
    counted = {part_id: counts for part_id, counts in parts.items() if counts is not None}
    changed = {f"changed {shown(part_id)}": drift for part_id, counts in counted.items()
               if (drift := counts.drift())}
    total = sum(int(counts.total.sum()) for counts in counted.values())
    text = next((f"{name}: {drift}" for name, drift in changed.items()),
                f"{total} parts counted of {len(counted)} kinds")
    return Health(bool(changed), text, {"kinds counted": len(counted), "parts counted": total,
                                        **changed})
