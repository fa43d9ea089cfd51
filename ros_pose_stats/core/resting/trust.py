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

"""What all answers for a part say of its poses."""

import math
from collections.abc import Iterator, Sequence
from weakref import WeakKeyDictionary

import numpy as np

from ...base import text
from .. import tolerances
from ..kernels.body.convex_body import BodyArrays
from ..mesh.arrays import mask_of
from ..mesh.vectors import lengths
from ..records import Array, Index, Mask, StablePose
from ..records.notes import Note, note
from . import convex_body, poses, rims

MOST_NAMED = 3  # most poses that a warning names; it counts the others


_NOTES: WeakKeyDictionary[poses.RestingPoses, tuple[Note, ...]] = WeakKeyDictionary()


def pose_notes(resting: poses.RestingPoses) -> tuple[Note, ...]:
    """Notes on a part's poses that hold for every method; made once."""
    if resting not in _NOTES:
        _NOTES[resting] = (
            *_coarse_notes(resting),
            *_marginal_notes(resting.poses),
            *_rounded_notes(resting.body),
            *_clustered_notes(resting),
            *_shallow_notes(resting.poses),
            *_near_tie_notes(resting),
        )
    return _NOTES[resting]


def _rounded_notes(body: convex_body.ConvexBody) -> Iterator[Note]:
    if not body.rounded:
        return
    sides = sorted({run.sides for run in body.runs if run.sides})
    yield note(
        "ROUNDED",
        f"{text.several(body.rounded, 'round edge')} of the hull "
        f"{'is taken as a polygon' if body.rounded == 1 else 'are taken as polygons'} "
        f"of {' or '.join(map(str, sides))} sides a turn, whatever the file has.",
    )


def _coarse_notes(resting: poses.RestingPoses) -> Iterator[Note]:
    """A polygon that rolls loses energy at every facet, more where they are few."""
    angle = curve_angle(resting)
    if not angle:
        return
    yield note(
        "COARSE_CURVE",
        "poses lie on a curve that is taken as the file has it, in facets that turn "
        f"by {math.degrees(angle):.2g} degrees each; with half as "
        f"large ones shares change by up to {tolerances.EXPORTS_DIFFER} points, and "
        "no size is the right one.",
    )


def curve_angle(resting: poses.RestingPoses) -> float:
    """Usual angle (radians) between facets, off all runs, of curves that poses lie on.

    0 for none. A facet of a curve turns little to two neighbours at least, and far to
    others. That on which the part lies is narrow.
    """
    body = resting.body
    arrays = body.arrays
    lies_off_runs = body.run_of_face[resting.faces] < 0
    # Most parts lie on no curve, and their other faces need no look.
    supports = resting.faces[lies_off_runs]
    sides = np.flatnonzero(mask_of(supports, body.faces)[arrays.face])
    turn = _turns(arrays, sides)
    is_curved, is_base = _facets(body, sides, turn, turn < tolerances.CURVED)
    if not (is_curved & is_base)[supports].any():
        return 0.0
    sides = np.arange(len(arrays.face))
    turn = _turns(arrays, sides)
    neighbour = arrays.face[arrays.twin]
    off_runs = ~np.logical_or.reduceat(
        _points_on_runs(body)[arrays.corner], arrays.face_start[:-1]
    )
    is_small = turn < tolerances.CURVED
    is_small &= off_runs[arrays.face] & off_runs[neighbour]
    is_curved, is_base = _facets(body, sides, turn, is_small)
    lies_on_curve = (is_curved & is_base)[resting.faces] & lies_off_runs
    is_curved &= lies_on_curve[resting.pose_of_face]
    if is_curved.sum() < tolerances.FEWEST_FACETS:
        return 0.0
    return float(np.median(turn[is_small & is_curved[arrays.face]]))


def _turns(arrays: BodyArrays, sides: Index) -> Array:
    """Angles (k,) between the faces on both sides of edges, radians."""
    normal = arrays.normal[arrays.face[sides]]
    beyond = arrays.normal[arrays.face[arrays.twin[sides]]]
    return np.asarray(2.0 * np.arcsin(0.5 * lengths(normal - beyond)))


