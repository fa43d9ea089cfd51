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

"""What a feeder is to do with a part, and what it gets: one plan for every question.

Commands, pages and the node ask `plan_feeding`, whatever the cell.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.errors import RequestError
from ...base.text import bounded, three_digits
from ..records import Array, FlipStatistics, Mask, Part, PoseStatistics
from ..records.notes import Note
from ..records.plain_values import with_units
from ..records.scene import HIGHEST_KICK, height_warnings
from ..records.statistics import require_same_part
from ..statistics import feeding, pose_groups
from . import plate_fill
from .feeder_cell import FeederCell, KickPlan, describe_cell
from .plate import Plate
from .single_parts import SingleParts

PICK = "pick"
FLIP = "flip"
LEAVE = "leave"


@dataclass(frozen=True)
class FeedingPlan:
    """What the cell is to do.

    Attributes
    ----------
    cell : str
        The cell in a sentence, with the parts on its plate.
    actions : tuple of str
        For each pose by its index: `pick` it where it is free, as poses that look like
        a wanted one from above are too, since the camera cannot tell; `flip`, for
        kicking a part that lies so gets one picked sooner than dropping another; or
        `leave` it, for it does not.
    best : KickPlan
        The kick, the number of parts and the kicks to use.
    options : tuple of KickPlan
        Without kicks, and with each kick by its height.
    warnings : tuple of Note
        Of the dropped part, of poses that are taken for wanted ones, and of kicks that
        no feeder gives.
    """

    cell: str
    actions: tuple[str, ...]
    best: KickPlan
    options: tuple[KickPlan, ...]
    warnings: tuple[Note, ...]

    def as_dict(self) -> dict[str, Any]:
        """The plan as plain values."""
        return with_units(
            {
                "cell": self.cell,
                "warnings": self.warnings,
                "actions": self.actions,
                "options": self.options,
                **self.best._asdict(),
            }
        )

    def describe_gain(self) -> str:
        """Parts picked a minute by the best kick, and what kicking gains."""
        without_kick, *kicked = self.options
        gain = ""
        if self.best.is_kicking:
            unkicked = three_digits(without_kick.per_minute.value)
            gain = f"; {unkicked} without kicks"
        elif len(kicked) == 1:
            gain = f": {kicked[0].name} gains nothing"
        elif kicked:
            gain = f": none of {len(kicked)} kicks gains anything"
        best = self.best
        return (
            f"{bounded(best.per_minute)} picked a minute, {best.describe_kick()}{gain}"
        )


def check_feeding(
    dropped: PoseStatistics, wanted: Sequence[int], cell: FeederCell
) -> Mask:
    """Which poses (K,) are wanted; raises RequestError where no plan can be made.

    It costs next to nothing: whoever has to kick a part for a plan asks this first.
    """
    cell.check()
    is_wanted = feeding.check_wanted_poses(wanted, len(dropped.poses))
    if not pose_groups.pose_shares(dropped).probability[is_wanted].any():
        raise RequestError(
            "wanted poses that dropped parts come to rest in",
            "none of them",
            "name others; `ros_pose_stats estimate` lists their probabilities",
        )
    return is_wanted


def plan_feeding(
    dropped: PoseStatistics,
    wanted: Sequence[int],
    cell: FeederCell,
    flips: Sequence[FlipStatistics] = (),
    part: Part | None = None,
) -> FeedingPlan:
    """Plan a cell: poses to pick, whether to kick, and how many parts to put on it.

    Parameters
    ----------
    dropped : PoseStatistics
        Of a part, by any method. Where `find_lookalikes` has filled in which poses look
        alike from above, those that a camera takes for wanted ones are picked with
        them, and take their time, but only wanted ones count.
    wanted : sequence of int
        Indices of the poses that the robot picks, at least one.
    cell : FeederCell
    flips : sequence of FlipStatistics
        Of the same part and scene, one for each kick that the cell can give. Of those
        that a cell counted (`learn_flips`) the errors are their own, without the
        plate's.
    part : Part, optional
        The part, whose bays and holes let others in. Default: silhouettes count as
        convex, which tells too few free parts, of a hex bolt up to 8 %
        (docs/measured/benchmarks.md).

    Returns
    -------
    FeedingPlan

    Raises
    ------
    RequestError
        If a number is out of its range, there is no such pose, no dropped part comes to
        rest in a wanted one, flips out of a pose are missing, or results are of another
        part.
    """
    is_wanted = check_feeding(dropped, wanted, cell)
    feeding.check_alike([dropped, *flips])
    if part is not None:
        require_same_part(dropped, part)
    feeder = _feeder(dropped, is_wanted, cell, part)
    kicks = [None, *sorted(flips, key=lambda kick: kick.kick_height)]
    options = [feeder.plan(kick) for kick in kicks]
    best, kick = max(
        zip(options, kicks, strict=True), key=lambda pair: pair[0].per_minute.value
    )
    actions = np.full(feeder.pick_mask.size, LEAVE)
    if kick is not None and best.is_kicking:
        actions[feeder.poses_worth_flipping(best.parts, kick.transition)] = FLIP
    actions[feeder.pick_mask > 0.0] = PICK
    highest_kick = max((kick.kick_height for kick in flips), default=0.0)
    return FeedingPlan(
        describe_cell(cell, best),
        tuple(actions.tolist()),
        best,
        tuple(options),
        (
            *dropped.warnings,
            *pose_groups.warn_of_lookalikes(dropped, wanted),
            *height_warnings("kick", highest_kick, dropped.radius, HIGHEST_KICK),
        ),
    )


def _feeder(
    dropped: PoseStatistics,
    is_wanted: Mask,
    cell: FeederCell,
    part: Part | None,
) -> SingleParts | Plate:
    """A part in its cell."""
    shares = pose_groups.pose_shares(dropped)
    is_picked = is_wanted.copy()
    wanted_indices = set(np.flatnonzero(is_wanted).tolist())
    is_picked[list(pose_groups.poses_mistaken(dropped, wanted_indices))] = True
    poses = list(dropped.by_index.values())
    situation = (
        cell,
        is_picked.astype(np.float64),
        shares,
        poses,
        0.0 if dropped.counted_parts else dropped.plate_error,
        is_wanted.astype(np.float64),
    )
    if cell.plate is None:
        return SingleParts(*situation)
    blocking: Array | float = 1.0
    if part is not None:
        blocking = plate_fill.blocking_with_bays(
            part,
            poses,
            shares.probability,
            np.flatnonzero(is_picked),
            cell.clearance,
        )
    return Plate(*situation, blocking)
