"""How often a part comes to rest in each group of its poses, at any restitution and height.

The estimator `split` is near the truth and smooth; drops at some scenes say how far off it is
there, and a Gaussian process carries that to the scenes between: the logit of a probability is a
known function plus a smooth correction, fitted to binomial counts by Laplace's approximation
(Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, section 3.4).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ..estimators.split import split
from ..records import Array, DropScene
from ..simulation import request, simulate
from .counts import CountedPart
from .scenes import SceneGrid, SceneRange

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


KERNEL = Kernel(1.0, 0.4, np.array([0.3, 0.7]))
"""Of the correction of `split`, in the coordinates of `Response._places`. These predict drops of
prisms, boxes and a hexagonal prism best that were held out."""

TOUCHING, STEEPNESS = 0.72, 3.5
"""How probabilities swing with the height depends on how high a part bounces: the swings lie at
equal values of log(height in radii - TOUCHING) + STEEPNESS × restitution."""

TABLE = 24
"""Values of restitution and height at which `split` is computed; it is linear in between."""

RAREST = 1e-6
"""Least share of which a logit is taken."""


class Shares(NamedTuple):
    """Expected shares of the groups at some scenes."""

    share: Array  # (n, G); summing to 1
    # (n,); their variance over share × (1 - share): one over the drops that would tell as much
    dispersion: Array


class Response:
    """Shares of one part's groups of poses, learnt from drops.

    Attributes `drops`: so far.
    """

    def __init__(self, counted: CountedPart, within: SceneRange, seed: tuple[int, ...]) -> None:
        self._counted, self._seed = counted, seed
        self._group = counted.resting.group
        self._grid = SceneGrid.over(within.bounds, TABLE)
        self._table = np.array([self._split_logit(point) for point in self._grid.points])
        self.drops = 0
        self._points: list[Array] = []
        self._drops: list[Array] = []
        self._processes: list[BinomialProcess] = []

    def add_drops(self, points: Array, drops: int, workers: int | None = None,
                  should_stop: Callable[[], bool] | None = None, *,
                  background: bool = False) -> None:
        """Drop the part some times at each of the points (n, 2), and learn from it.

        A drop that does not settle is left out. After a stop the points that were finished count.
        """
        for point in points:
            seed = np.random.SeedSequence((*self._seed, len(self._points)))
            found = simulate.count_drops(
                self._counted.part, self._scene(point),
                request.drop_request(drops, int(seed.generate_state(1, np.uint64)[0]),
                                     workers=workers),
                request.Watch.of(None, should_stop, None, background))
            if found.drops < drops:
                break
            count = np.zeros(len(found.poses))
            count[[pose.index for pose in found.poses]] = [pose.count for pose in found.poses]
            self.drops += drops
            self._points.append(point)
            self._drops.append(np.bincount(self._group, count).astype(np.float64))
        if self._points:
            self._learn()

    def shares_at(self, points: Array) -> Shares:
        """Expected shares at points (n, 2)."""
        logit, variance = self._split_logits(points), np.zeros((points.shape[0],
                                                                self._table.shape[1]))
        cross = KERNEL(self._places(points), self._places(np.array(self._points)))
        for group, process in enumerate(self._processes):
            mean, variance[:, group] = process.predict(cross, KERNEL.variance)
            logit[:, group] += mean
        share = 1.0 / (1.0 + np.exp(-logit))
        share /= share.sum(axis=1, keepdims=True)
        scatter = share * (1.0 - share)
        error = (scatter * scatter * variance).sum(axis=1)
        return Shares(share, error / np.maximum(scatter.sum(axis=1), RAREST))

    def _learn(self) -> None:
        """Fit the correction of each group anew."""
        points, drops = np.array(self._points), np.array(self._drops)
        settled, logit = drops.sum(axis=1), self._split_logits(points)
        places = self._places(points)
        covariance = KERNEL(places, places)
        self._processes = [
            BinomialProcess(covariance, drops[:, group], settled, logit[:, group])
            for group in range(drops.shape[1])]

    def _places(self, points: Array) -> Array:
        """Coordinates (n, 2) in which the correction varies evenly."""
        radii = np.exp(points[:, 1]) / self._counted.resting.body.radius
        rise = np.maximum(radii - TOUCHING, 0.02)
        return np.stack((points[:, 0], np.log(rise) + STEEPNESS * points[:, 0]), axis=1)

    def _scene(self, point: Array) -> DropScene:
        return DropScene(float(point[0]), math.exp(point[1]), self._counted.cluster_tolerance,
                         self._counted.round_sides)

    def _split_logit(self, point: Array) -> Array:
        share = np.bincount(self._group, split(self._counted.resting, self._scene(point)))
        share = np.clip(share, RAREST, 1.0 - RAREST)
        return np.log(share / (1.0 - share))

    def _split_logits(self, points: Array) -> Array:
        """The table (n, G) between its values."""
        table = self._table.reshape(TABLE, TABLE, -1)
        place, part = [], []
        for axis, values in enumerate((self._grid.restitution, self._grid.log_height)):
            at = (points[:, axis] - values[0]) / (values[-1] - values[0]) * (TABLE - 1)
            place.append(np.clip(at.astype(np.int64), 0, TABLE - 2))
            part.append((at - place[-1])[:, None])
        (i, j), (u, v) = place, part
        return np.asarray((1.0 - u) * ((1.0 - v) * table[i, j] + v * table[i, j + 1])
                          + u * ((1.0 - v) * table[i + 1, j] + v * table[i + 1, j + 1]))
