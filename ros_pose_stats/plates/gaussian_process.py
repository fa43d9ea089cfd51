"""Smooth functions fitted to binomial counts: a Gaussian process with Laplace's approximation.

The logit of the probability is a known function plus a smooth correction (Rasmussen and Williams,
Gaussian Processes for Machine Learning, 2006, section 3.4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

Array = NDArray[np.float64]

STEPS = 30
"""Most steps of Newton's method; five to ten are usual."""

SETTLED = 1e-8
"""Change of a logit at which they end."""


class Kernel(NamedTuple):
    """Covariance of the correction: a constant, and a part that varies (Matérn, order 3/2)."""

    constant: float  # standard deviations, of the logit
    varying: float
    lengths: Array  # (d,); over which the varying part changes, in each coordinate

    @property
    def variance(self) -> float:
        """At every point."""
        return self.constant ** 2 + self.varying ** 2

    def __call__(self, first: Array, second: Array) -> Array:
        """Covariance (n, m) of points (n, d) and (m, d)."""
        square = np.zeros((first.shape[0], second.shape[0]))
        for axis, length in enumerate(self.lengths.tolist()):
            apart = np.subtract.outer(first[:, axis], second[:, axis]) / length
            square += apart * apart
        far = np.sqrt(3.0 * square)
        return np.asarray(self.constant ** 2 + self.varying ** 2 * (1.0 + far) * np.exp(-far))


class BinomialProcess:
    """A correction fitted to counts.

    `covariance` (n, n): of the correction at the points where was counted; `successes, trials`
    (n,); `offset` (n,): logit of the known function there.
    """

    def __init__(self, covariance: Array, successes: Array, trials: Array,
                 offset: Array) -> None:
        correction = np.zeros(offset.shape[0])
        for _ in range(STEPS):
            share = _logistic(offset + correction)
            weight = trials * share * (1.0 - share)
            slope = successes - trials * share
            root, factor = _factor(covariance, weight)
            aim = weight * correction + slope
            inner = solve_triangular(factor, root * (covariance @ aim), lower=True)
            scaled = aim - root * solve_triangular(factor, inner, lower=True, trans="T")
            moved = covariance @ scaled
            # The logit of a rare pose may overshoot where its known function is far off.
            step = np.clip(moved - correction, -4.0, 4.0)
            correction = correction + step
            if np.abs(step).max() < SETTLED:
                break
        share = _logistic(offset + correction)
        self._slope = successes - trials * share
        self._root, self._factor = _factor(covariance, trials * share * (1.0 - share))

    def predict(self, cross: Array, prior: float) -> tuple[Array, Array]:
        """Mean and variance (m,) of the correction at other points.

        `cross` (m, n): covariance with the points where was counted.
        """
        inner = solve_triangular(self._factor, (cross * self._root).T, lower=True,
                                 overwrite_b=True, check_finite=False)
        variance: Array = np.maximum(prior - np.square(inner).sum(axis=0), 0.0)
        mean: Array = cross @ self._slope
        return mean, variance


def _factor(covariance: Array, weight: Array) -> tuple[Array, Array]:
    root = np.sqrt(weight)
    inner = np.eye(root.shape[0]) + np.outer(root, root) * covariance
    return root, np.asarray(np.linalg.cholesky(inner), dtype=np.float64)


def _logistic(logit: Array) -> Array:
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(logit, -40.0, 40.0))))
