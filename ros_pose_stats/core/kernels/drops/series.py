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

"""Power series of a step: of free flight, and of sliding on one vertex or on an edge.

In flight I w' = (I w) x w and p' = p x w (Eqs. 13 and 15 without contact, p the
vertical in body axes). In principal axes w1' = (I2 - I3)/I1 w2 w3 and so on, so that
each coefficient is a sum over products of the earlier ones.

While sliding, forces keep the contact at its height (Eqs. 12, 13 and 16). With a = r x
p, the reach of the force N at r, and for an edge of direction e, c = e x p, the reach
of a pure moment T along it,

    I w' = (I w) x w + N a + T c,        v' = -1 + N,
    h'' = v' + ((p x w) x w) . r + w' . a = 0,    ((p x w) x w) . e + w' . c = 0.

(The sign of the moment in Eq. 13 as printed is wrong.) Taking the edge as (r, e) rather
than as two vertices keeps the equations apart on a short edge. T is the force on the
far vertex times the length. All forces are multiplied by the step squared.
"""

import numpy as np

from ..array_types import Array
from ..compilation import inlined
from ..elementary import rough_root
from ..vectors import (
    Vec3,
    add,
    cross,
    dot,
    products,
    read_row,
    read_vector,
    scale,
    write_row,
)
from . import layout


@inlined
def begin_series(state: Array, step: float, series: Array) -> None:
    """Put the state at the start of a step into row 0, and the height's first power."""
    write_row(series, 0, layout.WS, scale(layout.spin_of(state), step))
    write_row(series, 0, layout.PS, layout.up_of(state))
    series[0, layout.ZS] = state[layout.Z]


@inlined
def free_series(
    state: Array, moment: Array, step: float, truncation: float, series: Array
) -> int:
    """Fill the series of a free flight; return its last row.

    Rows stop when two in a row add less than `truncation` to the direction of up.
    """
    coupling = layout.coupling_of(moment)
    begin_series(state, step, series)
    last = layout.ORDER
    previous_size = 1.0
    for k in range(layout.ORDER):
        spins, tilt = turning_products(series, k)
        share = 1.0 / (k + 1)
        write_row(series, k + 1, layout.WS, scale(products(coupling, spins), share))
        write_row(series, k + 1, layout.PS, scale(tilt, share))
        series[k + 1, layout.ZS] = 0.0
        size = max(abs(tilt.x), abs(tilt.y), abs(tilt.z)) * share
        if max(size, previous_size) < truncation:
            last = k + 1
            break
        previous_size = size
    series[1, layout.ZS] = step * state[layout.V]
    series[2, layout.ZS] = -0.5 * step * step
    return last


@inlined
def turning_products(series: Array, k: int) -> tuple[Vec3, Vec3]:
    """Coefficients k of (w2 w3, w3 w1, w1 w2), and of p x w."""
    spins = Vec3(0.0, 0.0, 0.0)
    tilt = Vec3(0.0, 0.0, 0.0)
    for i in range(np.uint64(k + 1)):
        j = np.uint64(k) - i
        a = read_row(series, i, layout.WS)
        b = read_row(series, j, layout.WS)
        spins = add(spins, Vec3(a.y * b.z, a.z * b.x, a.x * b.y))
        tilt = add(tilt, cross(read_row(series, i, layout.PS), b))
    return spins, tilt


@inlined
def shorten_series(series: Array, last: int, truncation: float) -> float:
    """Fraction of the step at which the series has converged; rescales it to that.

    Returns 1 where the last two rows are already below `truncation`.
    """
    tail = 0.0
    for k in (last - 1, last):
        for i in range(layout.PS, layout.PS + 3):
            tail = max(tail, abs(series[k, i]))
    if tail <= 4.0 * truncation:
        return 1.0
    fraction = 0.9 * rough_root(truncation / tail, last)
    power = 1.0
    for k in range(last + 1):
        write_row(
            series,
            k,
            layout.WS,
            scale(read_row(series, k, layout.WS), power * fraction),
        )
        write_row(series, k, layout.PS, scale(read_row(series, k, layout.PS), power))
        series[k, layout.ZS] *= power
        series[k, layout.FORCE] *= power * fraction * fraction
        series[k, layout.TORQUE] *= power * fraction * fraction
        power *= fraction
    return fraction


# Further columns: a, c, I^-1 a, I^-1 c, I^-1 (I w) x w, p.w, w.w and the two sides'
# products
A = 9
C = 12
IA = 15
IC = 18
G = 21
PW = 24
WW = 25
M11 = 26
M12 = 27
M22 = 28


