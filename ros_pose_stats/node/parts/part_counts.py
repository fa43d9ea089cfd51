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

"""What cameras counted of a part, each message once, stored before it is shown."""

import hashlib
import json
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import PoseCounts, PoseStatistics

from ...base import methods, text
from ...core import records
from ...core.planning.confidence import (
    learn_plate_error,
    observe_counts,
    plate_evidence,
)
from ...core.records import Array, Index, Part
from ...core.records.scene import Numbering, numbering_of
from ...core.resting.poses import RestingPoses, resting_poses
from ...core.statistics.chi_square import homogeneity
from ..equipment import Equipment
from ..messages import part_requests
from ..messages.codes import NotFoundError
from ..messages.statistics_messages import statistics_of_message
from ..state import Change

if TYPE_CHECKING:
    from ...core.plates.profile import LeftOut

RECENT = 400  # parts that are compared with all those before

SAME_DOWN = 1e-6
"""By how much the cosine of two directions may be below 1 that are the same one."""

CHANCE = 1e-4
"""Below it a change is more: one false alarm in some hundred thousand parts."""


class Ground(NamedTuple):
    """What counts have in common that are added: numbers of poses, and the plate."""

    numbering: Numbering
    plate: str


class Tally:
    """Counts of a part's poses, and whether the last ones differ from those before."""

    def __init__(self, ground: Ground, total: Index, series: int) -> None:
        self.ground = ground
        self.series = series  # tells these counts from others of the same part
        # of the state, that has all of it; None: all so far
        self.change: int | None = None
        # what they say of the plate's error, by `PLATE_ERRORS`
        self.evidence: Array | None = None
        # parts (P,) seen in each pose, by `index`; each sum is a new array
        self.total = total
        # by the feeder's setting, and by the pose before and after
        self.flips: dict[str, Counter[tuple[int, int]]] = {}
        self._recent: deque[Index] = deque()
        self._recent_parts = 0
        self._compared = total  # that `_drift` is of
        self._drift = ""

    def add(self, message: PoseCounts) -> int:
        """Add a camera's counts of poses that the part has; how many parts that is."""
        counts = np.zeros_like(self.total)
        for index, count in zip(message.index, message.count, strict=True):
            counts[index] += count
        parts = int(counts.sum())
        if not parts:
            return 0
        if message.from_pose >= 0:
            flips = self.flips.setdefault(message.feeder_setting, Counter())
            for index in np.flatnonzero(counts).tolist():
                flips[message.from_pose, index] += int(counts[index])
            return parts
        self._recent.append(counts)
        self._recent_parts += parts
        while self._recent_parts - int(self._recent[0].sum()) >= RECENT:
            self._recent_parts -= int(self._recent.popleft().sum())
        self.total = self.total + counts
        self.evidence = None
        return parts

    def drift(self) -> str:
        """How the last parts differ from those before beyond chance, or nothing."""
        total = self.total
        if total is not self._compared:
            recent = sum(list(self._recent), 0 * total)
            self._drift = describe_drift(total - recent, recent)
            self._compared = total
        return self._drift


def describe_drift(earlier: Index, recent: Index) -> str:
    """How parts (P,) of late differ from those before beyond chance, or nothing."""
    if min(recent.sum(), earlier.sum()) < RECENT:
        return ""
    # Below 0 it is while a camera counts.
    if earlier.min() < 0 or not homogeneity(earlier, recent).p_value < CHANCE:
        return ""
    recent_shares = recent / recent.sum()
    earlier_shares = earlier / earlier.sum()
    index = int(np.abs(recent_shares - earlier_shares).argmax())
    return (
        f"of the last {recent.sum()} parts {text.percent(recent_shares[index])} % lie "
        f"in pose {index}, of the {earlier.sum()} before "
        f"{text.percent(earlier_shares[index])} % did"
    )


