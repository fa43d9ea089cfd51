"""Starting directions: the orientation in which each drop is released.

Drop k depends on the seed and k alone, so that any worker can compute any of the drops. The
words come straight from Philox, a generator that can be set to any place of its stream and
whose stream is the same in all versions of numpy (its distributions are not promised to be).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..kernels.elementary import sines_cosines

Array = NDArray[np.float64]

_WORDS: Final = 4
"""64-bit words that Philox makes at each place of its stream."""

_RANDOM_STREAM: Final = 1
_FLIP_STREAM: Final = 3
"""Second words of the key, so that drops and flips of one seed have nothing in common."""

def random_starts(seed: int, first: int, count: int) -> Array:
    """Independent directions, uniform on the sphere.

    `seed`: 0 <= seed < 2**64; `first, count`: drops first ... first + count - 1; both >= 0.
    Returns (count, 3): unit vectors `down` in part axes that point vertically down at release; row
    k is the same in every call that includes it.
    """
    pairs = _pairs(seed, _RANDOM_STREAM, first, count)
    return _on_sphere(pairs[:, 0], pairs[:, 1])


def flip_draws(seed: int, first: int, count: int) -> Array:
    """Two uniform numbers in [0, 1) for each of the flips first ... first + count - 1, (count, 2).

    Row k is the same in every call that includes it.
    """
    return _pairs(seed, _FLIP_STREAM, first, count)


def _pairs(seed: int, stream: int, first: int, count: int) -> Array:
    place, before = divmod(2 * first, _WORDS)
    return _uniforms(seed, stream, place, before + 2 * count)[before:].reshape(count, 2)


def _uniforms(seed: int, stream: int, place: int, count: int) -> Array:
    """Numbers (count,) of 53 bits in [0, 1), from a place (of four words) of a stream on."""
    key = np.array((seed, stream), dtype=np.uint64)
    words = np.random.Philox(counter=place, key=key).random_raw(count)
    return np.asarray((words >> np.uint64(11)) * 2.0 ** -53)


def _on_sphere(u: Array, v: Array) -> Array:
    """Equal-area map of the unit square: heights 2 u - 1 and azimuths 2 pi v."""
    azimuth = (2.0 * np.pi) * v
    radius = 2.0 * np.sqrt(u * (1.0 - u))
    points = np.empty((len(u), 3))
    sine, cosine = sines_cosines(azimuth)
    points[:, 0] = radius * cosine
    points[:, 1] = radius * sine
    points[:, 2] = 2.0 * u - 1.0
    return points
