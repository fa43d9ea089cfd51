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

"""Values that are equal but for rounding are tied wherever they stand, at any
decimal.
"""

import numpy as np
from hypothesis import given, strategies

from ros_pose_stats.core.tolerances import number_equal

TOLERANCE = 1e-10


@given(
    strategies.lists(strategies.integers(0, 50), min_size=1, max_size=12),
    strategies.floats(0.0, 1.0),
    strategies.randoms(use_true_random=False),
)
def test_noise_below_the_tolerance_changes_no_number(levels, start, random):
    """Levels ten tolerances apart, also about a half of any decimal, shaken by a
    rounding.
    """
    plain = [start + 10.0 * TOLERANCE * level for level in levels]
    shaken = [value + random.uniform(-2e-16, 2e-16) for value in plain]
    assert number_equal(shaken, TOLERANCE) == number_equal(plain, TOLERANCE)
    _, numbers = np.unique(levels, return_inverse=True)
    assert number_equal(plain, TOLERANCE) == numbers.tolist()


def test_a_dense_sequence_is_not_one_long_tie():
    values = [0.5 * TOLERANCE * k for k in range(9)]
    assert max(number_equal(values, TOLERANCE)) >= 2
