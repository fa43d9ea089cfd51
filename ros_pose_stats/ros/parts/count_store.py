"""What cameras have counted of the parts: each message once, and kept before a result shows it."""

import hashlib
import time
from collections.abc import Callable

import numpy as np
from ros_pose_stats_msgs.msg import PoseCounts, PoseStatistics

from ... import records
from ...methods import OBSERVED
from ...planning.observed import observe_counts
from ...recording.analysis.decoding import numbering_of
from ...records.scene import Numbering
from ..messages.statistics_messages import statistics_of_message
from ..settings import Settings
from ..state import Change, State
from .cell_counts import CellCounts, Ground
from .known_part import KnownPart
from .part_store import PartStore


class CountStore:
    """Learns counts of known parts on the node's plate."""

    def __init__(self, settings: Callable[[], Settings], parts: PartStore, state: State) -> None:
        self._settings, self._parts, self._state = settings, parts, state
        self._new: dict[str, KnownPart] = {}

    def restore(self, known: KnownPart) -> None:
        """Give a part what the state has of its counts."""
        counted = self._state.get("counts", known.part_id)
        if counted is not None and counted[1] == known.digest:
            _, _, tolerance, sides, plate, total, series = counted
            known.shown.counts = CellCounts(Ground(Numbering(tolerance, sides), plate),
                                            np.frombuffer(total, np.int64), series)

    def take_new(self) -> list[KnownPart]:
        """Parts of which more was counted since this was last asked."""
        return [self._new.pop(part_id) for part_id in list(self._new)]

    def add_counts(self, known: KnownPart, counts: PoseCounts) -> bool:
        """Learn from what a camera counted on this plate; false for what came before."""
        if counts.plate not in ("", self._settings().plate):
            return True
        ground, shown = self._ground(counts), known.shown
        with known.numbers.lock:
            if shown.latched is None:
                return True
            if shown.counts is None or shown.counts.ground != ground:
                shown.counts = CellCounts(ground, np.zeros(len(shown.latched.poses), np.int64),
                                          time.time_ns())
            content = hashlib.sha256(str(counts).encode()).digest()[:16]
            identity = shown.counts.series.to_bytes(8, "big") + content
            if self._state.get("counted", identity) is not None:
                return False
            if shown.counts.add(counts):
                shown.counted = self._state.put(
                    self._counts_row(known, shown.counts),
                    Change("counted", identity, (identity,)))
                self._new[known.part_id] = known
        return True

    def name_plate(self, plate: str) -> bool:
        """Take counts of a nameless plate for counts of this one; whether the disk has that."""
        changes = []
        for known in self._parts.all():
            with known.numbers.lock:
                counts = known.shown.counts
                if counts is not None and not counts.ground.plate:
                    counts.ground = counts.ground._replace(plate=plate)
                    changes.append(self._counts_row(known, counts))
        return self._state.commit(self._state.put(*changes))

    def _counts_row(self, known: KnownPart, counts: CellCounts) -> Change:
        tolerance, sides = counts.ground.numbering
        return Change("counts", known.part_id, (
            known.part_id, known.digest, float(tolerance), int(sides), counts.ground.plate,
            counts.total.tobytes(), counts.series))

    def _ground(self, message: PoseCounts | PoseStatistics) -> Ground:
        return Ground(numbering_of(message), self._settings().plate)

    def counted_as(self, known: KnownPart, message: PoseStatistics) -> int:
        """Parts that were counted on the ground of a result."""
        counts = known.shown.counts
        return 0 if counts is None or counts.ground != self._ground(message) else int(
            counts.total.sum())

    def observe(self, known: KnownPart,
                message: PoseStatistics) -> records.PoseStatistics | None:
        """A result combined with what was counted; None where nothing was that fits it."""
        counts = known.shown.counts
        if counts is None:
            return None
        ground = self._ground(message)
        if counts.ground != ground and counts.ground.goes_on_as(ground, known):
            counts.ground = ground
        if counts.ground != ground:
            return None
        found = observe_counts(statistics_of_message(message), counts.total)
        return found if found.method == OBSERVED else None
