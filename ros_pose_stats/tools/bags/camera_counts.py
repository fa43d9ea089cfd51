"""What cameras counted, added up, each message once however often it was recorded."""

import math
from bisect import bisect_left, bisect_right, insort
from collections import Counter
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from ...core.records import Index
from ...core.records.scene import Numbering, numbering_of
from ...node.recording.decoding import fingerprint

MOST_PARTS = 1 << 48  # a camera counts no more; a larger number is damage

RECORDING_DELAY = 1_000_000_000
"""Two recorders write a message without a stamp at most this far apart, nanoseconds."""


@dataclass(eq=False)
class CameraCounts:
    """All counts of one part, numbering and plate together."""

    part_id: str
    part_digest: str  # empty where the camera did not know it
    numbering: Numbering  # by which the camera names the poses
    plate: str
    drop_height: float  # metres; NaN where the camera did not know it
    begin: int  # of the first message, nanoseconds since 1970
    end: int  # of the last message
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


class CountKey(NamedTuple):
    """Whose counts are added up together."""

    part_id: str
    part_digest: str
    numbering: Numbering
    plate: str
    drop_height: float | None  # metres; None where the camera did not know it


class CountCollector:
    """Adds up PoseCounts of landings, each once; arrays of two lengths are refused."""

    def __init__(self) -> None:
        self.copies = Copies()
        self.refused = 0
        self.flips = 0
        self.counts: dict[CountKey, CameraCounts] = {}

    def add(self, message: Any, source: int, stamp: int, log_time: int) -> None:
        """Take in a PoseCounts; see `Copies.is_copy`."""
        poses = list(getattr(message, "index", ()))
        parts = list(getattr(message, "count", ()))
        if len(poses) != len(parts):
            self.refused += 1
            return
        if int(getattr(message, "from_pose", -1)) >= 0:
            self.flips += 1  # no landings
            return
        unclassified = int(getattr(message, "unclassified", 0))
        if max(parts, default=0) > MOST_PARTS or unclassified > MOST_PARTS:
            raise OverflowError(f"more than {MOST_PARTS} parts")
        key = _count_key(message)
        content = fingerprint(tuple(key), poses, parts, unclassified)
        if self.copies.is_copy(content, source, stamp, log_time):
            return
        time = stamp or log_time
        if key not in self.counts:
            drop_height = math.nan if key.drop_height is None else key.drop_height
            self.counts[key] = CameraCounts(*key[:4], drop_height, time, time)
        counts = self.counts[key]
        counts.begin = min(counts.begin, time)
        counts.end = max(counts.end, time)
        counts.messages += 1
        counts.unclassified += unclassified
        for pose, count in zip(poses, parts, strict=True):
            counts.of_pose[pose] += count


def _count_key(message: Any) -> CountKey:
    drop_height = float(getattr(message, "drop_height", -1.0))
    is_known = math.isfinite(drop_height) and drop_height >= 0.0
    return CountKey(
        str(getattr(message, "part_id", "")),
        str(getattr(message, "part_digest", "")),
        numbering_of(message),
        str(getattr(message, "plate", "")),
        drop_height if is_known else None,
    )


class Copies:
    """Tells copies apart from messages that merely say the same.

    Within one recording every message counts: two parts may land alike in one picture.
    One of another recording is a copy if an equal one at the same time has no partner
    there yet.
    """

    def __init__(self) -> None:
        # by content: the times of messages, rising, and the recordings that have them
        self._messages: dict[bytes, list[tuple[int, set[int]]]] = {}
        self.count = 0
        self.unstamped = 0

    def is_copy(self, content: bytes, source: int, stamp: int, log_time: int) -> bool:
        """Whether another recording has it, by stamp, else by time of recording."""
        time = stamp
        delay = 0
        if not stamp:
            self.unstamped += 1
            time = log_time
            delay = RECORDING_DELAY
        messages = self._messages.setdefault(content, [])
        first = bisect_left(messages, time - delay, key=itemgetter(0))
        end = bisect_right(messages, time + delay, key=itemgetter(0))
        for _, sources in messages[first:end]:
            if source not in sources:
                sources.add(source)
                self.count += 1
                return True
        insort(messages, (time, {source}), key=itemgetter(0))
        return False
