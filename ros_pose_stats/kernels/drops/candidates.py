"""Corners that may touch the plate during a step; the others cost next to nothing.

Over a step the height of a point r is z + p . r with z and p given by their series. With B
the sum of the sizes of the higher coefficients it lies above a parabola that opens
downwards, so above the lower of its ends. Taken at the centre of a ball, less its radius, the same
bound clears all corners in the ball at once.
"""

from __future__ import annotations

import math

from ..compilation import inlined
from .layout import PS, ZS, Array, DropBody, Index


@inlined
def gather(body: DropBody, series: Array, last: int, margin: float, found: Index) -> int:
    """List the corners that may come closer to the plate than `margin`; return their number."""
    p0, p1, p2 = series[0, PS], series[0, PS + 1], series[0, PS + 2]
    q0, q1, q2 = series[1, PS], series[1, PS + 1], series[1, PS + 2]
    bend_p, bend_z = 0.0, 0.0
    for k in range(2, last + 1):
        bend_p += math.sqrt(series[k, PS] ** 2 + series[k, PS + 1] ** 2 + series[k, PS + 2] ** 2)
        bend_z += abs(series[k, ZS])
    start = series[0, ZS]
    rise = series[1, ZS] - bend_z
    count = 0
    node = 0
    nodes = body.ball.shape[0]
    while node < nodes:
        cx, cy, cz = body.ball[node, 0], body.ball[node, 1], body.ball[node, 2]
        begin = start + p0 * cx + p1 * cy + p2 * cz
        end = begin + rise + q0 * cx + q1 * cy + q2 * cz - bend_p * body.ball[node, 4]
        if min(begin, end) - body.ball[node, 3] > margin:
            node = body.ball_range[node, 2]
            continue
        if body.ball_range[node, 2] == node + 1:
            for j in range(body.ball_range[node, 0], body.ball_range[node, 1]):
                rx, ry, rz = body.x[j], body.y[j], body.z[j]
                begin = start + p0 * rx + p1 * ry + p2 * rz
                end = begin + rise + q0 * rx + q1 * ry + q2 * rz - bend_p * body.reach[j]
                if min(begin, end) <= margin:
                    found[count] = j
                    count += 1
        node += 1
    return count


@inlined
def height_series(body: DropBody, series: Array, last: int, j: int, c: Array) -> None:
    """Power series of the height of a corner."""
    rx, ry, rz = body.x[j], body.y[j], body.z[j]
    for k in range(last + 1):
        c[k] = (series[k, ZS] + series[k, PS] * rx + series[k, PS + 1] * ry
                + series[k, PS + 2] * rz)
