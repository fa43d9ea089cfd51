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

"""Fewer corners for bodies whose free form is finer than what they roll on."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..kernels import elementary, principal_axes
from ..kernels.body import convex_body, hull
from ..mesh.arrays import mask_of
from ..mesh.vectors import lengths, scatter
from ..records import Array, Mask
from .rims import Group, Outline, Rim

# Corners off all runs up to which a body stays as the file has it: it is quick enough
FINE = 1000
GRID = 7
"""Directions a turn for every five sides: so that the deepest corner left out is no
deeper."""

# Turns of a polygon of so many sides, from which on an outline has a corner.
SHARP = 1.25

TIE = 1e-7
"""Corners this close to the farthest, in radii, are as far: the other end of a straight
edge."""


def thin_out(outline: Outline, arrays: convex_body.BodyArrays, sides: int) -> None:
    """Leave out corners off all reshaped runs of a body that has very many, in place.

    What stays lies farthest out in one of many directions, as far apart as those of a
    polygon of `sides` or fewer, mirrored at the principal planes, so that a symmetric
    body stays so.
    """
    on_rim = np.zeros(len(outline.points), dtype=np.bool_)
    for chain in outline.chains:
        if chain.sides or chain.rim.kind == "toothed":
            on_rim[chain.point[chain.point < len(on_rim)]] = True
    is_free = outline.keeps & ~on_rim
    if is_free.sum() <= FINE:
        return
    other_corners = (
        outline.count - len(outline.points) + int((outline.keeps & on_rim).sum())
    )
    # Neighbours of each corner over the edges: where they begin, and their numbers.
    first = np.append(
        0, np.cumsum(np.bincount(arrays.corner, minlength=len(outline.points)))
    )
    neighbours = arrays.corner[arrays.twin[np.argsort(arrays.corner, kind="stable")]]
    moments = scatter(outline.points[arrays.corner])
    axes = np.ascontiguousarray(principal_axes.principal_axes(moments)[1].T)
    poles = axes
    for twelfths in range(12, 3, -1):
        level = sides * twelfths // 12
        if level < COARSEST and twelfths < 12:
            break
        grid = GRID * level // 5
        if twelfths == 12:
            # Over a rim about the poles there are the fewest directions: a prism's axis
            # is there.
            frames = [np.roll(axes, turn, axis=0) for turn in range(3)]
            selections = [
                hull.outermost_corners(
                    outline.points, first, neighbours, frame, grid, TIE
                )
                for frame in frames
            ]
            counts = [int((selection & is_free).sum()) for selection in selections]
            fewest = counts.index(min(counts))
            poles = frames[fewest]
            is_chosen = selections[fewest]
        else:
            is_chosen = hull.outermost_corners(
                outline.points, first, neighbours, poles, grid, TIE
            )
        is_chosen |= _corners_of_flats(outline.points, arrays, 2.0 * np.pi / level)
        if (is_chosen & is_free).sum() + other_corners <= ENOUGH:
            break
    outline.changed |= bool((is_free & ~is_chosen).any())
    outline.keeps &= is_chosen | on_rim


def _corners_of_flats(
    points: Array, arrays: convex_body.BodyArrays, step: float
) -> Mask:
    """Where the outline of a face turns that is wider than a facet of the free form.

    Few directions have such a corner farthest out, and without it the face would be
    another one.
    """
    face_width = np.maximum.reduceat(arrays.start + arrays.stop, arrays.face_start[:-1])
    edge = points[arrays.corner[arrays.next_side]] - points[arrays.corner]
    edge /= lengths(edge)[:, None]
    turns = lengths(edge[arrays.next_side] - edge) > SHARP * step
    is_wide = arrays.area > step * face_width
    turning_sides = arrays.next_side[turns & is_wide[arrays.face]]
    return mask_of(arrays.corner[turning_sides], len(points))


ENOUGH = 4000  # corners of a body that thinning aims at
COARSEST = 64  # fewest sides a turn that rims and free forms are thinned to for that

FEWEST_ALONG = 32
"""Fewest sides a turn along the profile of a dome: with so few it still comes to rest
alike."""

FEWEST_FREE = 1600  # corners off all rims that thinning leaves of a free form, about


@dataclass(eq=False)
class FullRim:
    """A full rim without a corner that must stay, in the frame of its group."""

    rim: Rim
    group: Group
    height: float
    rolls: bool = False
    sides: int = 0


def plan_sides(full_rims: list[FullRim], corners: int, sides: int) -> None:
    """Give each full rim its number of sides, 0 for one that can be left out.

    Where there are too many corners there are fewer rims along a dome, for how fine it
    is that way hardly matters; in the end rims that the body does not roll on get fewer
    sides.
    """
    free_corners = corners - sum(len(full_rim.rim.corner) for full_rim in full_rims)
    groups: dict[int, list[FullRim]] = {}
    for full_rim in full_rims:
        groups.setdefault(id(full_rim.group), []).append(full_rim)
    profiles = [sides * share // 12 for share in (12, 8, 6, 4, 3, 2)]
    plans = [
        (sides, level) for level in profiles if level >= FEWEST_ALONG or level == sides
    ]
    plans += [
        (sides // k, max(COARSEST, sides // k))
        for k in (2, 3)
        if sides % k == 0 and sides // k >= COARSEST
    ]
    for other_sides, level in plans:
        # The height of the arc over one side of a polygon of radius 1.
        tolerance = 1.0 - float(
            elementary.sines_cosines(np.array([np.pi / level]))[1][0]
        )
        for group in groups.values():
            _plan_profile(group, tolerance)
        for full_rim in full_rims:
            if full_rim.sides:
                full_rim.sides = sides if full_rim.rolls else other_sides
        if sum(full_rim.sides for full_rim in full_rims) <= ENOUGH - min(
            free_corners, FEWEST_FREE
        ):
            return


def _plan_profile(full_rims: list[FullRim], tolerance: float) -> None:
    """Mark the rims of one axis to be kept: `sides` is 1 for them, else 0."""
    full_rims.sort(key=lambda full_rim: full_rim.height)
    center = full_rims[0].group.center
    axis = full_rims[0].group.frame[2]
    middle = -float((center * axis).sum())
    profile = np.array(
        [(full_rim.height - middle, full_rim.rim.radius) for full_rim in full_rims]
    )
    step = np.diff(profile, axis=0)
    # The foot of the centre of mass lies on a facet that the body can roll on.
    can_roll = ((profile[:-1] * step).sum(axis=1) < 0.0) & (
        (profile[1:] * step).sum(axis=1) > 0.0
    )
    is_fixed = np.zeros(len(full_rims), dtype=np.bool_)
    is_fixed[0] = is_fixed[-1] = True
    for k, full_rim in enumerate(full_rims):
        full_rim.rolls = bool(can_roll[max(k - 1, 0) : k + 1].any())
        is_fixed[k] |= full_rim.rolls
        full_rim.sides = int(is_fixed[k])
    stretches = list(pairwise(np.flatnonzero(is_fixed).tolist()))
    while stretches:
        low, high = stretches.pop()
        if high - low < 2:
            continue
        chord = profile[high] - profile[low]
        offset = profile[low + 1 : high] - profile[low]
        arc_height = np.abs(offset[:, 0] * chord[1] - offset[:, 1] * chord[0])
        arc_height /= np.sqrt((chord * chord).sum())
        if arc_height.max() <= tolerance:
            continue
        ties = np.flatnonzero(arc_height >= arc_height.max() - 1e-9)
        farthest = low + 1 + int(ties[int(profile[low + 1 + ties, 1].argmax())])
        full_rims[farthest].sides = 1
        stretches += [(low, farthest), (farthest, high)]
