"""Warnings about a part whose poses are close to a change, which all of its answers carry."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..records import StablePose
from ..tolerances import (
    COARSE_FACETS,
    EXACT_TIE,
    FEWEST_FACETS,
    MARGINAL_TILT,
    NEAR_TIE,
    SHALLOW_BARRIER,
)
from .poses import RestingPoses

MOST_NAMED = 3
"""Most poses that a warning names; it counts the others."""


def pose_warnings(resting: RestingPoses) -> list[str]:
    """Warnings about a part's poses that hold for every method.

    Parameters
    ----------
    resting : RestingPoses

    Returns
    -------
    list of str
        `CODE: sentence`, none where nothing is near a change.
    """
    found = (_clustered(resting), _marginal(resting.poses), _shallow(resting.poses),
             _near_tie(resting))
    return [one for one in found if one]


def drop_warnings(resting: RestingPoses) -> list[str]:
    """Warnings that hold for drops alone.

    A polygon that rolls loses energy at every facet, a round part does not. So with few facets far
    too many drops end on the curve; see the cylinder in `docs/study/stability.md`.
    """
    angles = [math.degrees(angle) for angle in _facet_angles(resting)
              if angle > COARSE_FACETS]
    if not angles:
        return []
    return [f"COARSE_CURVE: facets of {max(angles):.2g} degrees stand in for a curve; rolling "
            f"loses energy at each, so poses on the curve come out too probable; export the part "
            f"with facets of at most {math.degrees(COARSE_FACETS):.2g} degrees."]


def _clustered(resting: RestingPoses) -> str:
    merged = sum(len(pose.members) > 1 for pose in resting.poses)
    if not merged:
        return ""
    return (f"CLUSTERED: {merged} of {len(resting.poses)} poses gather several stable faces, "
            f"parted by low barriers only, as on a curve or a slender bar; their probabilities "
            f"are added.")


def _marginal(poses: Sequence[StablePose]) -> str:
    found = [pose for pose in poses if pose.margin < MARGINAL_TILT]
    if not found or len(poses) == 1:
        return ""
    least = math.degrees(min(pose.margin for pose in found))
    return (f"MARGINAL_POSE: {_named(found)} {_verb(found, 'topples', 'topple')} at a tilt of the "
            f"plate of {least:.2g} degrees; a small change of shape or plate ends it, and "
            f"estimators other than eae, meae and split jump there.")


def _shallow(poses: Sequence[StablePose]) -> str:
    deepest = max((pose.barrier for pose in poses if math.isfinite(pose.barrier)), default=0.0)
    found = [pose for pose in poses if pose.barrier < SHALLOW_BARRIER * deepest]
    if not found:
        return ""
    least = 1e3 * min(pose.barrier for pose in found)
    return (f"SHALLOW_POSE: {_named(found)} {_verb(found, 'is', 'are')} left at a far smaller "
            f"rise of the centre of mass than others, the shallowest at {least:.2g} mm; a "
            f"vibrating feeder empties {_verb(found, 'it', 'them')}.")


def _near_tie(resting: RestingPoses) -> str:
    gap = _smallest_gap(resting)
    if not EXACT_TIE < gap < NEAR_TIE:
        return ""
    apart = 1e3 * gap * resting.body.radius
    return (f"NEAR_TIE: two ways from pose to pose differ by {apart:.2g} mm in height only; which "
            f"one opens first, and so where the part goes as it calms down, hangs on details of "
            f"its shape.")


def _smallest_gap(resting: RestingPoses) -> float:
    """Smallest difference in level of a split and the next one below it, in radii."""
    tree, wanted = resting.equilibria.arrays.tree, resting.clusters.split
    below = tree.child[wanted] - tree.level.shape[0] - 1
    split = np.maximum(below, 0)
    gaps = tree.level[wanted][:, None] - tree.level[split]
    # Exact ties come from symmetry and have no consequence.
    open_gaps = gaps[(below >= 0) & wanted[split] & (gaps > EXACT_TIE)]
    return float(open_gaps.min(initial=math.inf))


def _facet_angles(resting: RestingPoses) -> list[float]:
    """Typical angle between neighbouring facets of each pose that gathers many, radians."""
    downs = resting.equilibria.downs
    pose = resting.clusters.pose
    found = []
    for number in np.flatnonzero(np.bincount(pose) >= FEWEST_FACETS).tolist():
        found.append(_spacing(downs[pose == number]))
    return found


def _spacing(downs: NDArray[np.float64]) -> float:
    """Median distance to the nearest other direction."""
    return float(np.median(cKDTree(downs).query(downs, 2)[0][:, 1]))


def _named(poses: Sequence[StablePose]) -> str:
    names = ", ".join(str(pose.index) for pose in poses[:MOST_NAMED])
    more = len(poses) - MOST_NAMED
    return f"{_verb(poses, 'pose', 'poses')} {names}" + (f" and {more} more" if more > 0 else "")


def _verb(poses: Sequence[StablePose], one: str, many: str) -> str:
    return one if len(poses) == 1 else many
