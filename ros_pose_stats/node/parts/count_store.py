"""What cameras counted of the parts: each message once, and kept before a result shows it."""

import hashlib
import json
import time
from collections import Counter, deque
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from ros_pose_stats_msgs.msg import PoseCounts, PoseStatistics

from ...base import errors, methods, text
from ...core import records
from ...core.planning.confidence import (
    learnt_plate_error,
    observe_counts,
    plate_evidence,
)
from ...core.records import Array, Index
from ...core.records.scene import Numbering
from ...core.resting.poses import resting_poses
from ...core.statistics.chi_square import homogeneity
from ..equipment import Equipment
from ..messages import part_requests, statistics_messages
from ..recording.decoding import numbering_of
from ..refusals import Health
from ..state import Change
from . import known_part, part_store

RECENT = 400  # parts that are compared with all those before

CHANCE = 1e-4
"""Below it a change is more: one false alarm in some hundred thousand parts."""


class Ground(NamedTuple):
    """What counts must have in common to be added: numbers of the poses, and the plate."""

    numbering: Numbering
    plate: str

    def goes_on_as(self, other: "Ground", known: known_part.KnownPart) -> bool:
        """Whether only `round_sides` is new, as of a plate, and poses keep their numbers."""
        tolerance, sides = self.numbering
        new = other.numbering.round_sides
        if other != Ground(Numbering(tolerance, new), self.plate):
            return False
        try:
            part = known.part
        except (
            Exception
        ):  # the intake builds it too, says why not, and forgets what is refused
            return False
        return resting_poses(part, tolerance, sides).is_numbered_like(
            resting_poses(part, tolerance, new)
        )


class CellCounts:
    """Counts of a part's poses, and whether the last ones differ from those before."""

    def __init__(self, ground: Ground, total: Index, series: int) -> None:
        self.ground = ground
        self.series = series
        self.change: int | None = (
            None  # of the state, that has all of it; None: all so far
        )
        self.evidence: Array | None = (
            None  # what they say of the plate's error, by `PLATE_ERRORS`
        )
        self.total = (
            total  # parts (P,) seen in each pose, by `index`; each sum is a new array
        )
        # by the feeder's speed, and by the pose before and after
        self.flips: dict[str, Counter[tuple[int, int]]] = {}
        self._recent: deque[Index] = deque()
        self._seen = 0
        self._drift = total, ""  # of that total

    def add(self, counts: PoseCounts) -> int:
        """Add what a camera counted, of poses that the part has; how many parts that is."""
        new = np.zeros_like(self.total)
        for index, count in zip(counts.index, counts.count, strict=True):
            new[index] += count
        seen = int(new.sum())
        if not seen:
            return 0
        if counts.from_pose >= 0:
            self.flips.setdefault(counts.feeder_speed, Counter()).update(
                {
                    (counts.from_pose, index): int(new[index])
                    for index in np.flatnonzero(new).tolist()
                }
            )
            return seen
        self._recent.append(new)
        self._seen += seen
        while self._seen - int(self._recent[0].sum()) >= RECENT:
            self._seen -= int(self._recent.popleft().sum())
        self.total = self.total + new
        self.evidence = None
        return seen

    def drift(self) -> str:
        """How the last parts differ from those before beyond chance; empty if they do not."""
        total = self.total
        if total is not self._drift[0]:
            said = ""
            recent = sum(list(self._recent), 0 * total)
            before = total - recent
            enough = min(recent.sum(), before.sum()) >= RECENT
            # Below 0 it is while a camera counts.
            if (
                enough
                and before.min() >= 0
                and homogeneity(before, recent).p_value < CHANCE
            ):
                now = recent / recent.sum()
                then = before / before.sum()
                most = int(np.abs(now - then).argmax())
                said = (
                    f"of the last {recent.sum()} parts {text.percent(now[most])} % lie in "
                    f"pose {most}, of the {before.sum()} before {text.percent(then[most])} % "
                    "did"
                )
            self._drift = total, said
        return self._drift[1]


