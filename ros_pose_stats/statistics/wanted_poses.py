"""Wanted poses of which symmetry has more alike: a feeder cannot tell them apart."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..records import PoseStatistics
from ..text import listed, name_poses
from .pose_groups import pose_groups


def warn_of_alike(found: PoseStatistics, wanted: Sequence[int]) -> tuple[str, ...]:
    """Warn where only some of the poses that look the same are wanted.

    `wanted`: indices of the poses that are accepted; none for no question. Returns one warning or
    none. Those named count all the same, and no others.
    """
    kept = set(map(int, wanted))
    groups = [group.indices for group in sorted(pose_groups(found), key=lambda one: one.indices)]
    split = [([one for one in group if one in kept], [one for one in group if one not in kept])
             for group in groups if 0 < len(kept.intersection(group)) < len(group)]
    if not split:
        return ()
    missing = [index for _, outside in split for index in outside]
    told = listed([f"{name_poses(outside)} look{'s' if len(outside) == 1 else ''} the same as "
                   f"{name_poses(inside)}" for inside, outside in split])
    are = "is" if len(missing) == 1 else "are"
    return (f"WANTED_ALIKE: {told} (symmetry) and {are} not among the wanted ones"
            f"{_shares(found, kept, kept.union(missing))}.",)


def _shares(found: PoseStatistics, kept: set[int], every: set[int]) -> str:
    """What is accepted without and with the others; nothing where no share is known."""
    now, then = (min(1.0, sum(pose.probability for pose in found.poses if pose.index in some))
                 for some in (kept, every))
    if math.isnan(now):
        return ""
    return f": {100.0 * now:.1f} % are accepted, with them {100.0 * then:.1f} %"
