"""Random numbers that a place in a series always gives, in every version of numpy.

The words come straight from Philox, whose stream numpy keeps; its distributions are not
promised to stay.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

_STREAM: Final = 3
"""Second word of the generator's key; 1 and 2 are the starting directions'."""


def uniforms(seed: int, number: int, attempt: int) -> Iterator[float]:
    """Endless numbers of 53 bits in [0, 1) that nobody else gets."""
    bits = np.random.Philox(counter=np.array((0, attempt, number, 0), dtype=np.uint64),
                            key=np.array((seed, _STREAM), dtype=np.uint64))
    while True:
        for word in bits.random_raw(64):
            yield (int(word) >> 11) * 2.0 ** -53


def normal(numbers: Iterator[float]) -> float:
    """A normally distributed number (Box and Muller 1958, one of the pair)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - next(numbers)))
    return radius * math.cos(2.0 * math.pi * next(numbers))


def failures(numbers: Iterator[float], chance: float) -> int:
    """Failures before the first success of this chance."""
    return math.floor(math.log(1.0 - next(numbers)) / math.log(1.0 - chance))
