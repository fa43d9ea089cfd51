"""The shortest interval that holds a share of a mixture of Beta distributions."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc

Array = NDArray[np.float64]

SMALLEST: Final = 1e-300

AROUND: Final = np.linspace(-4.0, 7.0, 67)
"""Where the distribution is looked at: standard deviations from the mean of each component."""

NEAR_NOTHING: Final = 10.0 ** np.arange(-8.0, 0.0)
"""And means of each component, for a rare pose whose density rises without bound towards 0."""

HALVINGS: Final = 16
"""Of the cell in which the upper end lies."""


def shortest_interval(weight: Array, mean: Array, variance: Array, level: float
                      ) -> tuple[Array, Array]:
    """Bounds between which the density is nowhere lower than outside.

    Where the density falls from 0 on the lower bound is 0, where it rises up to 1 the upper one
    is 1. The length is within a thousandth of the least one, but for a sharp kind beside a broad
    one: there it may be a few per cent more. What it holds is right.

    `weight` (K, P): of the K components of each of P distributions, summing to 1; `mean, variance`
    (K, P): of the components, 0 < mean < 1 and 0 < variance < mean (1 - mean); `level`: 0 < level
    < 1.
    """
    mirrored = (weight * mean).sum(axis=0) > 0.5
    low, high = _left(weight, np.where(mirrored, 1.0 - mean, mean), variance, level)
    return np.where(mirrored, 1.0 - high, low), np.where(mirrored, 1.0 - low, high)


def _left(weight: Array, mean: Array, variance: Array, level: float) -> tuple[Array, Array]:
    """The same of distributions whose mean is at most 1 / 2, so that only 0 may bind."""
    a, b = _beta_like(mean, variance)
    around = mean[..., None] + np.sqrt(variance)[..., None] * AROUND
    near = mean[..., None] * NEAR_NOTHING
    count = mean.shape[1]
    nodes = np.concatenate((around, near), axis=2).swapaxes(0, 1).reshape(count, -1)
    nodes = np.sort(np.clip(np.column_stack((np.zeros(count), nodes, np.ones(count))), 0.0, 1.0))
    mass = np.einsum("kp,kpn->pn", weight, betainc(a[..., None], b[..., None], nodes))
    low = np.array([_begin(x, y, level) for x, y in zip(nodes, mass, strict=True)])
    wanted = level + _mass(weight, a, b, low)
    cell = np.sum(mass < wanted[:, None], axis=1, keepdims=True).clip(1, nodes.shape[1] - 1)
    least, most = (np.take_along_axis(nodes, at, axis=1)[:, 0] for at in (cell - 1, cell))
    for _ in range(HALVINGS):
        middle = 0.5 * (least + most)
        short = _mass(weight, a, b, middle) < wanted
        least, most = np.where(short, middle, least), np.where(short, most, middle)
    return low, np.where(wanted < 1.0, most, 1.0)


def _begin(nodes: Array, mass: Array, level: float) -> float:
    """Where the shortest interval begins, by a parabola through the three shortest in a row."""
    begin = nodes[mass <= mass[-1] - level]
    ends = np.interp(mass[:begin.size] + level, mass, nodes)
    length = ends - begin
    best = int(np.argmin(length))
    if not 0 < best < begin.size - 1 or begin[best - 1] == begin[best]:
        return float(begin[best])
    x, y = begin[best - 1:best + 2], length[best - 1:best + 2]
    left, right = (y[0] - y[1]) / (x[1] - x[0]), (y[2] - y[1]) / max(x[2] - x[1], 1e-300)
    turn = 0.5 * (x[2] - x[0]) * left / (left + right) if left + right > 0.0 else 0.0
    return float(min(max(0.5 * (x[0] + x[1]) + turn, x[0]), x[2]))


def _mass(weight: Array, a: Array, b: Array, x: Array) -> Array:
    return np.asarray((weight * betainc(a, b, x)).sum(axis=0))


def _beta_like(mean: Array, variance: Array) -> tuple[Array, Array]:
    """Parameters (P,) of the Beta distributions of given moments; huge ones where certain."""
    total = mean * (1.0 - mean) / np.maximum(variance, SMALLEST) - 1.0
    return mean * total, (1.0 - mean) * total
