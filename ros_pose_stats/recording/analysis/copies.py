"""Which messages are copies of one that another recording holds too."""

from __future__ import annotations

from bisect import bisect_left, insort
from dataclasses import dataclass, field
from hashlib import blake2b
from typing import Any

import numpy as np

WITHIN = 1_000_000_000
"""Two recorders write down a message without a stamp at most this far apart [ns]."""


def fingerprint(*values: Any) -> bytes:
    """Sixteen bytes that stand for plain values and numpy arrays."""
    digest = blake2b(digest_size=16)
    for value in values:
        digest.update(value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode())
        digest.update(b"\0")
    return digest.digest()


@dataclass(order=True)
class _Seen:
    time: int
    sources: set[int] = field(compare=False)


class Copies:
    """Tells copies apart from messages that merely say the same.

    Within one recording every message counts: two parts may land alike in one picture. A
    message of another recording is a copy if an equal one at the same time has no partner there
    yet.
    """

    def __init__(self) -> None:
        self._seen: dict[bytes, list[_Seen]] = {}
        self.found = 0
        self.unstamped = 0

    def is_copy(self, content: bytes, source: int, stamp: int, log_time: int) -> bool:
        """Whether this message has been met in another recording; it is remembered.

        Parameters
        ----------
        content : bytes
            Fingerprint of everything but the time.
        source : int
            Number of the topic of a bag.
        stamp : int
            Nanoseconds; 0 where the sender gave none. Then the time of recording decides.
        log_time : int
            Nanoseconds.
        """
        self.unstamped += not stamp
        time, window = (stamp, 0) if stamp else (log_time, WITHIN)
        known = self._seen.setdefault(content, [])
        place = bisect_left(known, _Seen(time - window, set()))
        while place < len(known) and known[place].time <= time + window:
            if source not in known[place].sources:
                known[place].sources.add(source)
                self.found += 1
                return True
            place += 1
        insort(known, _Seen(time, {source}))
        return False
