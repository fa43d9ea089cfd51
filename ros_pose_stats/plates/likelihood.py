"""How well scenes explain counts, and what that leaves of the restitution and the drop height.

A real plate differs from the model, and not by chance: the shares of a part scatter around those
of the best scene. The likelihood averages over how widely (`SCATTERS`), so that counts which no
scene explains widen the intervals by themselves, and counts that one explains do not.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaln

from . import response, scenes

Array = NDArray[np.float64]

SCATTERS = np.array([0.0, 0.01, 0.02, 0.04, 0.08, 0.16])
"""By how much a share of one half may be off on a real plate; one of p by sqrt(4 p (1 - p)) of
that. Each is as likely beforehand as all that exceed it, and the model as all of them."""

WEIGHTS = np.array([0.5, 0.25, 0.125, 0.0625, 0.03125, 0.03125])

REACH = 2.7055
"""Twice the fall of the logarithm of the likelihood at the bounds of a 90 % interval."""


def scene_likelihood(counts: Array, shares: response.Shares) -> Array:
    """Logarithm (S, n) of the likelihood of one part's counts (G,), by scatter and scene."""
    dispersion = shares.dispersion + 4.0 * np.square(SCATTERS)[:, None]
    return log_likelihood(counts, shares.share, np.minimum(dispersion, 0.5))


def averaged(likelihoods: Array) -> Array:
    """Logarithm (n,) of the likelihood of parts together (S, n), over the scatters."""
    weighed = likelihoods + np.log(WEIGHTS)[:, None]
    top = weighed.max(axis=0)
    return np.asarray(top + np.log(np.exp(weighed - top).sum(axis=0)))


class SceneEstimate(NamedTuple):
    """The most likely scene."""

    place: int  # on the grid
    restitution: tuple[float, float, float]  # value and bounds of the 90 % interval; metres
    drop_height: tuple[float, float, float]


def most_likely(grid: scenes.SceneGrid, logarithm: Array) -> SceneEstimate:
    """The most likely scene, with intervals by the profile of the likelihood.

    The interval of one of the two holds the values at which some value of the other leaves the
    logarithm of the likelihood within `REACH` / 2 of its maximum (Wilks).

    `logarithm` (n,): of the likelihood.
    """
    table = logarithm.reshape(grid.shape)
    place = int(logarithm.argmax())
    row, column = divmod(place, grid.shape[1])
    low, high = _bounds(grid.restitution, table.max(axis=1))
    lowest, highest = np.exp(_bounds(grid.log_height, table.max(axis=0))).tolist()
    return SceneEstimate(place, (float(grid.restitution[row]), low, high),
                         (float(np.exp(grid.log_height[column])), lowest, highest))


def plausible_bounds(grid: scenes.SceneGrid, logarithm: Array, fall: float) -> Array:
    """Smallest box (2, 2) around the scenes whose likelihood's logarithm falls by at most that.

    It is wider by a step of the grid on each side.
    """
    points = grid.points[logarithm >= logarithm.max() - fall]
    found = []
    for axis, values in enumerate((grid.restitution, grid.log_height)):
        first, last = np.searchsorted(values, (points[:, axis].min(), points[:, axis].max()))
        found.append((values[max(first - 1, 0)], values[min(last + 1, values.size - 1)]))
    return np.array(found).T


def _bounds(values: Array, profile: Array) -> tuple[float, float]:
    """Outermost values at which a profile crosses its level, linear between grid values."""
    level = profile.max() - 0.5 * REACH
    inside = np.flatnonzero(profile >= level)
    ends = []
    for edge, step in ((inside[0], -1), (inside[-1], 1)):
        beyond = edge + step
        if not 0 <= beyond < values.size:
            ends.append(float(values[edge]))
            continue
        share = (profile[edge] - level) / (profile[edge] - profile[beyond])
        ends.append(float(values[edge] + share * (values[beyond] - values[edge])))
    return ends[0], ends[1]


LEAST_DISPERSION = 1e-9
"""Below it the counts are multinomial to all digits that matter."""

LEAST_SHARE = 1e-12
"""A share that was never met may still occur."""


def log_likelihood(counts: ArrayLike, shares: ArrayLike,
                   dispersion: ArrayLike) -> NDArray[np.float64]:
    """Logarithm of the probability of counts, less what depends on the counts alone.

    The shares p that the counts follow scatter around those expected with the variance
    p (1 - p) × dispersion; at dispersion 0 the counts are multinomial.

    `counts` (G,): at least 0; `shares` (..., G): expected, summing to 1; `dispersion` (...): 0 to
    below 1. Returns (...).
    """
    of = np.asarray(counts, dtype=np.float64)
    expected = np.maximum(np.asarray(shares, dtype=np.float64), LEAST_SHARE)
    spread = np.asarray(dispersion, dtype=np.float64)
    # Below this dispersion the differences of log-gammas lose more digits than they gain.
    total = 1.0 / np.maximum(spread, LEAST_DISPERSION) - 1.0
    alpha = expected * total[..., None]
    met = of > 0.0
    found = (gammaln(alpha[..., met] + of[met]) - gammaln(alpha[..., met])).sum(axis=-1)
    found -= gammaln(total + of.sum()) - gammaln(total)
    plain = (of[met] * np.log(expected[..., met])).sum(axis=-1)
    return np.asarray(np.where(spread <= LEAST_DISPERSION, plain, found))
