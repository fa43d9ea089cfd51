# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""What cameras counted, added up, each message once however often it was recorded."""

import math
from bisect import bisect_left, bisect_right, insort
from collections import Counter
from dataclasses import dataclass, field, replace
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
    numbering: Numbering  # by which the camera names the poses, where that is known
    plate: str
    drop_height: float  # metres; NaN where the camera did not know it
    begin: int  # of the first message, nanoseconds since 1970
    end: int  # of the last message
    messages: int = 0
    unclassified: int = 0  # parts seen in no stable pose
    of_pose: Counter[int] = field(default_factory=Counter)
    unknown_code: int = 0  # the numbering that the camera names, of no result; 0: none

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

    def are_of(self, part_id: str, part_digest: str) -> bool:
        """Whether they are of a part: by its digest, or its name if they have none."""
        if self.part_digest:
            return part_digest == self.part_digest
        return part_id == self.part_id

    def take(self, other: "CameraCounts") -> None:
        """Add other counts of the same."""
        self.begin = min(self.begin, other.begin)
        self.end = max(self.end, other.end)
        self.messages += other.messages
        self.unclassified += other.unclassified
        self.of_pose.update(other.of_pose)  # which keeps poses of no parts


class PoseIdentity(NamedTuple):
    """Which pose an index is."""

    part_digest: str
    numbering: Numbering


class CountKey(NamedTuple):
    """Whose counts are added up together."""

    part_id: str
    part_digest: str
    numbering: Numbering
    plate: str
    drop_height: float | None  # metres; None where the camera did not know it
    # numbering of a result that says the rest; 0: the result at the time. None where
    # digest and numbering are known, as of a node up to 0.2.0, which has them itself.
    code: int | None


class CountCollector:
    """Adds up PoseCounts of landings, each once; arrays of two lengths are refused."""

    def __init__(self) -> None:
        self.copies = Copies()
        self.refused = 0
        self.flips = 0
        self._counts: dict[CountKey, CameraCounts] = {}
        self._identity_of_code: dict[int, PoseIdentity] = {}
        # by name; the last one is that of the last result
        self._identities: dict[str, dict[PoseIdentity, None]] = {}

    def note_result(self, message: Any, numbering: Numbering, latched: bool) -> None:
        """Know what a PoseStatistics numbers, for counts that name its number."""
        identity = PoseIdentity(str(getattr(message, "part_digest", "")), numbering)
        self._identity_of_code[int(getattr(message, "numbering", 0))] = identity
        if latched:
            part_id = str(getattr(message, "part_id", ""))
            identities = self._identities.setdefault(part_id, {})
            identities.pop(identity, None)
            identities[identity] = None

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
        of_pose: Counter[int] = Counter()
        for pose, count in zip(poses, parts, strict=True):
            of_pose[pose] += count
        if key.code == 0:
            key = _identified(key, next(reversed(self._identities_of(key)), None))
        counts = _empty_counts(key, time)
        self._counts.setdefault(key, counts).take(
            replace(counts, messages=1, unclassified=unclassified, of_pose=of_pose)
        )

    def all(self) -> list[CameraCounts]:
        """All counts, once all results are known that they may name."""
        sums: dict[CountKey, CameraCounts] = {}
        for key, counts in self._counts.items():
            identity = None
            if key.code:
                identity = self._identity_of_code.get(key.code)
            elif len(self._identities_of(key)) == 1:
                [identity] = self._identities_of(key)
            known_key = _identified(key, identity)
            sums.setdefault(known_key, _empty_counts(known_key, counts.begin)).take(
                counts
            )
        return list(sums.values())

    def _identities_of(self, key: CountKey) -> dict[PoseIdentity, None]:
        return self._identities.get(key.part_id, {})


def _identified(key: CountKey, identity: PoseIdentity | None) -> CountKey:
    """The key of counts whose poses are known by now."""
    if key.code is None or identity is None:
        return key
    return key._replace(**identity._asdict(), code=None)


def _empty_counts(key: CountKey, time: int) -> CameraCounts:
    drop_height = math.nan if key.drop_height is None else key.drop_height
    return CameraCounts(
        *key[:4], drop_height, begin=time, end=time, unknown_code=key.code or 0
    )


def _count_key(message: Any) -> CountKey:
    drop_height = float(getattr(message, "drop_height", -1.0))
    is_known = math.isfinite(drop_height) and drop_height >= 0.0
    return CountKey(
        str(getattr(message, "part_id", "")),
        str(getattr(message, "part_digest", "")),
        numbering_of(message),
        str(getattr(message, "plate", "")),
        drop_height if is_known else None,
        int(message.numbering) if hasattr(message, "numbering") else None,
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
