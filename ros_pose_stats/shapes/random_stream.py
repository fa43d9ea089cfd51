"""Random numbers that a place in a series always gives, in every version of numpy.

The words come straight from Philox, whose stream numpy keeps; its distributions are not
promised to stay, and the C library's logarithm rounds differently on other processors.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..kernels.elementary import logarithms, sines_cosines

_STREAM: Final = 3
"""Second word of the generator's key; 1 and 2 are the starting directions'."""


def uniforms(seed: int, number: int, attempt: int) -> Iterator[float]:
    """Endless numbers of 53 bits in [0, 1) that nobody else gets."""
    bits = np.random.Philox(counter=np.array((0, attempt, number, 0), dtype=np.uint64),
                            key=np.array((seed, _STREAM), dtype=np.uint64))
    while True:
        for word in bits.random_raw(64):
            yield (int(word) >> 11) * 2.0 ** -53


def normals(numbers: Iterator[float], count: int) -> NDArray[np.float64]:
    """Normally distributed numbers (count,): Box and Muller 1958, one of each pair."""
    pairs = np.array(list(islice(numbers, 2 * count))).reshape(count, 2)
    radius = np.sqrt(-2.0 * logarithms(1.0 - pairs[:, 0]))
    return np.asarray(radius * sines_cosines((2.0 * math.pi) * pairs[:, 1])[1])


def failures(numbers: Iterator[float], chance: float) -> int:
    """Failures before the first success of this chance."""
    left, count, still = 1.0 - next(numbers), 0, 1.0 - chance
    while left <= still:
        count, still = count + 1, still * (1.0 - chance)
    return count
