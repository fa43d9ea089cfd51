"""The bootstrap by whole bodies: scatter of a figure over other choices of the bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ros_pose_stats.base.errors import RequestError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

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
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> Array:
    """Values of a statistic on resamples of the bodies, drawn with replacement.

    All values of a body are drawn or left out together, its poses and its restitutions: they
    are dependent, as section 4.A of the paper notes below Eq. 2. The statistic sees sums over
    the values only, so that a resample costs no more than one weight a body: Efron and
    Tibshirani, "An Introduction to the Bootstrap" (1993), chapter 6 and section 8.3 for
    groups.

    Parameters
    ----------
    body : (N,) array of int
        Number of the body that each value belongs to.
    terms : (N, k) array
        Summands; finite. As bodies have different numbers of poses, N differs between
        resamples: where the statistic divides by it, one of the terms must be 1.
    statistic : callable
        Given the sums (k, R) of R resamples, gives their R values.
    resamples : int
        From 2 up.
    seed : int
        From 0 up. The same seed draws the same bodies for a given version of numpy, whatever
        the order of the values.

    Returns
    -------
    (resamples,) array

    Raises
    ------
    RequestError
        If there are no values, not as many bodies as terms, or a number is out of its range.
    """
    sums = _body_sums(np.asarray(body), np.asarray(terms, dtype=np.float64))
    if resamples < 2 or seed < 0:
        raise RequestError(
            "2 resamples at least and a seed from 0 up",
            f"{resamples} and {seed}",
            "1000 resamples give an error to 2 %",
        )
    few = resamples * len(sums) <= _KEPT_CELLS
    weights = _kept_weights if few else _all_weights
    return np.concatenate(
        [statistic((some @ sums).T) for some in weights(len(sums), resamples, seed)]
    )


def _body_sums(body: NDArray[np.generic], terms: Array) -> Array:
    """Sums (bodies, k) of the terms of each body."""
    if (
        body.ndim != 1
        or body.dtype.kind not in "iu"
        or terms.ndim != 2
        or not body.size
        or len(body) != len(terms)
        or not np.isfinite(terms).all()
    ):
        raise RequestError(
            "finite terms (N, k) and the number of the body of each, N from 1 up",
            f"{terms.shape} of {body.shape} bodies of {body.dtype}",
            "give one row of terms a value",
        )
    row = np.unique(body, return_inverse=True)[1]
    return np.stack([np.bincount(row, weights=column) for column in terms.T], axis=1)


def _all_weights(bodies: int, resamples: int, seed: int) -> Iterator[Array]:
    """Weights of all resamples, a bounded number at a time."""
    generator = np.random.default_rng(seed)
    step = max(1, _CELLS // bodies)
    for done in range(0, resamples, step):
        yield _weights(generator, min(step, resamples - done), bodies)


@lru_cache(maxsize=1)
def _kept_weights(bodies: int, resamples: int, seed: int) -> tuple[Array, ...]:
    """The same weights, remembered, since a table asks for them many times."""
    return tuple(_all_weights(bodies, resamples, seed))


def _weights(generator: np.random.Generator, resamples: int, bodies: int) -> Array:
    """How often each body is in each resample (resamples, bodies): multinomial."""
    drawn: Index = generator.integers(bodies, size=(resamples, bodies))
    drawn += bodies * np.arange(resamples)[:, None]
    counts = np.bincount(drawn.ravel(), minlength=resamples * bodies)
    return counts.reshape(resamples, bodies).astype(np.float64)
