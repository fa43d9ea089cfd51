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

"""Elementary functions, principal axes and sorting, against the C library, LAPACK and
numpy.
"""

import math

import numpy as np
import pytest
from hypothesis import given, strategies
from hypothesis.extra.numpy import arrays

from lab.bodies.random_polyhedra import logarithms
from lab.bodies.variants import rotation
from ros_pose_stats.core.kernels.elementary import sines_cosines
from ros_pose_stats.core.kernels.principal_axes import principal_axes

from .helpers import (
    arctangent,
    exponential,
    falling_order,
    rising_order,
    rough_root,
    sine_cosine,
)

COUNT = 2000
ROUNDING = 8.0 * np.finfo(np.float64).eps
"""A few roundings of the largest moment: by so much the tensors themselves are
rounded.
"""


def units_off(values, function, *arguments, least=0.0):
    """Largest difference from the C library's function, in units in the last place.

    Values below `least` count as that.
    """
    right = np.array(
        [function(*row) for row in zip(*map(np.ndarray.tolist, arguments), strict=True)]
    )
    spacing = np.spacing(np.maximum(np.abs(right), least))
    return float(np.max(np.abs(np.asarray(values) - right) / spacing))


@pytest.mark.parametrize("span", [1e-3, 1.0, 100.0, 1e6])
def test_sine_and_cosine(span):
    angles = np.random.default_rng(1).uniform(-span, span, COUNT)
    for values, function in zip(
        sines_cosines(angles), (math.sin, math.cos), strict=True
    ):
        # A zero is known as well as the angle there.
        assert units_off(values, function, angles, least=1e-3) <= 2.0
    for k, pair in enumerate([(0, 1), (1, 0), (0, -1), (-1, 0), (0, 1)]):
        assert sine_cosine(k * math.pi / 2) == pytest.approx(pair, abs=1e-15)


def test_arctangent():
    random = np.random.default_rng(2)
    points = random.normal(size=(COUNT, 2)) * 10.0 ** random.uniform(
        -8.0, 8.0, (COUNT, 2)
    )
    assert (
        units_off([arctangent(y, x) for y, x in points.tolist()], math.atan2, *points.T)
        <= 2.0
    )
    for y, x in [(0, 0), (0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (-1, -1)]:
        assert arctangent(float(y), float(x)) == pytest.approx(
            math.atan2(y, x), abs=1e-15
        )
    # Where a drop has left the numbers, NaN goes on, and nothing is raised.
    for y, x in [(math.nan, 1.0), (1.0, math.nan), (math.inf, math.inf)]:
        assert math.isnan(arctangent(y, x))


def test_exponential_logarithm_and_roots():
    powers = np.random.default_rng(3).uniform(-708.0, 709.0, COUNT)
    assert units_off([exponential(x) for x in powers.tolist()], math.exp, powers) <= 2.0
    assert (exponential(0.0), exponential(-1e9), exponential(1e9)) == (
        1.0,
        0.0,
        math.inf,
    )
    for values in (np.exp(powers), np.random.default_rng(4).uniform(0.5, 2.0, COUNT)):
        assert units_off(logarithms(values), math.log, values) <= 2.0
        for order in (1, 2, 3, 16):
            roots = np.array([rough_root(x, order) for x in values.tolist()])
            assert np.abs(roots / values ** (1.0 / order) - 1.0).max() < 1e-5
    assert logarithms(np.ones(1)).tolist() == [0.0]


def assert_principal(tensor):
    """Rising moments, axes as the columns of a rotation, and the tensor back from
    both.
    """
    moments, axes = principal_axes(tensor)
    size = max(np.abs(tensor).max(), 1e-300)
    assert (np.diff(moments) >= 0.0).all()
    assert np.abs(axes.T @ axes - np.eye(3)).max() <= ROUNDING
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=ROUNDING)
    assert np.abs(axes @ np.diag(moments) @ axes.T - tensor).max() <= ROUNDING * size
    assert np.abs(moments - np.linalg.eigvalsh(tensor)).max() <= ROUNDING * size
    for axis in axes.T[:2]:  # the sign, too, is the same on every processor
        assert axis[np.abs(axis).argmax()] > 0.0
    return moments


@given(
    strategies.lists(strategies.floats(-1e3, 1e3), min_size=6, max_size=6),
    strategies.floats(1e-60, 1e60),
)
def test_principal_axes_of_any_tensor(entries, scale):
    a, b, c, d, e, f = (entry * scale for entry in entries)
    assert_principal(np.array([[a, d, e], [d, b, f], [e, f, c]]))


@pytest.mark.parametrize(
    "moments",
    [
        (1.0, 1.0, 1.0),
        (1.0, 1.0, 2.0),
        (1.0, 2.0, 2.0),
        (1e-14, 1.0, 1.0),
        (0.0, 0.0, 1.0),
        (1.0, 1.0 + 1e-12, 1.0 + 1e-9),
    ],
)
def test_principal_axes_of_moments_equal_up_to_rounding(moments):
    for seed in range(20):
        turn = rotation(seed)
        tensor = turn @ np.diag(moments) @ turn.T
        assert assert_principal(0.5 * (tensor + tensor.T)) == pytest.approx(
            moments, rel=0.0, abs=ROUNDING
        )


KEYS = strategies.one_of(
    strategies.integers(0, 3),
    strategies.integers(0, 2**17),
    strategies.integers(0, 2**63 - 1),
)
VALUES = strategies.one_of(
    strategies.sampled_from([0.0, -0.0, 1.0, 5e-324, np.inf]),
    strategies.floats(0.0, allow_infinity=False),
)


@given(
    arrays(np.int64, strategies.integers(0, 60), elements=KEYS),
    arrays(np.float64, strategies.integers(0, 60), elements=VALUES),
)
def test_sorting_keeps_ties_in_order(keys, values):
    assert rising_order(keys).tolist() == np.argsort(keys, kind="stable").tolist()
    assert falling_order(values).tolist() == np.argsort(-values, kind="stable").tolist()


def test_sorting_many():
    values = np.random.default_rng(3).lognormal(sigma=20.0, size=20_000).round(2)
    assert falling_order(values).tolist() == np.argsort(-values, kind="stable").tolist()
