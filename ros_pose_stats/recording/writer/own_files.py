"""Which files of the running bag go to make room, and how long before that it is said."""

from __future__ import annotations

import math
from typing import Final

from ..repair.removal import SpaceBound
from .bag import Bag

_FILES: Final = 8
"""Files that the bound of a log directory has room for at least, so that the oldest can go."""


class OwnFiles:
    """The files of a run's own bag, under the bound of its log directory.

    Whoever records is given notice a file before the oldest ones must go, by `kept_from`, writes
    again what still counts in them, and then releases them. A file that is not released stays,
    and the bound is exceeded until it is.

    `limit`: bytes of all bags together; 0 for no bound; `max_bytes`: a file has at most so many,
    and at most an eighth of the bound; `start`: bytes of a file without messages. Attributes
    `max_bytes`: of a file; `margin`: bytes by which the bag grows between notice and need;
    `kept_from`: messages written while the log's `mark` was less are gone, or are to go;
    `released`: files whose mark is less may be deleted; at first all; `deleted`: how many have
    gone; `last_deleted`: name of the one that went last; `waits`: whether the oldest was to go and
    was not released yet.
    """

    def __init__(self, limit: int, max_bytes: int, start: int) -> None:
        self.max_bytes = min(max_bytes, max(limit // _FILES, 4 * start)) if limit else max_bytes
        self.margin = 2 * self.max_bytes
        self.kept_from = 0
        self.released = math.inf
        self.deleted = 0
        self.last_deleted = ""
        self.waits = False
        self._limit = limit

    def room_to_keep(self, space: SpaceBound) -> int | None:
        """Bytes that can be written again and again to be kept; None without a bound.

        Half of what the bound leaves beside runs of others, the file that is being written and
        the one that goes next: so at least every second byte is free for what is new.
        """
        if not self._limit:
            return None
        return max(0, self._limit - space.held - self.margin) // 2

    def look_ahead(self, bag: Bag, space: SpaceBound) -> None:
        """Give notice of the files that must go before the next but one is full."""
        if not self._limit:
            return
        excess = space.held + bag.closed_size + self.margin - self._limit
        for file in bag.closed:
            if excess <= 0:
                break
            excess -= file.size
            self.kept_from = max(self.kept_from, file.mark + 1)

    def drop_oldest(self, bag: Bag | None) -> int:
        """Delete the oldest closed file if it is released, else ask for that; its bytes."""
        self.waits = False
        if bag is None or not bag.closed:
            return 0
        oldest = bag.closed[0]
        self.kept_from = max(self.kept_from, oldest.mark + 1)
        self.waits = oldest.mark >= self.released
        if self.waits or bag.drop_oldest() is None:
            return 0
        self.last_deleted = oldest.name
        self.deleted += 1
        return oldest.size
