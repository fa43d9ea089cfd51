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

"""Free rotation over any time in one go (Euler and Poinsot, solved by Jacobi).

High above the plate nothing can touch it, and a drop may turn many times. There the
angular velocity is w = (w1 cn u, w2 sn u, w3 dn u) with u linear in time, axis 3 being
the one about which the angular momentum L circles in the body. `up` is normal to L
throughout and fixed in space, so it is told by one angle about L, measured from e3 x L.
That direction precesses at L (L1²/I1 + L2²/I2) / (L1² + L2²), whose integral is,
with Jacobi's theta function and sn(alpha | 1 - m) = L3/L at u = 0 (DLMF 22.15, 20.5;
Whittaker, Analytical Dynamics, section 69),

    L t / I1 ± [arg theta4(z + i y) + z d/dy log theta4(i y)],

with z = pi u / 2K and y = pi alpha / 2K.
"""

import math

from ..array_types import Array
from ..compilation import inlined, kernel
from ..elementary import arctangent, exponential, sine_cosine
from ..vectors import (
    Vec3,
    add,
    cross,
    divide,
    dot,
    length,
    products,
    read_vector,
    scale,
    write_vector,
)
from . import layout

NOME = 0.35
"""Largest nome for which the theta series are summed; they fail near the separatrix."""

STEEP = 1e-3
"""Smallest sine of the angle between L and axis 3; closer, e3 x L says little."""

TERMS = 9
"""Terms of a theta series; the next one is below 0.35^90."""


@kernel
def arithmetic_geometric(b: float, phase: float) -> tuple[float, float]:
    """Mean of 1 and b, and pi/2K times the elliptic integral of the amplitude `phase`.

    Landen's transformation (DLMF 19.8.12, 22.20): the phase grows to 2^n times a phase
    that is linear in the argument.
    """
    a = 1.0
    power = 1.0
    for _ in range(12):
        ratio = b / a
        sine, cosine = sine_cosine(phase)
        side = math.copysign(1.0, cosine)
        turned = arctangent(ratio * side * sine, side * cosine)
        phase += turned + math.pi * math.floor((phase - turned) / math.pi + 0.5)
        power *= 2.0
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        if abs(a - b) < 1e-15 * a:
            break
    return 0.5 * (a + b), phase / power


@kernel
def theta_ratios(z: float, nome: float) -> tuple[float, float, float]:
    """Elliptic sn, cn and dn at u = 2K z / pi, by theta functions (DLMF 22.2)."""
    odd_s, odd_c = sine_cosine(z)
    c2 = odd_c * odd_c - odd_s * odd_s
    s2 = 2.0 * odd_s * odd_c
    even_c = 1.0
    even_s = 0.0
    t1 = odd_s
    t2 = odd_c
    t3 = 0.5
    t4 = 0.5
    n2 = 1.0
    n3 = 0.5
    n4 = 0.5
    odd = 1.0
    even = 1.0
    step = 1.0
    square = nome * nome
    sign = 1.0
    for _ in range(TERMS):
        # even: nome^(n²), odd: nome^(n² + n), the fourth root of the nome left out
        even *= nome * step
        step *= square
        odd *= step
        sign = -sign
        even_c, even_s = even_c * c2 - even_s * s2, even_s * c2 + even_c * s2
        odd_c, odd_s = odd_c * c2 - odd_s * s2, odd_s * c2 + odd_c * s2
        t1 += sign * odd * odd_s
        t2 += odd * odd_c
        t3 += even * even_c
        t4 += sign * even * even_c
        n2 += odd
        n3 += even
        n4 += sign * even
        if even < 1e-18:
            break
    return n3 * t1 / (n2 * t4), n4 * t2 / (n2 * t4), n4 * t3 / (n3 * t4)


@kernel
def theta_turn(z: float, nome: float, growth: float) -> float:
    """Argument of theta4(z + i y), `growth` = exp(2 y)."""
    s2, c2 = sine_cosine(2.0 * z)
    c = 1.0
    s = 0.0
    real = 0.5
    imaginary = 0.0
    rising = falling = step = 1.0
    sign = 1.0
    for _ in range(TERMS + 1):
        rising *= nome * step * growth
        falling *= nome * step / growth
        step *= nome * nome
        sign = -sign
        c, s = c * c2 - s * s2, s * c2 + c * s2
        real += 0.5 * sign * (rising + falling) * c
        imaginary -= 0.5 * sign * (rising - falling) * s
        if rising < 1e-18:
            break
    return arctangent(imaginary, real)


@kernel
def theta_slope(nome: float, growth: float) -> float:
    """Slope d/dy log theta4(i y), `growth` = exp(2 y)."""
    rising = falling = step = 1.0
    sign = 1.0
    denominator = 0.5
    numerator = 0.0
    for n in range(1, TERMS + 2):
        rising *= nome * step * growth
        falling *= nome * step / growth
        step *= nome * nome
        sign = -sign
        denominator += 0.5 * sign * (rising + falling)
        numerator += sign * n * (rising - falling)
        if rising < 1e-18:
            break
    return numerator / denominator