class CountStore:
    """Learns counts of known parts on the node's plate."""

    def __init__(self, equipment: Equipment, parts: part_store.PartStore) -> None:
        self._settings = equipment.settings
        self._parts = parts
        self._state = equipment.state
        self._warn = equipment.node.get_logger().warning

    def restore(self, known: known_part.KnownPart) -> None:
        """Give a part what the state has of its counts, where it has none yet."""
        counted = self._state.get("counts", known.part_id)
        if known.counts is None and counted is not None and counted[1] == known.digest:
            _, _, tolerance, sides, plate, total, series = counted
            known.counts = CellCounts(
                Ground(Numbering(tolerance, sides), plate),
                np.frombuffer(total, np.int64).copy(),
                series,
            )
            flipped = self._state.get("flips", known.part_id)
            if flipped is not None and flipped[1] == series:
                known.counts.flips = {
                    speed: Counter(
                        {(before, after): count for before, after, count in flips}
                    )
                    for speed, flips in json.loads(flipped[2]).items()
                }

    def health(self) -> Health:
        """The line of diagnostics about what cameras counted, and what has changed in it."""
        counted = {
            known.part_id: counts
            for known in self._parts.all()
            if (counts := known.counts) is not None
        }
        changed = {
            f"changed {part_requests.shown(part_id)}": drift
            for part_id, counts in counted.items()
            if (drift := counts.drift())
        }
        total = sum(int(counts.total.sum()) for counts in counted.values())
        text = next(
            (f"{name}: {drift}" for name, drift in changed.items()),
            f"{total} parts counted of {len(counted)} kinds",
        )
        return Health(
            bool(changed),
            text,
            {"kinds counted": len(counted), "parts counted": total, **changed},
        )

    def add_counts(
        self, known: known_part.KnownPart, shown: known_part.Shown, counts: PoseCounts
    ) -> bool:
        """Learn from what a camera counted on this plate; false for what came before.

        The lock of the part's name is held since `counts` were compared with what is `shown`.
        """
        ground = self._ground(counts)
        poses = len(shown.latched.poses)
        known.counts = self._counts_on(known, ground, poses) or CellCounts(
            ground, np.zeros(poses, np.int64), time.time_ns()
        )
        content = hashlib.sha256(str(counts).encode()).digest()[:16]
        identity = known.counts.series.to_bytes(8, "big") + content
        if self._state.get("counted", identity) is not None:
            return False
        if known.counts.add(counts):
            flipped = (
                []
                if counts.from_pose < 0
                else [
                    Change(
                        "flips",
                        known.part_id,
                        (
                            known.part_id,
                            known.counts.series,
                            json.dumps(
                                {
                                    speed: [
                                        (*moved, count)
                                        for moved, count in flips.items()
                                    ]
                                    for speed, flips in known.counts.flips.items()
                                }
                            ),
                        ),
                    )
                ]
            )
            known.counts.change = self._state.put(
                self._counts_row(known, known.counts),
                *flipped,
                Change("counted", identity, (identity,)),
            )
        return True

    def _counts_on(
        self, known: known_part.KnownPart, ground: Ground, poses: int
    ) -> CellCounts | None:
        """What was counted on a ground; those of a version that had other poses there go."""
        self.restore(known)
        counts = known.counts
        if counts is None or counts.ground != ground:
            return None
        if counts.total.size != poses:
            self._warn(
                f"what was counted of {part_requests.shown(known.part_id)} no longer "
                f"counts: expected {poses} poses, got counts of {counts.total.size}; "
                f"an earlier version had others, so count again"
            )
            counts = known.counts = None
            self._state.put(
                *(Change(table, known.part_id, None) for table in ("counts", "flips"))
            )
        return counts

    def flips(
        self, known: known_part.KnownPart, message: PoseStatistics, speed: str
    ) -> Index:
        """Flips (K, K) counted at a speed on the ground of a result, or RequestError."""
        with known.revisions.lock:
            counts = known.counts
            fitting = counts is not None and counts.ground == self._ground(message)
            flips = counts.flips if counts is not None and fitting else {}
            if counts is None or speed not in flips:
                there = text.listed(
                    [*map(part_requests.shown, sorted(flips))] or ["none"]
                )
                raise errors.RequestError(
                    "a feeder_speed whose flips were counted",
                    f"{part_requests.shown(speed)}; there is {there}",
                    "publish ~/pose_counts with from_pose and feeder_speed",
                )
            found = np.zeros((counts.total.size, counts.total.size), np.int64)
            for moved, count in flips[speed].items():
                found[moved] = count
        self._state.commit(counts.change)
        return found

    def name_plate(self, plate: str) -> bool:
        """Take counts of a nameless plate for counts of this one; whether the disk has that."""
        changes = []
        for known in self._parts.all():
            with known.revisions.lock:
                counts = known.counts
                if counts is not None and not counts.ground.plate:
                    counts.ground = counts.ground._replace(plate=plate)
                    changes.append(self._counts_row(known, counts))
        return self._state.commit(self._state.put(*changes))

    def _counts_row(self, known: known_part.KnownPart, counts: CellCounts) -> Change:
        tolerance, sides = counts.ground.numbering
        return Change(
            "counts",
            known.part_id,
            (
                known.part_id,
                known.digest,
                float(tolerance),
                int(sides),
                counts.ground.plate,
                counts.total.tobytes(),
                counts.series,
            ),
        )

    def _ground(self, message: PoseCounts | PoseStatistics) -> Ground:
        return Ground(numbering_of(message), self._settings().plate)

    def counted_as(self, known: known_part.KnownPart, message: PoseStatistics) -> int:
        """Parts that were counted on the ground of a result."""
        counts = known.counts
        return (
            0
            if counts is None or counts.ground != self._ground(message)
            else int(counts.total.sum())
        )

    def observe(
        self, known: known_part.KnownPart, message: PoseStatistics
    ) -> records.PoseStatistics | None:
        """A result combined with what was counted; None where nothing was that fits it."""
        self.restore(known)
        ground = self._ground(message)
        if (
            known.counts is not None
            and known.counts.ground != ground
            and (known.counts.ground.goes_on_as(ground, known))
        ):
            known.counts.ground = ground
        counts = self._counts_on(known, ground, len(message.poses))
        if counts is None:
            return None
        profile = self._settings().profile
        left_out = profile.left_out.get(known.digest) if profile else None
        told = (
            left_out.probability
            if left_out
            and Ground(Numbering(*left_out[:2]), ground.plate).goes_on_as(ground, known)
            else ()
        )
        model = statistics_messages.statistics_of_message(message)
        if profile is None:
            counts.evidence = plate_evidence(model, counts.total)
            model = replace(
                model,
                plate_error=learnt_plate_error(
                    self._evidence_beside(known, ground.plate)
                ),
            )
        combined = observe_counts(model, counts.total, told)
        return combined if combined.method == methods.OBSERVED else None

    def _evidence_beside(
        self, known: known_part.KnownPart, plate: str
    ) -> Iterator[Array]:
        """What the other parts counted on a plate say of its error."""
        for other in self._parts.all():
            counts = other.counts
            shown = other.shown
            if (
                other is known
                or counts is None
                or shown is None
                or counts.ground.plate != plate
            ):
                continue
            evidence = counts.evidence
            total = counts.total  # a camera may count meanwhile
            if evidence is None and (counts.ground, total.size) == (
                self._ground(shown.model),
                len(shown.model.poses),
            ):
                evidence = counts.evidence = plate_evidence(
                    statistics_messages.statistics_of_message(shown.model), total
                )
            if evidence is not None:
                yield evidence
