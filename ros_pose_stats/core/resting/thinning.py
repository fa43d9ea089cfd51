"""Fewer corners for bodies whose free form is finer than what they roll on."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..kernels import elementary, principal_axes
from ..kernels.body import convex_body, hull
from ..mesh.vectors import lengths, scatter
from ..records import Array, Mask
from .rims import Group, Outline, Rim

FINE = 1000  # corners off all runs up to which a body stays as the file has it: it is quick enough
GRID = 7
"""Directions a turn for every five sides: so that the deepest corner left out is no deeper."""

SHARP = (
    1.25  # turns of a polygon of so many sides, from which on an outline has a corner
)

TIE = 1e-7
"""Corners this close to the farthest, in radii, are as far: the other end of a straight edge."""


def thin_out(outline: Outline, arrays: convex_body.BodyArrays, sides: int) -> None:
    """Leave out corners off all reshaped runs of a body that has very many, in place.

    What stays lies farthest out in one of many directions, as far apart as those of a polygon of
    `sides` or fewer, mirrored at the principal planes, so that a symmetric body stays so.
    """
    taken = np.zeros(len(outline.points), dtype=np.bool_)
    for chain in outline.chains:
        if chain.sides or chain.rim.kind == "toothed":
            taken[chain.point[chain.point < len(taken)]] = True
    free = outline.keeps & ~taken
    if free.sum() <= FINE:
        return
    others = outline.count - len(outline.points) + int((outline.keeps & taken).sum())
    # Neighbours of each corner over the edges: where they begin, and their numbers.
    first = np.append(
        0, np.cumsum(np.bincount(arrays.corner, minlength=len(outline.points)))
    )
    beside = arrays.corner[arrays.twin[np.argsort(arrays.corner, kind="stable")]]
    moments = scatter(outline.points[arrays.corner])
    axes = np.ascontiguousarray(principal_axes.principal_axes(moments)[1].T)
    poles = axes
    for twelfths in range(12, 3, -1):
        level = sides * twelfths // 12
        if level < COARSEST and twelfths < 12:
            break
        grid = GRID * level // 5
        if twelfths == 12:
            # Over a rim about the poles there are the fewest directions: a prism's axis is there.
            turned = [np.roll(axes, turn, axis=0) for turn in range(3)]
            found = [
                hull.outermost_corners(outline.points, first, beside, one, grid, TIE)
                for one in turned
            ]
            counts = [int((one & free).sum()) for one in found]
            best = counts.index(min(counts))
            poles = turned[best]
            chosen = found[best]
        else:
            chosen = hull.outermost_corners(
                outline.points, first, beside, poles, grid, TIE
            )
        chosen |= _corners_of_flats(outline.points, arrays, 2.0 * np.pi / level)
        if (chosen & free).sum() + others <= ENOUGH:
            break
    outline.changed |= bool((free & ~chosen).any())
    outline.keeps &= chosen | taken


def _corners_of_flats(
    points: Array, arrays: convex_body.BodyArrays, step: float
) -> Mask:
    """Where the outline of a face turns that is wider than a facet of the free form.

    Few directions have such a corner farthest out, and without it the face would be another one.
    """
    longest = np.maximum.reduceat(arrays.start + arrays.stop, arrays.face_start[:-1])
    edge = points[arrays.corner[arrays.next_side]] - points[arrays.corner]
    edge /= lengths(edge)[:, None]
    turns = lengths(edge[arrays.next_side] - edge) > SHARP * step
    found = np.zeros(len(points), dtype=np.bool_)
    found[
        arrays.corner[
            arrays.next_side[turns & (arrays.area > step * longest)[arrays.face]]
        ]
    ] = True
    return found


ENOUGH = 4000  # corners of a body that thinning aims at
COARSEST = 64  # fewest sides a turn that rims and free forms are thinned to for that

FEWEST_ALONG = 32
"""Fewest sides a turn along the profile of a dome: with so few it still comes to rest alike."""

FEWEST_FREE = 1600  # corners off all rims that thinning leaves of a free form, about


@dataclass(eq=False)
class Whole:
    """A full rim without a corner that must stay, in the frame of its group."""

    rim: Rim
    group: Group
    height: float
    rolls: bool = False
    sides: int = 0


def plan_sides(wholes: list[Whole], corners: int, sides: int) -> None:
    """Give each full rim its number of sides, 0 for one that the height of arc does not need.

    Where there are too many corners there are fewer rims along a dome, for how fine it is that way
    hardly matters; in the end rims that the body does not roll on get fewer sides.
    """
    free = corners - sum(len(one.rim.corner) for one in wholes)
    groups: dict[int, list[Whole]] = {id(one.group): [] for one in wholes}
    for one in wholes:
        groups[id(one.group)].append(one)
    profiles = [sides * share // 12 for share in (12, 8, 6, 4, 3, 2)]
    plans = [
        (sides, level) for level in profiles if level >= FEWEST_ALONG or level == sides
    ]
    plans += [
        (sides // k, max(COARSEST, sides // k))
        for k in (2, 3)
        if sides % k == 0 and sides // k >= COARSEST
    ]
    for rest, level in plans:
        # The height of the arc over one side of a polygon of radius 1.
        tolerance = 1.0 - float(
            elementary.sines_cosines(np.array([np.pi / level]))[1][0]
        )
        for group in groups.values():
            _plan_profile(group, tolerance)
        for one in wholes:
            if one.sides:
                one.sides = sides if one.rolls else rest
        if sum(one.sides for one in wholes) <= ENOUGH - min(free, FEWEST_FREE):
            return


def _plan_profile(wholes: list[Whole], tolerance: float) -> None:
    """Mark the rims of one axis to be kept: `sides` is 1 for them, else 0."""
    wholes.sort(key=lambda one: one.height)
    center = wholes[0].group.center
    axis = wholes[0].group.frame[2]
    middle = -float((center * axis).sum())
    profile = np.array([(one.height - middle, one.rim.radius) for one in wholes])
    step = np.diff(profile, axis=0)
    # The foot of the centre of mass lies on a facet that the body can roll on.
    rolls = ((profile[:-1] * step).sum(axis=1) < 0.0) & (
        (profile[1:] * step).sum(axis=1) > 0.0
    )
    fixed = np.zeros(len(wholes), dtype=np.bool_)
    fixed[0] = fixed[-1] = True
    for k, one in enumerate(wholes):
        one.rolls = bool(rolls[max(k - 1, 0) : k + 1].any())
        fixed[k] |= one.rolls
        one.sides = int(fixed[k])
    waiting = list(pairwise(np.flatnonzero(fixed).tolist()))
    while waiting:
        low, high = waiting.pop()
        if high - low < 2:
            continue
        chord = profile[high] - profile[low]
        away = profile[low + 1 : high] - profile[low]
        beyond = np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0])
        beyond /= np.sqrt((chord * chord).sum())
        if beyond.max() <= tolerance:
            continue
        ties = np.flatnonzero(beyond >= beyond.max() - 1e-9)
        far = low + 1 + int(ties[int(profile[low + 1 + ties, 1].argmax())])
        wholes[far].sides = 1
        waiting += [(low, far), (far, high)]