def _facets(
    body: convex_body.ConvexBody, sides: Index, turn: Array, is_small: Mask
) -> tuple[Mask, Mask]:
    """Which faces (F,) are facets of curves, and on which a part may lie.

    By all sides of these faces: their turns, and which of them are small.
    """
    arrays = body.arrays
    face = arrays.face[sides]
    is_narrow = arrays.inset[sides] < tolerances.NARROW * turn * arrays.distance[face]
    is_curved = np.bincount(face[is_small], minlength=body.faces) > 1
    is_curved[face[(turn >= tolerances.CURVED) & (turn < tolerances.BENT)]] = False
    is_base = np.bincount(face[is_small & is_narrow], minlength=body.faces) > 1
    return is_curved, is_base


def _points_on_runs(body: convex_body.ConvexBody) -> Mask:
    """Which points of a body lie on the circle of a run."""
    on_run = np.zeros(len(body.points), dtype=np.bool_)
    for run in body.runs:
        squares = rims.square_distances(body.points, run)
        on_run |= squares < tolerances.ON_RUN * tolerances.ON_RUN
    return on_run


def _clustered_notes(resting: poses.RestingPoses) -> Iterator[Note]:
    merged_poses = [pose for pose in resting.poses if len(pose.members) > 1]
    if not merged_poses:
        return
    yield note(
        "CLUSTERED",
        f"{len(merged_poses)} of {len(resting.poses)} poses "
        f"{_inflect(merged_poses, 'gathers', 'gather')} several stable faces, parted "
        "by low barriers only, as on a curve or a slender bar; their probabilities "
        "are added.",
    )


def _marginal_notes(poses: Sequence[StablePose]) -> Iterator[Note]:
    marginal_poses = [pose for pose in poses if pose.margin < tolerances.MARGINAL_TILT]
    if not marginal_poses or len(poses) == 1:
        return
    smallest_tilt = math.degrees(min(pose.margin for pose in marginal_poses))
    verb = _inflect(marginal_poses, "topples", "topple")
    yield note(
        "MARGINAL_POSE",
        f"{_name_poses(marginal_poses)} {verb} at a tilt of the plate "
        f"of {smallest_tilt:.2g} degrees; a small change of shape or plate ends it, "
        "and estimators other than eae, meae and split jump there.",
    )


def _shallow_notes(poses: Sequence[StablePose]) -> Iterator[Note]:
    highest_barrier = max(
        (pose.barrier for pose in poses if math.isfinite(pose.barrier)), default=0.0
    )
    shallow_poses = [
        pose
        for pose in poses
        if pose.barrier < tolerances.SHALLOW_BARRIER * highest_barrier
    ]
    if not shallow_poses:
        return
    lowest_barrier = 1e3 * min(pose.barrier for pose in shallow_poses)
    yield note(
        "SHALLOW_POSE",
        f"{_name_poses(shallow_poses)} "
        f"{_inflect(shallow_poses, 'is', 'are')} left at a far smaller rise of the "
        f"centre of mass than others, the shallowest at {lowest_barrier:.2g} mm; a "
        f"vibrating feeder empties {_inflect(shallow_poses, 'it', 'them')}.",
    )


def _near_tie_notes(resting: poses.RestingPoses) -> Iterator[Note]:
    gap = _smallest_gap(resting)
    if not tolerances.EXACT_TIE < gap < tolerances.NEAR_TIE:
        return
    difference = 1e3 * gap * resting.body.radius
    yield note(
        "NEAR_TIE",
        f"two ways from pose to pose differ by {difference:.2g} mm in "
        "height only; which one opens first, and so where the part goes as it calms "
        "down, hangs on details of its shape.",
    )


def _smallest_gap(resting: poses.RestingPoses) -> float:
    """Smallest difference in level of a split and the next one below it, in radii."""
    tree = resting.equilibria.arrays.tree
    is_split = resting.clusters.split
    child_join = tree.child[is_split] - tree.level.shape[0] - 1
    split = np.maximum(child_join, 0)
    gaps = tree.level[is_split][:, None] - tree.level[split]
    # Exact ties come from symmetry and have no consequence.
    open_gaps = gaps[
        (child_join >= 0) & is_split[split] & (gaps > tolerances.EXACT_TIE)
    ]
    return float(open_gaps.min(initial=math.inf))


def _name_poses(poses: Sequence[StablePose]) -> str:
    names = ", ".join(str(pose.index) for pose in poses[:MOST_NAMED])
    others = len(poses) - MOST_NAMED
    return f"{_inflect(poses, 'pose', 'poses')} {names}" + (
        f" and {others} more" if others > 0 else ""
    )


def _inflect(poses: Sequence[StablePose], singular: str, plural: str) -> str:
    return singular if len(poses) == 1 else plural