@inlined
def sliding_series(
    state: Array,
    moment: Array,
    contact: Array,
    edge: bool,
    step: float,
    truncation: float,
    series: Array,
) -> int:
    """Fill the series of a sliding phase; return its last row.

    `edge`: sliding on the edge rather than on the vertex alone.
    """
    begin_series(state, step, series)
    r = read_vector(contact, layout.CORNER)
    e = read_vector(contact, layout.DIRECTION)
    inverse = Vec3(1.0 / moment[0], 1.0 / moment[1], 1.0 / moment[2])
    coupling = Vec3(
        (moment[1] - moment[2]) * inverse.x,
        (moment[2] - moment[0]) * inverse.y,
        (moment[0] - moment[1]) * inverse.z,
    )
    last = layout.ORDER
    previous_size = 1.0
    inverse_determinant = 0.0
    for k in range(layout.ORDER):
        _write_reaches(series, k, r, e, inverse)
        spins, tilt = turning_products(series, k)
        write_row(series, k, G, products(coupling, spins))
        _write_products(series, k, edge)
        if k == 0:  # the inverse of the determinant of the responses
            inverse_determinant = series[0, M11]
            if edge:
                inverse_determinant = (
                    series[0, M11] * series[0, M22] - series[0, M12] * series[0, M12]
                )
            inverse_determinant = 1.0 / inverse_determinant
        _write_forces(series, k, r, e, edge, step, inverse_determinant)
        share = 1.0 / (k + 1)
        spin = scale(_acceleration(series, k), share)
        up = scale(tilt, share)
        write_row(series, k + 1, layout.WS, spin)
        write_row(series, k + 1, layout.PS, up)
        series[k + 1, layout.ZS] = -dot(up, r)
        size = max(
            abs(up.x), abs(up.y), abs(up.z), abs(spin.x), abs(spin.y), abs(spin.z)
        )
        if max(size, previous_size) < truncation:
            last = k + 1
            break
        previous_size = size
    series[last, layout.FORCE] = series[last, layout.TORQUE] = 0.0
    return last


@inlined
def _write_reaches(series: Array, k: int, r: Vec3, e: Vec3, inverse: Vec3) -> None:
    """Row k of the reaches a and c, and of what they do to the angular velocity."""
    p = read_row(series, k, layout.PS)
    a = cross(r, p)
    c = cross(e, p)
    write_row(series, k, A, a)
    write_row(series, k, IA, products(a, inverse))
    write_row(series, k, C, c)
    write_row(series, k, IC, products(c, inverse))


@inlined
def _write_products(series: Array, k: int, edge: bool) -> None:
    """Row k of p.w, w.w, and the responses a . I^-1 a + 1, a . I^-1 c, c . I^-1 c."""
    pw = ww = m11 = 0.0
    for i in range(np.uint64(k + 1)):
        j = np.uint64(k) - i
        w = read_row(series, j, layout.WS)
        pw += dot(read_row(series, i, layout.PS), w)
        ww += dot(read_row(series, i, layout.WS), w)
        m11 += dot(read_row(series, i, A), read_row(series, j, IA))
    series[k, PW] = pw
    series[k, WW] = ww
    series[k, M11] = m11 + 1.0 if k == 0 else m11
    if edge:
        m12 = m22 = 0.0
        for i in range(np.uint64(k + 1)):
            j = np.uint64(k) - i
            c = read_row(series, j, IC)
            m12 += dot(read_row(series, i, A), c)
            m22 += dot(read_row(series, i, C), c)
        series[k, M12] = m12
        series[k, M22] = m22


@inlined
def _write_forces(
    series: Array,
    k: int,
    r: Vec3,
    e: Vec3,
    edge: bool,
    step: float,
    inverse_determinant: float,
) -> None:
    """Row k of the force and the moment that keep the contact at its height."""
    force = _fall(series, k, step * step if k == 0 else 0.0, A, r)
    torque = _fall(series, k, 0.0, C, e) if edge else 0.0
    for i in range(np.uint64(k)):
        j = np.uint64(k) - i
        force -= series[i, layout.FORCE] * series[j, M11]
        if edge:
            force -= series[i, layout.TORQUE] * series[j, M12]
            torque -= (
                series[i, layout.FORCE] * series[j, M12]
                + series[i, layout.TORQUE] * series[j, M22]
            )
    if edge:
        undetermined = force
        force = inverse_determinant * (
            series[0, M22] * undetermined - series[0, M12] * torque
        )
        torque = inverse_determinant * (
            series[0, M11] * torque - series[0, M12] * undetermined
        )
    else:
        force *= inverse_determinant
    series[k, layout.FORCE] = force
    series[k, layout.TORQUE] = torque


@inlined
def _fall(series: Array, k: int, start: float, reach: int, point: Vec3) -> float:
    """A number, plus row k of what lowers a place without the contact's forces.

    That is -((p x w) x w) . place - I^-1 (I w) x w . (place x p); the columns from
    `reach` on hold place x p.
    """
    fall = start
    for i in range(np.uint64(k + 1)):
        j = np.uint64(k) - i
        fall -= dot(read_row(series, i, reach), read_row(series, j, G))
        fall -= series[i, PW] * dot(point, read_row(series, j, layout.WS))
        fall += series[i, WW] * dot(point, read_row(series, j, layout.PS))
    return fall


@inlined
def _acceleration(series: Array, k: int) -> Vec3:
    """Row k of the angular acceleration, by the turning and by the forces."""
    acceleration = read_row(series, k, G)
    for i in range(np.uint64(k + 1)):
        j = np.uint64(k) - i
        acceleration = add(
            acceleration,
            add(
                scale(read_row(series, j, IA), series[i, layout.FORCE]),
                scale(read_row(series, j, IC), series[i, layout.TORQUE]),
            ),
        )
    return acceleration
