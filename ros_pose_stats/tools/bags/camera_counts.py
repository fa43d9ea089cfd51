"""What cameras counted, added up, each message once however often it was recorded."""

import math
from bisect import bisect_left, bisect_right, insort
from collections import Counter
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any

import numpy as np

from ...core.records import Index
from ...core.records.scene import Numbering
from ...node.recording.decoding import fingerprint, numbering_of

MOST = 1 << 48  # parts that no camera counts; a number beyond it is damage

WITHIN = 1_000_000_000
"""Two recorders write down a message without a stamp at most this far apart [ns]."""


@dataclass(eq=False)
class CameraCounts:
    """All counts of one part, numbering and plate together."""

    part_id: str  # the digest is empty where the camera did not know it
    part_digest: str
    numbering: Numbering  # by which the camera names the poses
    plate: str
    drop_height: float  # metres; NaN where the camera did not know it
    begin: int  # time of the first and the last message, nanoseconds since 1970
    end: int
    messages: int = 0
    unclassified: int = 0  # parts seen in no stable pose
    of_pose: Counter[int] = field(default_factory=Counter)

    @property
    def index(self) -> Index:
        """Poses (k,) that were counted, rising."""
        return np.array(sorted(self.of_pose), dtype=np.int64)

    @property
    def count(self) -> Index:
        """Parts (k,) seen in each of them."""
        return np.array(
            [self.of_pose[pose] for pose in sorted(self.of_pose)], dtype=np.int64
        )

    @property
    def classified(self) -> int:
        """Parts seen in a stable pose."""
        return self.of_pose.total()

    @property
    def unclassified_share(self) -> float:
        """Fraction of all parts seen; NaN where none was."""
        total = self.classified + self.unclassified
        return self.unclassified / total if total else math.nan


class CountCollector:
    """Adds up PoseCounts of landings, each once; refused are those with arrays of two lengths."""

    def __init__(self) -> None:
        self.copies = Copies()
        self.refused = self.flips = 0
        self.counts: dict[tuple[Any, ...], CameraCounts] = {}

    def add(self, message: Any, source: int, stamp: int, log_time: int) -> None:
        """Take in a PoseCounts; see `Copies.is_copy`."""
        index, count = (list(getattr(message, name, ())) for name in ("index", "count"))
        if len(index) != len(count):
            self.refused += 1
            return
        if int(getattr(message, "from_pose", -1)) >= 0:
            self.flips += 1  # no landings
            return
        unclassified = int(getattr(message, "unclassified", 0))
        if max(count, default=0) > MOST or unclassified > MOST:
            raise OverflowError(f"more than {MOST} parts")
        height = float(getattr(message, "drop_height", -1.0))
        of = (
            str(getattr(message, "part_id", "")),
            str(getattr(message, "part_digest", "")),
            numbering_of(message),
            str(getattr(message, "plate", "")),
            height if math.isfinite(height) and height >= 0.0 else None,
        )
        if self.copies.is_copy(
            fingerprint(of, index, count, unclassified), source, stamp, log_time
        ):
            return
        time = stamp or log_time
        known = self.counts.setdefault(
            of, CameraCounts(*of[:4], math.nan if of[4] is None else height, time, time)
        )
        known.begin, known.end = min(known.begin, time), max(known.end, time)
        known.messages += 1
        known.unclassified += unclassified
        for pose, parts in zip(index, count, strict=True):
            known.of_pose[pose] += parts


class Copies:
    """Tells copies apart from messages that merely say the same.

    Within one recording every message counts: two parts may land alike in one picture. One of
    another recording is a copy if an equal one at the same time has no partner there yet.
    """

    def __init__(self) -> None:
        # by content: when it was seen and in which recordings, by time
        self._seen: dict[bytes, list[tuple[int, set[int]]]] = {}
        self.found = 0
        self.unstamped = 0

    def is_copy(self, content: bytes, source: int, stamp: int, log_time: int) -> bool:
        """Whether another recording had it; without a stamp its time of recording decides."""
        self.unstamped += not stamp
        time, window = (stamp, 0) if stamp else (log_time, WITHIN)
        known = self._seen.setdefault(content, [])
        first = bisect_left(known, time - window, key=itemgetter(0))
        for _, sources in known[
            first : bisect_right(known, time + window, key=itemgetter(0))
        ]:
            if source not in sources:
                sources.add(source)
                self.found += 1
                return True
        insort(known, (time, {source}), key=itemgetter(0))
        return False