class PartCounts:
    """What was counted of a part, in memory and state, used under the part's lock."""

    def __init__(
        self,
        equipment: Equipment,
        part_id: str,
        digest: str,
    ) -> None:
        self._settings = equipment.settings
        self._state = equipment.state
        self._warn = equipment.node.get_logger().warning
        self._topic = equipment.node.full_name("pose_counts")
        self._part_id = part_id
        self._digest = digest
        self.tally: Tally | None = None  # None: nothing yet that is known here
        # whether poses keep their numbers under two numberings that the part itself
        # has compared
        self._are_alike: dict[frozenset[Numbering], bool] = {}

    def restore(self) -> None:
        """Take up what the state has, where nothing is in memory yet."""
        if self.tally is not None:
            return
        row = self._state.get("counts", self._part_id)
        if row is None or row[1] != self._digest:
            return
        _, _, tolerance, sides, plate, total, series = row
        self.tally = Tally(
            Ground(Numbering(tolerance, sides), plate),
            np.frombuffer(total, np.int64).copy(),
            series,
        )
        row = self._state.get("flips", self._part_id)
        if row is None or row[1] != series:
            return
        for setting, flips in json.loads(row[2]).items():
            self.tally.flips[setting] = Counter(
                {(start, end): count for start, end, count in flips}
            )

    def add(self, message: PoseCounts, result: PoseStatistics) -> bool:
        """Learn what a camera counted of a result on this plate.

        False for what came before.
        """
        ground = self._ground_of(result)
        poses = len(result.poses)
        tally = self._tally_on(ground, poses)
        if tally is None:
            tally = Tally(ground, np.zeros(poses, np.int64), time.time_ns())
            self.tally = tally
        content = hashlib.sha256(str(message).encode()).digest()[:16]
        identity = tally.series.to_bytes(8, "big") + content
        if self._state.get("counted", identity) is not None:
            return False
        if tally.add(message):
            changes = [self._change_of(tally), Change("counted", identity, (identity,))]
            if message.from_pose >= 0:
                changes.append(self._change_of_flips(tally))
            tally.change = self._state.put(*changes)
        return True

    def commit(self) -> bool:
        """Wait until what was counted is stored; whether it is on the disk."""
        return self.tally is None or self._state.commit(self.tally.change)

    def _change_of(self, tally: Tally) -> Change:
        tolerance, sides = tally.ground.numbering
        return Change(
            "counts",
            self._part_id,
            (
                self._part_id,
                self._digest,
                float(tolerance),
                int(sides),
                tally.ground.plate,
                tally.total.tobytes(),
                tally.series,
            ),
        )

    def _change_of_flips(self, tally: Tally) -> Change:
        settings = {
            setting: [(start, end, count) for (start, end), count in flips.items()]
            for setting, flips in tally.flips.items()
        }
        row = (self._part_id, tally.series, json.dumps(settings))
        return Change("flips", self._part_id, row)

    def removal(self) -> list[Change]:
        """The changes of the state by which it forgets them."""
        return [Change(table, self._part_id, None) for table in ("counts", "flips")]

    def _tally_on(self, ground: Ground, poses: int) -> Tally | None:
        """The counts on a ground, if there are such of as many poses."""
        self.restore()
        tally = self.tally
        if (
            tally is None
            or not self._goes_on(tally, ground)
            or tally.total.size != poses
        ):
            return None
        tally.ground = ground
        return tally

    def _goes_on(self, tally: Tally, ground: Ground) -> bool:
        """Whether counts are of a ground, or only `round_sides` is new there."""
        return tally.ground.plate == ground.plate and bool(
            self._keeps_numbers(tally.ground.numbering, ground.numbering)
        )

    def _keeps_numbers(self, numbering: Numbering, other: Numbering) -> bool | None:
        """Whether poses have equal numbers under both; None where the part must say."""
        if numbering == other:
            return True
        if numbering.cluster_tolerance != other.cluster_tolerance:
            return False
        return self._are_alike.get(frozenset((numbering, other)))

    def other_numberings(self, numbering: Numbering) -> list[Numbering]:
        """Numberings that the part has to compare with this one, and has not yet."""
        self.restore()
        tally = self.tally
        if tally is None:
            return []
        numberings = []
        if tally.ground.plate == self._settings().plate:
            numberings.append(tally.ground.numbering)
        left_out = self._left_out()
        if left_out is not None:
            numberings.append(numbering_of(left_out))
        return [
            other
            for other in numberings
            if self._keeps_numbers(other, numbering) is None
        ]

    def lack_comparison(self, result: PoseStatistics) -> bool:
        """Whether the part itself must say first how what was counted fits a result."""
        ground = self._ground_of(result)
        others = self.other_numberings(ground.numbering)
        tally = self.tally  # which may be back only now
        return others != [] or (
            tally is not None
            and self._goes_on(tally, ground)
            and tally.total.size != len(result.poses)
        )

    def compare(self, part: Part, numbering: Numbering) -> None:
        """Have the part say how what was counted fits results of a numbering."""
        others = self.other_numberings(numbering)
        tally = self.tally
        if tally is None:
            return
        resting = resting_poses(part, *numbering)
        for other in others:
            self._are_alike[frozenset((other, numbering))] = resting_poses(
                part, *other
            ).is_numbered_like(resting)
        ground = Ground(numbering, self._settings().plate)
        if self._goes_on(tally, ground) and tally.total.size != len(resting.poses):
            tally.ground = ground
            self.tally = self._renumber(tally, resting)

    def _renumber(self, tally: Tally, resting: RestingPoses) -> Tally | None:
        """Counts of a version with other poses, for those that have their `down` now.

        None where no pose has. What is set aside is told.
        """
        poses = len(resting.poses)
        pose_of = self._poses_now(tally, resting)
        has_pose = pose_of >= 0
        moved_tally = Tally(tally.ground, np.zeros(poses, np.int64), tally.series)
        np.add.at(moved_tally.total, pose_of[has_pose], tally.total[has_pose])
        for setting, flips in tally.flips.items():
            moved_flips = moved_tally.flips.setdefault(setting, Counter())
            for (start, end), count in flips.items():
                if has_pose[start] and has_pose[end]:
                    moved_flips[int(pose_of[start]), int(pose_of[end])] += count
        self._warn(
            f"an earlier version had {tally.total.size} poses of "
            f"{part_requests.quote_text(self._part_id)}, this one has {poses}: "
            f"{tally.total[has_pose].sum()} of {tally.total.sum()} parts that were "
            f"counted are of the poses with the same down; the others are set aside"
        )
        if not has_pose.any():
            self._state.put(*self.removal())
            return None
        changes = [self._change_of(moved_tally), self._change_of_flips(moved_tally)]
        moved_tally.change = self._state.put(*changes)
        return moved_tally

    def _poses_now(self, tally: Tally, resting: RestingPoses) -> Index:
        """Pose (K,) that each counted one is part of now, -1 where that is not known.

        The result that the state still has says where they pointed down.
        """
        unknown = np.full(tally.total.size, -1, np.int64)
        row = self._state.get("results", self._part_id)
        if row is None:
            return unknown
        try:
            message = deserialize_message(row[1], PoseStatistics)
        except Exception:  # of the bindings
            return unknown
        if (message.part_digest, len(message.poses)) != (self._digest, unknown.size):
            return unknown
        downs = np.empty((unknown.size, 3))
        for pose in message.poses:
            downs[pose.index] = pose.down.x, pose.down.y, pose.down.z
        cosine = downs @ resting.body.arrays.normal.T
        is_face = cosine.max(axis=1) > 1.0 - SAME_DOWN
        return np.where(is_face, resting.pose_of_face[cosine.argmax(axis=1)], -1)

    def flips_at(self, message: PoseStatistics, setting: str) -> Index:
        """Flips (K, K) counted at a setting on a result's ground; or NotFoundError."""
        tally = self.tally
        flips = {}
        if tally is not None and tally.ground == self._ground_of(message):
            flips = tally.flips
        if tally is None or setting not in flips:
            settings = [part_requests.quote_text(name) for name in sorted(flips)]
            raise NotFoundError(
                "a feeder_setting whose flips were counted",
                f"{part_requests.quote_text(setting)}; there is "
                f"{text.listed(settings or ['none'])}",
                f"publish {self._topic} with from_pose and feeder_setting",
            )
        counts = np.zeros((tally.total.size, tally.total.size), np.int64)
        for start_and_end, count in flips[setting].items():
            counts[start_and_end] = count
        return counts

    def name_plate(self, plate: str) -> list[Change]:
        """Take counts of a nameless plate for this one's; the changes that say so."""
        tally = self.tally
        if tally is None or tally.ground.plate:
            return []
        tally.ground = tally.ground._replace(plate=plate)
        return [self._change_of(tally)]

    def parts_counted_for(self, message: PoseStatistics) -> int:
        """Parts that were counted on the ground of a result."""
        tally = self.tally
        if tally is None or tally.ground != self._ground_of(message):
            return 0
        return int(tally.total.sum())

    def combine(
        self,
        message: PoseStatistics,
        evidence_of_others: Callable[[str], Iterable[Array]],
    ) -> records.PoseStatistics | None:
        """A result with what was counted in it; None where nothing was that fits it.

        `evidence_of_others`: what the other parts that were counted on a plate say of
        its error.
        """
        ground = self._ground_of(message)
        tally = self._tally_on(ground, len(message.poses))
        if tally is None:
            return None
        model = statistics_of_message(message)
        profile = self._settings().profile
        shares: tuple[float, ...] = ()
        if profile is not None:
            shares = self._shares_by_fit(ground)
        else:
            tally.evidence = plate_evidence(model, tally.total)
            plate_error = learn_plate_error(evidence_of_others(ground.plate))
            model = replace(model, plate_error=plate_error)
        combined = observe_counts(model, tally.total, shares)
        return combined if combined.method == methods.OBSERVED else None

    def _shares_by_fit(self, ground: Ground) -> tuple[float, ...]:
        """What a plate's fit says of the part without its own counts, if it does."""
        left_out = self._left_out()
        if left_out is None:
            return ()
        keeps_numbers = self._keeps_numbers(numbering_of(left_out), ground.numbering)
        return left_out.probability if keeps_numbers else ()

    def _left_out(self) -> "LeftOut | None":
        """What the fit of the present plate says of the part without its counts."""
        profile = self._settings().profile
        return None if profile is None else profile.left_out.get(self._digest)

    def evidence_on(self, plate: str, model: PoseStatistics) -> Array | None:
        """What the counts, together with the part's model, say of a plate's error."""
        tally = self.tally
        if tally is None or tally.ground.plate != plate:
            return None
        evidence = tally.evidence
        total = tally.total  # a camera may count meanwhile
        is_of_model = tally.ground == self._ground_of(model)
        if evidence is None and is_of_model and total.size == len(model.poses):
            evidence = plate_evidence(statistics_of_message(model), total)
            tally.evidence = evidence
        return evidence

    def _ground_of(self, message: PoseStatistics) -> Ground:
        return Ground(numbering_of(message), self._settings().plate)
