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

"""First zero of a polynomial: none is missed, none is invented.

The answers are judged in exact arithmetic, by Sturm's theorem: the floating-point
coefficients are rational numbers. Within `BLUR` of zero, relative to the sum of the
sizes of the terms, rounding decides.
"""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given, strategies

from .helpers import first_zero

BLUR = 1e-14
HIGHEST = 16  # power of the polynomials


def zero_of(c, upto=1.0):
    """First zero of a polynomial; infinity where there is none."""
    return first_zero(c, 0, len(c) - 1, upto, np.zeros(HIGHEST + 1))


def exact(polynomial, x):
    value = Fraction(0)
    for c in reversed(polynomial):
        value = value * x + c
    return value


def remainder(a, b):
    """Of the division of integer polynomials, lowest power first, times a positive
    number.
    """
    size = abs(b[-1])
    sign = 1 if b[-1] > 0 else -1
    while len(a) >= len(b):
        factor = sign * a[-1]
        start = len(a) - len(b)
        a = [size * c for c in a[:-1]]
        for k, c in enumerate(b[:-1]):
            a[start + k] -= factor * c
    while a and a[-1] == 0:
        a.pop()
    return a


def roots_between(polynomial, low, high):
    """Number of distinct real roots in (low, high], neither end being a multiple
    one.
    """
    whole = math.lcm(*(c.denominator for c in polynomial))
    chain = [
        [int(whole * c) for c in polynomial],
        [int(whole * k * c) for k, c in enumerate(polynomial)][1:],
    ]
    while len(chain[-1]) > 1 and (rest := remainder(chain[-2], chain[-1])):
        common = math.gcd(*rest)
        chain.append([-c // common for c in rest])

    def changes(x):
        signs = [value > 0 for p in chain if (value := exact(p, x)) != 0]
        return sum(a != b for a, b in pairwise(signs))

    return changes(low) - changes(high)


def assert_first_zero(coefficients, zero, upto=1.0):
    """No zero before it, and one there; infinity stands for none."""
    polynomial = [Fraction(float(c)) for c in coefficients]
    blur = Fraction(BLUR) * sum(map(abs, polynomial))
    raised = [polynomial[0] + blur, *polynomial[1:]]
    while raised[-1] == 0:
        raised.pop()
    end = Fraction(min(zero, upto))
    assert len(raised) == 1 or roots_between(raised, Fraction(0), end) == 0
    if math.isfinite(zero):
        assert 0.0 < zero <= upto
        assert abs(exact(polynomial, Fraction(zero))) <= blur


def coefficients_of(roots, pairs):
    """Polynomial, positive at 0, from real roots and pairs (a, b) of complex ones a ± i
    b.
    """
    c = np.polynomial.polynomial.polyfromroots(roots).real if roots else np.ones(1)
    for a, b in pairs:
        c = np.convolve(c, (a * a + b * b, -2.0 * a, 1.0))
    return c / np.abs(c).max() * np.sign(c[0])


REAL = strategies.one_of(
    strategies.floats(1e-3, 1.0),
    strategies.floats(-3.0, -1e-3),
    strategies.floats(1.0, 4.0),
)
PAIR = strategies.tuples(
    strategies.floats(-1.5, 1.5),
    strategies.one_of(strategies.floats(1e-9, 1e-3), strategies.floats(1e-3, 2.0)),
)


@given(
    roots=strategies.lists(REAL, max_size=6),
    pairs=strategies.lists(PAIR, max_size=4),
    upto=strategies.one_of(strategies.just(1.0), strategies.floats(0.01, 1.0)),
)
@example(roots=[0.5, 0.5], pairs=[], upto=1.0)
@example(roots=[0.5, 0.5, 0.5], pairs=[], upto=1.0)
@example(roots=[1.0], pairs=[(0.3, 1e-9)], upto=1.0)
@example(roots=[0.9, 0.1 + 1e-9, 0.1], pairs=[(0.05, 1e-6)], upto=1.0)
def test_known_roots(roots, pairs, upto):
    c = coefficients_of(roots, pairs)
    assume(len(c) > 1 and c[0] > 1e-12)
    assert_first_zero(c, zero_of(c, upto=upto), upto)


@given(
    c=strategies.lists(
        strategies.floats(-1.0, 1.0, allow_subnormal=False),
        min_size=2,
        max_size=HIGHEST + 1,
    ),
    shrink=strategies.sampled_from((1.0, 0.5, 0.1)),
    start=strategies.floats(1e-9, 1.0),
)
def test_any_coefficients(c, shrink, start):
    c = np.array([start, *c[1:]]) * shrink ** np.arange(len(c))
    assume(np.abs(c[1:]).max() > 1e-100)
    assert_first_zero(c, zero_of(c))


@pytest.mark.parametrize("time", [0.03, 0.5, 0.97])
@pytest.mark.parametrize("depth", [1e-2, 1e-6, 1e-10, 1e-13])
def test_grazing(time, depth):
    """A dip to just above zero is none, and one to just below it ends on its way
    down.
    """
    rest = np.array((2.0, 0.3, -0.4, 0.1))
    square = np.array((time * time, -2.0 * time, 1.0))
    above = np.convolve(square + np.array((depth, 0.0, 0.0)), rest)
    below = np.convolve(square - np.array((depth, 0.0, 0.0)), rest)
    width = math.sqrt(depth)
    assert zero_of(above) == math.inf
    if time > 1.01 * width:
        # The slope there is 2 width: a rounding of 1e-15 moves the zero by 1e-15 /
        # width.
        assert zero_of(below) == pytest.approx(time - width, abs=1e-14 / width)
