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

"""Stable sorting, by digits or by merging; and values that tie."""

import numpy as np

from .array_types import Array, Fixed1, FixedIndex1, Index
from .compilation import entry_kernel, kernel

DIGIT = 11
SHORT_DIGIT = 6
"""Bits looked at in one pass: the counters of a digit stay in the fastest memory; and
where there are fewer keys than counters.
"""

RUN = 16
"""Values that are sorted by insertion before runs are merged."""


@kernel
def rising_order(keys: Index) -> Index:
    """Order (N,) that sorts keys (N,) of 0 or more; equal ones stay."""
    count = keys.shape[0]
    order = np.arange(count)
    order_buffer = np.empty(count, np.int64)
    sorted_keys = keys.copy()
    keys_buffer = np.empty(count, np.int64)
    largest = 0
    for i in range(count):
        largest = max(largest, keys[i])
    bits = SHORT_DIGIT if count < 1 << DIGIT else DIGIT
    mask = (1 << bits) - 1
    position = np.empty(mask + 1, np.int64)
    shift = 0
    while shift < 63 and (largest >> shift) > 0:
        position[:] = 0
        for i in range(count):
            position[(sorted_keys[i] >> shift) & mask] += 1
        total = 0
        for digit in range(mask + 1):
            size = position[digit]
            position[digit] = total
            total += size
        for i in range(count):
            digit = (sorted_keys[i] >> shift) & mask
            order_buffer[position[digit]] = order[i]
            keys_buffer[position[digit]] = sorted_keys[i]
            position[digit] += 1
        order, order_buffer = order_buffer, order
        sorted_keys, keys_buffer = keys_buffer, sorted_keys
        shift += bits
    return order


@kernel
def falling_order(values: Array) -> Index:
    """Order (N,) that sorts values (N,) of 0 or more, largest first; ties stay."""
    # The bits of numbers from 0 up, read as integers, are in the order of the numbers.
    bits = np.abs(values).view(np.int64)
    largest = 0
    for i in range(bits.shape[0]):
        largest = max(largest, bits[i])
    return rising_order(largest - bits)


@kernel
def stable_order(values: Array) -> Index:
    """Order (N,) that sorts values (N,) without NaN; equal ones stay as they were."""
    count = values.shape[0]
    order = np.arange(count)
    buffer = np.empty(count, np.int64)
    for begin in range(0, count, RUN):
        for i in range(begin + 1, min(begin + RUN, count)):
            k = order[i]
            while i > begin and values[k] < values[order[i - 1]]:
                order[i] = order[i - 1]
                i -= 1
            order[i] = k
    width = RUN
    while width < count:
        for begin in range(0, count, 2 * width):
            middle = min(begin + width, count)
            end = min(begin + 2 * width, count)
            low = begin
            high = middle
            for k in range(begin, end):
                if high == end or (
                    low < middle and values[order[low]] <= values[order[high]]
                ):
                    buffer[k] = order[low]
                    low += 1
                else:
                    buffer[k] = order[high]
                    high += 1
        order, buffer = buffer, order
        width *= 2
    return order


@entry_kernel
def number_ties(
    values: Fixed1, tolerance: float, group: FixedIndex1, order: FixedIndex1
) -> tuple[Index, int]:
    """Numbers of the ties, each from its smallest value on, and their count.

    `order` (S,): by rising group, within a group by rising value.
    """
    numbers = np.empty(values.shape[0], np.int64)
    number = -1
    tie_begin = 0
    for i in range(order.shape[0]):
        index = order[i]
        if (
            i == 0
            or group[index] > group[tie_begin]
            or values[index] - values[tie_begin] > tolerance
        ):
            number += 1
            tie_begin = index
        numbers[index] = number
    return numbers, number + 1
