"""Smooth functions fitted to binomial counts: a Gaussian process with Laplace's approximation.

The logit of the probability is a known function plus a smooth correction (Rasmussen and Williams,
Gaussian Processes for Machine Learning, 2006, section 3.4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STEPS = 30
"""Most steps of Newton's method; five to ten are usual."""

SETTLED = 1e-8
"""Change of a logit at which they end."""


class Kernel(NamedTuple):
    """Covariance of the correction: a constant, and a part that varies (Matérn, order 3/2).

    Attributes
    ----------
    constant, varying : float
        Standard deviations, of the logit.
    lengths : (d,) array
        Over which the varying part changes, in each coordinate.
    """

    constant: float
    varying: float
    lengths: Array

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

    Parameters
    ----------
    points : (n, d) array
        Where was counted.
    successes, trials : (n,) arrays
    offset : (n,) array
        Logit of the known function there.
    kernel : Kernel
    """

    def __init__(self, points: Array, successes: Array, trials: Array, offset: Array,
                 kernel: Kernel) -> None:
        self._points, self._kernel = points, kernel
        covariance = kernel(points, points)
        correction = np.zeros(points.shape[0])
        for _ in range(STEPS):
            share = _logistic(offset + correction)
            weight = trials * share * (1.0 - share)
            slope = successes - trials * share
            root, factor = _factor(covariance, weight)
            aim = weight * correction + slope
            inner = np.linalg.solve(factor, root * (covariance @ aim))
            scaled = aim - root * np.linalg.solve(factor.T, inner)
            moved = covariance @ scaled
            # The logit of a rare pose may overshoot where its known function is far off.
            step = np.clip(moved - correction, -4.0, 4.0)
            correction = correction + step
            if np.abs(step).max() < SETTLED:
                break
        share = _logistic(offset + correction)
        self._slope = successes - trials * share
        self._root, self._factor = _factor(covariance, trials * share * (1.0 - share))

    def predict(self, points: Array) -> tuple[Array, Array]:
        """Mean and variance (n,) of the correction at points (n, d)."""
        cross = self._kernel(points, self._points)
        inner = np.linalg.solve(self._factor, (cross * self._root).T)
        prior = self._kernel.constant ** 2 + self._kernel.varying ** 2
        return cross @ self._slope, np.maximum(prior - (inner * inner).sum(axis=0), 0.0)


def _factor(covariance: Array, weight: Array) -> tuple[Array, Array]:
    root = np.sqrt(weight)
    return root, np.linalg.cholesky(np.eye(root.shape[0]) + np.outer(root, root) * covariance)


def _logistic(logit: Array) -> Array:
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(logit, -40.0, 40.0))))
