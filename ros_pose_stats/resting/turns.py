"""How a part can be turned in a pose: by rolling, and about the vertical."""

import math
from collections.abc import Callable

import numpy as np

from ..kernels.body.standing import can_roll
from ..kernels.principal_axes import is_kept
from ..mesh.vectors import along, cross, length, lengths
from ..records import Array, Index, Mask, Part
from ..tolerances import SYMMETRY
from . import convex_body, equilibria, rims, symmetry

UPRIGHT = 0.985  # cosine of an axis' angle to the vertical above which a turn about it is no roll
LARGEST_STEP = np.radians(24.8)  # facets of a round surface turn by less
SAME_AXIS = 1e-3  # sine of the angle within which two axes are one
LEVEL = 1e-4  # sine of the angle to the axis within which a facet is along it
NEAR = 0.05  # share of its radius within which a facet is one of a round surface
LARGEST_FACET = 0.03 * 4.0 * np.pi  # solid angle from which on a face is no facet of a curve

LARGEST_BEND = 0.4
"""Angle to a neighbour, in radians, from which on both are no facets of one curve."""


def axis_offsets(body: convex_body.ConvexBody, pose_of_face: Index, poses: int) -> Array:
    """How far (P,) the centre of mass lies beside the axis of full cylinders poses rest on."""
    normal, distance = body.arrays.normal, body.arrays.distance
    found = np.zeros(poses)
    for run in body.runs:
        if run.kind != "round" or not run.full:
            continue
        mine = (body.run_of_face >= 0) & (np.abs(along(normal, run.axis)) < LEVEL)
        mine &= np.abs(distance - along(normal, run.center) - run.radius) < NEAR * run.radius
        beside = length(run.center - along(run.center[None], run.axis) * run.axis)
        np.maximum.at(found, pose_of_face[mine], beside)
    return found


def curved_faces(body: convex_body.ConvexBody) -> Array:
    """How far (F,) each face is a facet of a curve to rock on, from 0 to 1.

    Small faces beside others that hardly turn are; at rims of a full turn all of those must.
    """
    arrays = body.arrays
    step = arrays.normal[arrays.face] - arrays.normal[arrays.face[arrays.twin]]
    turn, first = (step * step).sum(axis=1), arrays.face_start[:-1]
    rolls = np.zeros(body.faces, dtype=np.bool_)
    for run in body.runs:
        if run.full:
            up = along(arrays.normal, run.axis)
            reach = np.sqrt(np.maximum(1.0 - up * up, 0.0)) * run.radius
            rolls |= np.abs(arrays.distance - along(arrays.normal, run.center)
                            - reach) < NEAR * run.radius
    bend = np.where(rolls, np.maximum.reduceat(turn, first), np.minimum.reduceat(turn, first))
    small = np.maximum(1.0 - np.square(arrays.angle / LARGEST_FACET), 0.0)
    return np.asarray(np.square(small * np.maximum(1.0 - bend / LARGEST_BEND**2, 0.0)))


def rolling_axes(body: convex_body.ConvexBody, downs: Array, heights: Array, tolerance: float
                 ) -> tuple[Mask, Array]:
    """Which poses roll: can be turned by 90 degrees about a run's axis and stay that low.

    `tolerance`: rise over the height that does not stop a roll. That axis too (P, 3), of either
    sign; zero where there is none, or several.
    """
    rolls = np.zeros(len(downs), dtype=np.bool_)
    axis = np.zeros((len(downs), 3))
    others = np.array([run.axis for run in body.runs])
    while len(others):
        candidate = others[0]
        others = others[lengths(cross(others, candidate)) > SAME_AXIS]
        for pose in np.flatnonzero(np.abs(along(downs, candidate)) < UPRIGHT).tolist():
            if can_roll(body.points, downs[pose], candidate, (1.0 + tolerance) * heights[pose]):
                axis[pose] = 0.0 if rolls[pose] else candidate
                rolls[pose] = True
    return rolls, axis


def yaw_symmetries(part: Part, found: equilibria.Equilibria, lowest: Index,
                   trial: Callable[[], symmetry.SurfaceTrial]) -> Index:
    """Turns about the vertical (P,) that leave the part in a pose as it is.

    n-fold; 1 for no symmetry, and in doubt; 0 for any angle, where all that is turned is round.
    """
    number = np.ones(len(lowest), dtype=np.int64)
    for pose, face in enumerate(lowest.tolist()):
        down = found.downs[face]
        if not is_kept(part.inertia, _turn_matrix(down, np.pi), SYMMETRY):
            continue  # whose axis would be a principal one
        runs = [run for run in found.body.runs if run.full
                and abs(float(along(down[None], run.axis)[0])) > 1.0 - SYMMETRY]
        number[pose] = _order(part, found, face, runs, trial)
    return number


def _order(part: Part, found: equilibria.Equilibria, face: int, runs: list[rims.Run],
           trial: Callable[[], symmetry.SurfaceTrial]) -> int:
    """Order of the symmetry about a stable face's normal."""
    arrays, number = found.body.arrays, int(found.faces[face])
    down = found.downs[face]
    corners = int(arrays.face_start[number + 1] - arrays.face_start[number])
    orders = {order for sides in {corners, *(run.corners for run in runs)}
              for order in range(2, sides + 1) if sides % order == 0}
    for order in sorted(orders, reverse=True):
        turn = _turn_matrix(down, 2.0 * np.pi / order)
        if not is_kept(part.inertia, turn, SYMMETRY):
            continue
        if trial().effort > symmetry.MOST_EFFORT:
            return 1
        if trial().holds(turn):
            turned = 2.0 * np.pi / order < LARGEST_STEP and all(
                run.kind == "round" for run in runs) and runs
            return 0 if turned else order
    return 1


def _turn_matrix(axis: Array, angle: float) -> Array:
    """Turn (3, 3) by an angle, radians, about a unit axis (Rodrigues)."""
    cos, sin = math.cos(angle), math.sin(angle)
    x, y, z = axis.tolist()
    a, b, c = (1.0 - cos) * x, (1.0 - cos) * y, (1.0 - cos) * z
    return np.array([(a * x + cos, a * y - sin * z, a * z + sin * y),
                     (b * x + sin * z, b * y + cos, b * z - sin * x),
                     (c * x - sin * y, c * y + sin * x, c * z + cos)])
