"""Starting directions: the orientation in which each drop is released.

Drop k depends on the seed and k alone, so that any worker can compute any of the drops. The
words come straight from Philox, a generator that can be set to any place of its stream and
whose stream is the same in all versions of numpy (its distributions are not promised to be).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..errors import RequestError
from ..kernels.elementary import sines_cosines
from ..records.scene import SAMPLINGS
from ..statistics.blocks import BLOCK

Array = NDArray[np.float64]

_WORDS: Final = 4
"""64-bit words that Philox makes at each place of its stream."""

_RANDOM_STREAM: Final = 1
_LATTICE_STREAM: Final = 2
_FLIP_STREAM: Final = 3
"""Second words of the key, so that drops and flips of one seed have nothing in common."""

_GOLDEN: Final = (math.sqrt(5.0) - 1.0) / 2.0

_ORDER: Final = (
    17, 47, 32, 28, 8, 59, 10, 48, 60, 1, 29, 46, 31, 14, 58, 12, 26, 43, 11, 49, 45, 7, 57, 27,
    13, 33, 42, 30, 0, 63, 23, 56, 16, 44, 9, 50, 25, 5, 40, 54, 34, 6, 36, 61, 2, 35, 39, 24,
    38, 15, 55, 19, 41, 21, 51, 4, 52, 53, 3, 20, 37, 62, 22, 18)
"""Order of the pattern's points. It begins with 17, the best first one, and goes on with the point
of the largest sum of distances to those before, which leaves the smallest cap discrepancy."""


def starting_directions(sampling: str, seed: int, first: int, count: int) -> Array:
    """`random_starts` or `lattice_starts` by name.

    Raises
    ------
    RequestError
        If there is no sampling of that name.
    """
    makers: dict[str, Callable[[int, int, int], Array]] = dict(
        zip(SAMPLINGS, (random_starts, lattice_starts), strict=True))
    if sampling not in makers:
        raise RequestError(f"a sampling out of {', '.join(SAMPLINGS)}", f"{sampling!r}",
                           "random is the default")
    return makers[sampling](seed, first, count)


def random_starts(seed: int, first: int, count: int) -> Array:
    """Independent directions, uniform on the sphere.

    Parameters
    ----------
    seed : int
        0 <= seed < 2**64.
    first, count : int
        Drops first ... first + count - 1; both >= 0.

    Returns
    -------
    (count, 3) array
        Unit vectors `down` in part axes that point vertically down at release; row k is the
        same in every call that includes it.
    """
    pairs = _pairs(seed, _RANDOM_STREAM, first, count)
    return _on_sphere(pairs[:, 0], pairs[:, 1])


def flip_draws(seed: int, first: int, count: int) -> Array:
    """Two uniform numbers in [0, 1) for each of the flips first ... first + count - 1, (count, 2).

    Row k is the same in every call that includes it.
    """
    return _pairs(seed, _FLIP_STREAM, first, count)


def lattice_starts(seed: int, first: int, count: int) -> Array:
    """Even directions, in blocks of 64 that are each rotated at random by themselves.

    Every block is one pattern, 64 points of a spherical Fibonacci lattice in an order that
    keeps its beginnings even, under a rotation that depends on the seed and the block alone:
    each direction by itself is uniform, and `statistics.blocks` finds the variance.

    Mean square cap discrepancy over that of random directions: 0.077 for whole blocks and
    at most 0.28 for any prefix from 10 directions on (R2 0.13 and 0.40, Sobol 0.12 and 0.39,
    Halton 0.15 and 0.35, the same 64 points in steps of 27 0.077 and 0.30).

    Parameters
    ----------
    seed : int
        0 <= seed < 2**64.
    first, count : int
        Drops first ... first + count - 1; both >= 0.

    Returns
    -------
    (count, 3) array
        As from `random_starts`; the beginning of every block of drops 64 b ... 64 b + 63 is
        even, and so is any number of blocks together.
    """
    begin, end = first // BLOCK, -(-(first + count) // BLOCK)
    turns = _rotations(_uniforms(seed, _LATTICE_STREAM, begin, _WORDS * (end - begin)))
    pattern = _pattern()
    # Component by component, as in `mesh.vectors`.
    blocks = sum(turns[:, None, :, j] * pattern[None, :, j, None] for j in range(3))
    skipped = first - begin * BLOCK
    return np.asarray(blocks).reshape(-1, 3)[skipped:skipped + count]


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


def _rotations(uniforms: Array) -> Array:
    """Uniform rotation matrices (B, 3, 3) from three of each four uniforms (4 B,).

    The uniform quaternion of Shoemake, "Uniform random rotations", Graphics Gems III (1992).
    """
    u, v, w = uniforms.reshape(-1, _WORDS).T[:3]
    sines, cosines = sines_cosines((2.0 * np.pi) * np.concatenate((v, w)))
    x, z = np.sqrt(1.0 - u) * sines[:len(v)], np.sqrt(u) * sines[len(v):]
    y, s = np.sqrt(1.0 - u) * cosines[:len(v)], np.sqrt(u) * cosines[len(v):]
    return 2.0 * np.stack((
        0.5 - y * y - z * z, x * y - z * s, x * z + y * s,
        x * y + z * s, 0.5 - x * x - z * z, y * z - x * s,
        x * z - y * s, y * z + x * s, 0.5 - x * x - y * y), axis=1).reshape(-1, 3, 3)


@lru_cache(maxsize=1)
def _pattern() -> Array:
    """The points of a block, (64, 3)."""
    point = np.array(_ORDER)
    return _on_sphere((point + 0.5) / BLOCK, (point * _GOLDEN) % 1.0)
