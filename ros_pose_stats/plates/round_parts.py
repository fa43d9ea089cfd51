"""Round parts on a plate, which lose energy there as polygons of some number of sides do."""

from collections.abc import Sequence
from dataclasses import replace

from ..records.scene import DEFAULT_ROUND_SIDES
from ..resting.poses import resting_poses
from .counts import CountedPart

SIDES = (DEFAULT_ROUND_SIDES, 96, 384, 48)
"""Sides a turn that are looked at; of those as likely the first is taken."""

UNTOLD_SIDES = DEFAULT_ROUND_SIDES, min(SIDES), max(SIDES)
"""What counts without round parts say: nothing is excluded."""

FITTED = 3
"""Numbers that the counts must tell where the sides are fitted too."""


def stand_on_sides(told: Sequence[CountedPart]) -> dict[int, list[CountedPart]]:
    """All counted parts as they stand with each number of sides that is to be looked at.

    Parts that are not round are the same with each. One number is left, and all parts stand as
    they were counted, where none is round or the counts tell too little.
    """
    is_round = [rolls_about(one) for one in told]
    if not any(is_round) or sum(one.free_shares for one in told) < FITTED:
        return {DEFAULT_ROUND_SIDES: list(told)}
    return {sides: [replace(one, round_sides=sides) if rolls else one
                    for one, rolls in zip(told, is_round, strict=True)] for sides in SIDES}


def rolls_about(one: CountedPart) -> bool:
    """Whether a part rolls on a full round surface, its poses numbered alike for all sides.

    The counts are by these numbers, so a part whose poses change with the sides cannot tell them.
    """
    own = one.resting
    if not any(pose.rolls for pose in own.poses):
        return False
    standing = [resting_poses(one.part, one.cluster_tolerance, sides) for sides in SIDES]
    return (any(run.full and run.kind == "round" for run in standing[0].body.runs)
            and all(own.is_numbered_like(other) for other in standing))
