"""Which pose a resting body is on its way to, and whether it can still leave it.

With less mechanical energy than the lowest saddle out of the present basin of R the outcome
of a drop is decided (section 4.D's reachable sets, taken one drop at a time).
"""

from __future__ import annotations

import math

from ..compilation import inlined
from .layout import Array, DropBody, P, V, W, Z


@inlined
def energy(state: Array, moment: Array) -> float:
    """Mechanical energy z + v²/2 + w . I w / 2, the plate at 0."""
    return float(state[Z] + 0.5 * state[V] * state[V]
                 + 0.5 * (moment[0] * state[W] * state[W] + moment[1] * state[W + 1] * state[W + 1]
                          + moment[2] * state[W + 2] * state[W + 2]))


@inlined
def pose_below(body: DropBody, up: tuple[float, float, float], corner: int) -> int:
    """Pose that a descent in R(u) from u = -up ends in.

    Parameters
    ----------
    corner : int
        The lowest one, so that R(u) = u . r around here.

    Notes
    -----
    Going straight away from r, the direction u - s r leaves the corner's normal cone through
    the side for which s = (u . e) / (r . e) is smallest, among those with r . e < 0. On the
    arc between the normals of the two faces there, R falls away from the foot of the edge,
    to the right-hand face where e . (r x u) > 0. R falls all the way, so no saddle is passed,
    and a body flat on a face is told right whatever rounding does.
    """
    ux, uy, uz = -up[0], -up[1], -up[2]
    rx, ry, rz = body.x[corner], body.y[corner], body.z[corner]
    nearest = math.inf
    pose = -1
    for k in range(body.side_start[corner], body.side_start[corner + 1]):
        j = body.side_end[k]
        ex, ey, ez = body.x[j] - rx, body.y[j] - ry, body.z[j] - rz
        fall = rx * ex + ry * ey + rz * ez
        if fall >= 0.0:
            continue
        s = (ux * ex + uy * ey + uz * ez) / fall
        if s < nearest:
            nearest = s
            right = (ex * (ry * uz - rz * uy) + ey * (rz * ux - rx * uz)
                     + ez * (rx * uy - ry * ux))
            pose = body.side_right[k] if right > 0.0 else body.side_left[k]
    return int(pose)


@inlined
def up_of(state: Array) -> tuple[float, float, float]:
    """The vertical direction of a state."""
    return state[P], state[P + 1], state[P + 2]
