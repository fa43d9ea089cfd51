"""Power series of sliding on one vertex or on an edge (Eqs. 12, 13 and 16).

The forces keep the contact at its height. With a = r x p, the reach of the force N at r, and
for an edge of direction e, c = e x p, the reach of a pure moment T along it,

    I w' = (I w) x w + N a + T c,        v' = -1 + N,
    h'' = v' + ((p x w) x w) . r + w' . a = 0,    ((p x w) x w) . e + w' . c = 0.

(The sign of the moment in Eq. 13 as printed is wrong.) Taking the edge as (r, e) rather
than as two vertices keeps the equations apart on a short edge. T is the force on the far
vertex times the length. All forces are multiplied by the step squared.
"""

from __future__ import annotations

import numpy as np

from ..compilation import inlined
from .free_motion import begin_series
from .layout import FORCE, ORDER, PS, TORQUE, WS, ZS, Array

# Further columns: a, c, I^-1 a, I^-1 c, I^-1 (I w) x w, p.w, w.w and the two sides' products
A, C, IA, IC, G = 9, 12, 15, 18, 21
PW, WW, M11, M12, M22 = 24, 25, 26, 27, 28


@inlined
def sliding_series(state: Array, moment: Array, contact: Array, edge: bool, step: float,
                   truncation: float, series: Array) -> int:
    """Fill the series of a sliding phase; return its last row.

    Parameters
    ----------
    state, moment, series
        See `layout`.
    contact : (7,) array
        Vertex r, then direction e of the edge and its length.
    edge : bool
        Sliding on the edge rather than on the vertex alone.
    """
    begin_series(state, step, series)
    rx, ry, rz = contact[0], contact[1], contact[2]
    ex, ey, ez = contact[3], contact[4], contact[5]
    i0, i1, i2 = 1.0 / moment[0], 1.0 / moment[1], 1.0 / moment[2]
    c0 = (moment[1] - moment[2]) * i0
    c1 = (moment[2] - moment[0]) * i1
    c2 = (moment[0] - moment[1]) * i2
    last = ORDER
    before = 1.0
    inverse = 0.0
    for k in range(ORDER):
        px, py, pz = series[k, PS], series[k, PS + 1], series[k, PS + 2]
        ax, ay, az = ry * pz - rz * py, rz * px - rx * pz, rx * py - ry * px
        series[k, A], series[k, A + 1], series[k, A + 2] = ax, ay, az
        series[k, IA], series[k, IA + 1], series[k, IA + 2] = ax * i0, ay * i1, az * i2
        cx, cy, cz = ey * pz - ez * py, ez * px - ex * pz, ex * py - ey * px
        series[k, C], series[k, C + 1], series[k, C + 2] = cx, cy, cz
        series[k, IC], series[k, IC + 1], series[k, IC + 2] = cx * i0, cy * i1, cz * i2
        s0 = s1 = s2 = s3 = s4 = s5 = pw = ww = m11 = m12 = m22 = 0.0
        for i in range(np.uint64(k + 1)):
            j = np.uint64(k) - i
            a0, a1, a2 = series[i, WS], series[i, WS + 1], series[i, WS + 2]
            q0, q1, q2 = series[i, PS], series[i, PS + 1], series[i, PS + 2]
            b0, b1, b2 = series[j, WS], series[j, WS + 1], series[j, WS + 2]
            s0 += a1 * b2
            s1 += a2 * b0
            s2 += a0 * b1
            s3 += q1 * b2 - q2 * b1
            s4 += q2 * b0 - q0 * b2
            s5 += q0 * b1 - q1 * b0
            pw += q0 * b0 + q1 * b1 + q2 * b2
            ww += a0 * b0 + a1 * b1 + a2 * b2
            m11 += (series[i, A] * series[j, IA] + series[i, A + 1] * series[j, IA + 1]
                    + series[i, A + 2] * series[j, IA + 2])
        series[k, G], series[k, G + 1], series[k, G + 2] = c0 * s0, c1 * s1, c2 * s2
        series[k, PW], series[k, WW] = pw, ww
        force, torque = 0.0, 0.0
        if k == 0:
            m11 += 1.0
            force = step * step
        series[k, M11] = m11
        if edge:
            for i in range(np.uint64(k + 1)):
                j = np.uint64(k) - i
                m12 += (series[i, A] * series[j, IC] + series[i, A + 1] * series[j, IC + 1]
                        + series[i, A + 2] * series[j, IC + 2])
                m22 += (series[i, C] * series[j, IC] + series[i, C + 1] * series[j, IC + 1]
                        + series[i, C + 2] * series[j, IC + 2])
                torque -= (series[i, C] * series[j, G] + series[i, C + 1] * series[j, G + 1]
                           + series[i, C + 2] * series[j, G + 2])
                torque -= series[i, PW] * (ex * series[j, WS] + ey * series[j, WS + 1]
                                           + ez * series[j, WS + 2])
                torque += series[i, WW] * (ex * series[j, PS] + ey * series[j, PS + 1]
                                           + ez * series[j, PS + 2])
            series[k, M12], series[k, M22] = m12, m22
        for i in range(np.uint64(k + 1)):
            j = np.uint64(k) - i
            force -= (series[i, A] * series[j, G] + series[i, A + 1] * series[j, G + 1]
                      + series[i, A + 2] * series[j, G + 2])
            force -= series[i, PW] * (rx * series[j, WS] + ry * series[j, WS + 1]
                                      + rz * series[j, WS + 2])
            force += series[i, WW] * (rx * series[j, PS] + ry * series[j, PS + 1]
                                      + rz * series[j, PS + 2])
        for i in range(np.uint64(k)):
            j = np.uint64(k) - i
            force -= series[i, FORCE] * series[j, M11]
            if edge:
                force -= series[i, TORQUE] * series[j, M12]
                torque -= series[i, FORCE] * series[j, M12] + series[i, TORQUE] * series[j, M22]
        if edge:
            if k == 0:
                inverse = 1.0 / (m11 * m22 - m12 * m12)
            known = force
            force = inverse * (series[0, M22] * known - series[0, M12] * torque)
            torque = inverse * (series[0, M11] * torque - series[0, M12] * known)
        else:
            if k == 0:
                inverse = 1.0 / m11
            force *= inverse
        series[k, FORCE], series[k, TORQUE] = force, torque
        s0, s1, s2 = c0 * s0, c1 * s1, c2 * s2
        for i in range(np.uint64(k + 1)):
            j = np.uint64(k) - i
            n, t = series[i, FORCE], series[i, TORQUE]
            s0 += n * series[j, IA] + t * series[j, IC]
            s1 += n * series[j, IA + 1] + t * series[j, IC + 1]
            s2 += n * series[j, IA + 2] + t * series[j, IC + 2]
        share = 1.0 / (k + 1)
        px, py, pz = s3 * share, s4 * share, s5 * share
        series[k + 1, WS], series[k + 1, WS + 1] = s0 * share, s1 * share
        series[k + 1, WS + 2] = s2 * share
        series[k + 1, PS], series[k + 1, PS + 1], series[k + 1, PS + 2] = px, py, pz
        series[k + 1, ZS] = -(px * rx + py * ry + pz * rz)
        size = max(abs(px), abs(py), abs(pz), abs(s0) * share, abs(s1) * share, abs(s2) * share)
        if max(size, before) < truncation:
            last = k + 1
            break
        before = size
    series[last, FORCE] = series[last, TORQUE] = 0.0
    return last
