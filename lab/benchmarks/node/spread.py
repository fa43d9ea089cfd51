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

"""Least, median and 99th percentile of times."""

import math
from collections.abc import Sequence
from statistics import median

from lab.frame.results import Cell


def p99(seconds: Sequence[float]) -> float:
    """99th percentile in milliseconds; of fewer than 100 the largest."""
    return 1e3 * sorted(seconds)[math.ceil(0.99 * len(seconds)) - 1]


def spread(seconds: Sequence[float]) -> dict[str, Cell]:
    """Cells of a table: how many, and least, median and 99th percentile in
    milliseconds.
    """
    return {
        "runs": len(seconds),
        "least, ms": 1e3 * min(seconds),
        "median, ms": 1e3 * median(seconds),
        "p99, ms": p99(seconds),
    }


def beyond(seconds: Sequence[float], others: Sequence[float]) -> float:
    """Median over the rounds of one time less another of the same round, in
    milliseconds.
    """
    return 1e3 * median(
        seconds_of - baseline
        for seconds_of, baseline in zip(seconds, others, strict=False)
    )
