"""What must and must not come out of a drop, whatever the body."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ros_pose_stats import Part, resting_poses
from ros_pose_stats.simulation.drops import DropOutcomes

MOST_UNSETTLED = 1e-5
"""Share of the drops that may be given up."""

ROUNDING = 1e-8
"""How far below its pose's height an energy may come out, in m g radius.

Corners touch within 1e-9, so a body at rest may lie that much too low at one of them.
"""


class Task(NamedTuple):
    """Drops of one body at one restitution."""

    part: Part
    restitution: float
    seed: int
    drops: int


@dataclass
class Tally:
    """What became of all drops so far.

    Attributes
    ----------
    drops, unsettled : int
    faults : list of str
        What must not be, with the body and the restitution where it was.
    lowest : float
        Least energy left above the height of the pose, in m g radius.
    closest : float
        Least energy that was missing to leave the pose, where the outcome was decided early.
    """

    drops: int = 0
    unsettled: int = 0
    faults: list[str] = field(default_factory=list)
    lowest: float = np.inf
    closest: float = np.inf

    @property
    def passed(self) -> bool:
        """Whether nothing was wrong and hardly a drop was given up."""
        return not self.faults and self.unsettled <= MOST_UNSETTLED * self.drops


def judge(task: Task, outcomes: DropOutcomes | Exception, tally: Tally) -> None:
    """Add outcomes to the tally."""
    tally.drops += task.drops
    where = f"{task.part.part_id} at {task.restitution}, seed {task.seed}"
    if isinstance(outcomes, Exception):
        tally.faults.append(f"{type(outcomes).__name__} in {where}: {outcomes}")
        return
    resting = resting_poses(task.part, 0.0)
    pose, left, radius = outcomes.pose, outcomes.energy_left, resting.body.radius
    tally.unsettled += int((pose < 0).sum())
    if not (np.isfinite(left).all() and np.isfinite(outcomes.seconds).all()):
        tally.faults.append(f"NaN in {where}")
    if pose.shape != (task.drops,) or pose.max() >= len(resting.poses) or pose.min() < -1:
        tally.faults.append(f"no stable pose in {where}")
        return
    height = np.array([p.height for p in resting.poses])[pose] / radius
    barrier = np.array([p.barrier for p in resting.poses])[pose] / radius
    above = (left - height)[pose >= 0].min(initial=np.inf)
    missing = (height + barrier - left)[(pose >= 0) & outcomes.trapped].min(initial=np.inf)
    tally.lowest, tally.closest = min(tally.lowest, above), min(tally.closest, missing)
    if not (above >= -ROUNDING and missing > 0.0):
        tally.faults.append(f"energy in {where}: {above:.1e} above the pose, "
                            f"{missing:.1e} missing to leave it")


def report(tally: Tally, seconds: float) -> str:
    """What was found, a line each."""
    lines = [f"{tally.drops} drops in {seconds:.1f} s, {tally.drops / seconds:.0f} a second",
             f"unsettled: {tally.unsettled}, at most {MOST_UNSETTLED:g} of them allowed",
             f"energy left above the pose's height: at least {tally.lowest:.2e} m g radius",
             f"energy missing to leave the pose: at least {tally.closest:.2e} m g radius",
             *(f"FAULT: {fault}" for fault in tally.faults),
             "passed" if tally.passed else "FAILED"]
    return "\n".join(lines)