@inlined
def rotate_freely(state: Array, moment: Array, time: float) -> bool:
    """Turn `up` and the spin by a free motion; tell whether that could be done.

    It cannot near the separatrix and near a permanent rotation, where nothing is
    changed.
    """
    separatrix_distance = 0.0  # L² - 2 E I2, whose sign tells which axis L circles
    for i in (0, 2):
        separatrix_distance += (
            moment[i]
            * (moment[i] - moment[1])
            * (state[layout.W + i] * state[layout.W + i])
        )
    first_axis, circled_axis, parity = (
        (2, 0, -1.0) if separatrix_distance < 0.0 else (0, 2, 1.0)
    )
    i1 = moment[first_axis]
    i2 = moment[1]
    i3 = moment[circled_axis]
    w1 = state[layout.W + first_axis]
    w2 = state[layout.W + 1]
    w3 = state[layout.W + circled_axis]
    if i3 in (i1, i2):
        return False
    ratio = i1 * (i1 - i3) / (i2 * (i2 - i3))
    top1 = math.sqrt(w1 * w1 + w2 * w2 / ratio)
    top2 = math.sqrt(w2 * w2 + w1 * w1 * ratio)
    top3 = math.sqrt(w3 * w3 + i2 * (i2 - i1) / (i3 * (i3 - i1)) * w2 * w2)
    if w3 < 0.0:
        top3 = -top3
    momentum = length(Vec3(i1 * w1, i2 * w2, i3 * w3))
    sine = abs(i3 * top3) / momentum
    cosine = i1 * top1 / momentum
    if not (cosine > STEEP and sine > 0.0):
        return False
    m = i1 * (i2 - i1) * top1 * top1 / (i3 * (i3 - i2) * top3 * top3)
    if not 0.0 <= m < 1.0:
        return False
    turning = math.copysign(1.0, parity * (i3 - i1) * top3)
    speed = abs(top3) * math.sqrt((i3 - i1) * (i3 - i2) / (i1 * i2))
    mean, z0 = arithmetic_geometric(
        math.sqrt(1.0 - m), arctangent(turning * w2 / top2, w1 / top1)
    )
    complementary_mean, y = arithmetic_geometric(math.sqrt(m), arctangent(sine, cosine))
    nome = (
        exponential(-math.pi * mean / complementary_mean)
        if complementary_mean > 0.0
        else 0.0
    )
    if not nome < NOME:
        return False
    growth = exponential(2.0 * y * mean / complementary_mean)
    z1 = z0 + mean * speed * time
    sn, cn, dn = theta_ratios(z1, nome)
    swing = (
        theta_turn(z1, nome, growth)
        - theta_turn(z0, nome, growth)
        + (z1 - z0) * theta_slope(nome, growth)
    )
    if i1 > i3:
        swing = -swing
    angle = momentum * time / i1 + swing
    component, normal_component = _components_of_up(state, moment, circled_axis)
    state[layout.W + first_axis] = top1 * cn
    state[layout.W + 1] = turning * top2 * sn
    state[layout.W + circled_axis] = top3 * dn
    sine, cosine = sine_cosine(arctangent(normal_component, component) - angle)
    _write_up(state, moment, circled_axis, cosine, sine)
    return True


@inlined
def _components_of_up(
    state: Array, moment: Array, circled_axis: int
) -> tuple[float, float]:
    """Components of `up` along e3 x L and along L x (e3 x L), not normalised alike."""
    momentum = products(read_vector(moment, 0), layout.spin_of(state))
    normal_to_axis = _normal_to_axis(momentum, circled_axis)
    up = layout.up_of(state)
    return (
        dot(normal_to_axis, up),
        dot(cross(momentum, normal_to_axis), up) / length(momentum),
    )


@inlined
def _write_up(
    state: Array,
    moment: Array,
    circled_axis: int,
    component: float,
    normal_component: float,
) -> None:
    """Set `up` in the frame of e3 x L and L x (e3 x L)."""
    momentum = products(read_vector(moment, 0), layout.spin_of(state))
    normal_to_axis = _normal_to_axis(momentum, circled_axis)
    normal = cross(momentum, normal_to_axis)
    write_vector(
        state,
        layout.P,
        add(
            divide(scale(normal_to_axis, component), length(normal_to_axis)),
            divide(scale(normal, normal_component), length(normal)),
        ),
    )


@inlined
def _normal_to_axis(momentum: Vec3, circled_axis: int) -> Vec3:
    """The direction e3 x L, e3 being the first or the last axis."""
    if circled_axis == 0:
        return Vec3(0.0, -momentum.z, momentum.y)
    return Vec3(-momentum.y, momentum.x, 0.0)
