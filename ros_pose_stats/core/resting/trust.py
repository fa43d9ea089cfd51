"""What all answers for a part carry: warnings that ask a person to act, and notes that do not."""

import math
from collections.abc import Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ...base import text
from .. import tolerances
from ..mesh.vectors import lengths
from ..records import Mask, StablePose
from . import convex_body, poses

MOST_NAMED = 3  # most poses that a warning names; it counts the others


class Remarks(NamedTuple):
    """Each `CODE: sentence`; none where nothing is peculiar."""

    warnings: tuple[str, ...]
    notes: tuple[str, ...]


_REMARKS: WeakKeyDictionary[poses.RestingPoses, Remarks] = WeakKeyDictionary()


def pose_remarks(resting: poses.RestingPoses) -> Remarks:
    """Remarks on a part's poses that hold for every method; made once."""
    if resting not in _REMARKS:
        warnings = (_coarse(resting), _marginal(resting.poses))
        notes = (
            _rounded(resting.body),
            _clustered(resting),
            _shallow(resting.poses),
            _near_tie(resting),
        )
        _REMARKS[resting] = Remarks(
            tuple(filter(None, warnings)), tuple(filter(None, notes))
        )
    return _REMARKS[resting]


def _rounded(body: convex_body.ConvexBody) -> str:
    if not body.rounded:
        return ""
    sides = sorted({run.sides for run in body.runs if run.sides})
    return (
        f"ROUNDED: {text.several(body.rounded, 'round edge')} of the hull "
        f"{'is taken as a polygon' if body.rounded == 1 else 'are taken as polygons'} of "
        f"{' or '.join(map(str, sides))} sides a turn, whatever the file has."
    )


def _coarse(resting: poses.RestingPoses) -> str:
    """A polygon that rolls loses energy at every facet, and the more the fewer there are."""
    angle = curve_angle(resting)
    if not angle:
        return ""
    return (
        f"COARSE_CURVE: poses lie on a curve that is taken as the file has it, in facets that "
        f"turn by {math.degrees(angle):.2g} degrees each; with half as large ones shares "
        f"change by up to {tolerances.EXPORTS_DIFFER} points, and no size is the right one."
    )


def curve_angle(resting: poses.RestingPoses) -> float:
    """Usual angle (radians) between facets, off all runs, of curves that poses lie on; else 0.

    A facet of a curve turns little to two neighbours at least, and far to others. That on which
    the part lies is narrow.
    """
    found = resting.equilibria
    body = resting.body
    arrays = resting.body.arrays
    there = arrays.face[arrays.twin]
    turn = 2.0 * np.arcsin(
        0.5 * lengths(arrays.normal[arrays.face] - arrays.normal[there])
    )
    small = turn < tolerances.CURVED
    narrow = arrays.inset < tolerances.NARROW * turn * arrays.distance[arrays.face]
    bent = arrays.face[~small & (turn < tolerances.BENT)]
    lowest = found.faces[resting.clusters.lowest]
    stays = np.array([not one.rolls for one in resting.poses])

    def facets() -> tuple[Mask, Mask]:
        """Which faces are facets of curves, and which poses lie on one."""
        curved = np.bincount(arrays.face[small], minlength=body.faces) > 1
        curved[bent] = False
        lies = np.bincount(arrays.face[small & narrow], minlength=body.faces) > 1
        return curved, (lies & curved)[lowest] & stays

    if not facets()[1].any():
        return 0.0
    on_run = np.zeros(len(body.points), dtype=np.bool_)
    for run in body.runs:
        away = body.points - run.center
        above = (away * run.axis).sum(axis=1)
        off = lengths(away - above[:, None] * run.axis) - run.radius
        on_run |= above * above + off * off < tolerances.ON_RUN * tolerances.ON_RUN
    as_given = ~np.logical_or.reduceat(on_run[arrays.corner], arrays.face_start[:-1])
    small &= as_given[arrays.face] & as_given[there]
    curved, lies = facets()
    curved &= lies[resting.pose_of_face]
    if curved.sum() < tolerances.FEWEST_FACETS:
        return 0.0
    return float(np.median(turn[small & curved[arrays.face]]))


def _clustered(resting: poses.RestingPoses) -> str:
    merged = [pose for pose in resting.poses if len(pose.members) > 1]
    if not merged:
        return ""
    return (
        f"CLUSTERED: {len(merged)} of {len(resting.poses)} poses "
        f"{_verb(merged, 'gathers', 'gather')} several stable faces, parted by low barriers "
        f"only, as on a curve or a slender bar; their probabilities are added."
    )


def _marginal(poses: Sequence[StablePose]) -> str:
    found = [pose for pose in poses if pose.margin < tolerances.MARGINAL_TILT]
    if not found or len(poses) == 1:
        return ""
    least = math.degrees(min(pose.margin for pose in found))
    return (
        f"MARGINAL_POSE: {_named(found)} {_verb(found, 'topples', 'topple')} at a tilt of the "
        f"plate of {least:.2g} degrees; a small change of shape or plate ends it, and "
        f"estimators other than eae, meae and split jump there."
    )


def _shallow(poses: Sequence[StablePose]) -> str:
    deepest = max(
        (pose.barrier for pose in poses if math.isfinite(pose.barrier)), default=0.0
    )
    found = [
        pose for pose in poses if pose.barrier < tolerances.SHALLOW_BARRIER * deepest
    ]
    if not found:
        return ""
    least = 1e3 * min(pose.barrier for pose in found)
    return (
        f"SHALLOW_POSE: {_named(found)} {_verb(found, 'is', 'are')} left at a far smaller "
        f"rise of the centre of mass than others, the shallowest at {least:.2g} mm; a "
        f"vibrating feeder empties {_verb(found, 'it', 'them')}."
    )


def _near_tie(resting: poses.RestingPoses) -> str:
    gap = _smallest_gap(resting)
    if not tolerances.EXACT_TIE < gap < tolerances.NEAR_TIE:
        return ""
    apart = 1e3 * gap * resting.body.radius
    return (
        f"NEAR_TIE: two ways from pose to pose differ by {apart:.2g} mm in height only; which "
        f"one opens first, and so where the part goes as it calms down, hangs on details of "
        f"its shape."
    )


def _smallest_gap(resting: poses.RestingPoses) -> float:
    """Smallest difference in level of a split and the next one below it, in radii."""
    tree = resting.equilibria.arrays.tree
    wanted = resting.clusters.split
    below = tree.child[wanted] - tree.level.shape[0] - 1
    split = np.maximum(below, 0)
    gaps = tree.level[wanted][:, None] - tree.level[split]
    # Exact ties come from symmetry and have no consequence.
    open_gaps = gaps[(below >= 0) & wanted[split] & (gaps > tolerances.EXACT_TIE)]
    return float(open_gaps.min(initial=math.inf))


def _named(poses: Sequence[StablePose]) -> str:
    names = ", ".join(str(pose.index) for pose in poses[:MOST_NAMED])
    more = len(poses) - MOST_NAMED
    return f"{_verb(poses, 'pose', 'poses')} {names}" + (
        f" and {more} more" if more > 0 else ""
    )


def _verb(poses: Sequence[StablePose], one: str, many: str) -> str:
    return one if len(poses) == 1 else many
