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

"""The bootstrap by whole bodies: scatter of a figure over other choices of the
bodies.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ros_pose_stats.core.records import Array, Index

RESAMPLES: Final = 1000
"""Resamples; with so many a standard error is right to 1 / sqrt(2000) = 2 %."""

_CELLS: Final = 1 << 20
"""Most weights in memory at a time, 8 bytes each."""

_KEPT_CELLS: Final = 1 << 22
"""Most weights that are remembered."""


def body_bootstrap(
    body: ArrayLike,
    terms: ArrayLike,
    statistic: Callable[[Array], Array],
) -> Array:
    """Values of a statistic on resamples of the bodies, drawn with replacement.

    All values of a body are drawn or left out together, its poses and its restitutions:
    they are dependent, as section 4.A of the paper notes below Eq. 2. The statistic
    sees sums over the values only, so that a resample costs no more than one weight a
    body: Efron and Tibshirani, "An Introduction to the Bootstrap" (1993), chapter 6 and
    section 8.3 for groups.

    Parameters
    ----------
    body : (N,) array of int
        Number of the body that each value belongs to.
    terms : (N, k) array
        Summands; finite. As bodies have different numbers of poses, N differs between
        resamples: where the statistic divides by it, one of the terms must be 1.
    statistic : callable
        Given the sums (k, R) of R resamples, gives their R values.

    Returns
    -------
    (RESAMPLES,) array
        The same bodies are drawn for a given version of numpy, whatever the order of
        the values.
    """
    sums = _body_sums(np.asarray(body), np.asarray(terms, dtype=np.float64))
    is_small = RESAMPLES * len(sums) <= _KEPT_CELLS
    weights = _kept_weights if is_small else _all_weights
    return np.concatenate(
        [statistic((weight @ sums).T) for weight in weights(len(sums))]
    )


def _body_sums(body: NDArray[np.generic], terms: Array) -> Array:
    """Sums (bodies, k) of the terms of each body."""
    row = np.unique(body, return_inverse=True)[1]
    return np.stack([np.bincount(row, weights=column) for column in terms.T], axis=1)


def _all_weights(bodies: int) -> Iterator[Array]:
    """Weights of all resamples, a bounded number at a time."""
    generator = np.random.default_rng(0)
    step = max(1, _CELLS // bodies)
    for first in range(0, RESAMPLES, step):
        yield _weights(generator, min(step, RESAMPLES - first), bodies)


@lru_cache(maxsize=1)
def _kept_weights(bodies: int) -> tuple[Array, ...]:
    """The same weights, remembered, since a table asks for them many times."""
    return tuple(_all_weights(bodies))


def _weights(generator: np.random.Generator, resamples: int, bodies: int) -> Array:
    """How often each body is in each resample (resamples, bodies): multinomial."""
    choice: Index = generator.integers(bodies, size=(resamples, bodies))
    choice += bodies * np.arange(resamples)[:, None]
    counts = np.bincount(choice.ravel(), minlength=resamples * bodies)
    return counts.reshape(resamples, bodies).astype(np.float64)
