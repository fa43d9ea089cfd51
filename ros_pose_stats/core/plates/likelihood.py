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

"""How likely scenes make what was counted of parts on a plate.

The estimator `split` gives each part's shares at every scene of a grid, and these how
likely each scene makes the counts. A real plate differs from the model, and the model
from its estimate, by more than chance: the likelihood averages over how widely shares
scatter around those of a scene.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.special import gammaln, logsumexp

from ..estimators.split import split
from ..records import Array, DropScene, Index
from ..records.scene import DEFAULT_ROUND_SIDES
from ..statistics.chi_square import distance_chance
from .counts import CountedPart

RESTITUTIONS = np.arange(19) / 20.0
HEIGHTS = 24
LOWEST_RADII = 0.75
HIGHEST_RADII = 100.0
"""Of the smallest part and of the largest: below, all parts touch the plate at release,
and above they forget the height."""

ROUND_SIDES = (DEFAULT_ROUND_SIDES, 96, 384, 48)
"""Sides a turn that are looked at; of those as likely the first is taken."""

DEFAULT_WEIGHT = 0.5  # of the default scene beforehand

SHARE_SCATTERS = np.array([0.03, 0.04, 0.05, 0.06, 0.08, 0.16])
"""By how much an estimated share of one half may be off on a real plate; one of p by
sqrt(4 p (1 - p)) of that. `split` alone errs by the least."""

SCATTER_STRENGTHS = 0.25 / np.square(SHARE_SCATTERS) - 1.0
"""Of the Dirichlet distributions with these scatters: the sums of their parameters."""

SCATTER_WEIGHTS = np.array([0.5, 0.25, 0.125, 0.0625, 0.03125, 0.03125])
"""Each is as likely beforehand as all that exceed it."""

SMALLEST_SHARE = 1e-12  # a share that was never met may still occur


class SceneGrid:
    """Scenes that may stand for a plate: the default one, then a grid for all sides."""

    def __init__(self, radii: Iterable[float], sides: Sequence[int]) -> None:
        known_radii = list(radii)
        height_range = LOWEST_RADII * min(known_radii), HIGHEST_RADII * max(known_radii)
        self.height: Array = np.geomspace(*height_range, HEIGHTS, dtype=np.float64)
        self.sides = sides
        self.scenes = [
            DropScene(),
            *(
                DropScene(restitution, height, round_sides=round_sides)
                for round_sides in sides
                for restitution in RESTITUTIONS.tolist()
                for height in self.height.tolist()
            ),
        ]
        count = len(self.scenes) - 1
        self.prior = np.append(
            DEFAULT_WEIGHT, np.full(count, (1.0 - DEFAULT_WEIGHT) / count)
        )


class ExplainedPart:
    """A counted part with its expected shares and its likelihood at all scenes."""

    def __init__(self, counted_part: CountedPart, grid: SceneGrid) -> None:
        self.counted_part = counted_part
        self._grid = grid
        self.group_counts = counted_part.by_group
        self.is_rolling = is_rolling_part(counted_part)
        grid_scenes = grid.scenes[1 : 1 + RESTITUTIONS.size * HEIGHTS]
        shares_by_numbering = {
            part.numbering: _group_shares(part, grid_scenes)
            for part in map(self.with_sides, grid.sides)
        }
        # (n, G)
        self.shares = np.concatenate(
            (
                _group_shares(self.with_sides(ROUND_SIDES[0]), [DropScene()]),
                *(
                    shares_by_numbering[self.with_sides(sides).numbering]
                    for sides in grid.sides
                ),
            )
        )
        # (S, n); logarithm
        self.likelihood = log_likelihood(self.group_counts, self.shares)

    @property
    def digest(self) -> str:
        """The part's own."""
        return self.counted_part.part.digest

    def with_sides(self, sides: int) -> CountedPart:
        """The part with so many sides a turn, where that matters."""
        if not self.is_rolling:
            return self.counted_part
        return self.counted_part.with_round_sides(sides)

    @property
    def noise(self) -> float:
        """Mean square error over the groups by the chance of the counts."""
        share = (self.group_counts + 0.5) / (self.group_counts + 0.5).sum()
        variance = (share * (1.0 - share)).mean()
        return float(variance / max(self.group_counts.sum() - 1, 1))

    def square_error(self, scene_number: int) -> float:
        """Mean square error over the groups at a scene, less the noise.

        It may be below 0.
        """
        observed = self.group_counts / self.group_counts.sum()
        errors = observed - self.shares[scene_number]
        return float(np.square(errors).mean() - self.noise)

    def chance_beside(self, others: "Sequence[ExplainedPart]") -> float:
        """Chance of counts as far from what other parts make likely.

        Averaged over all scenes and scatters by their probability after the others.
        """
        likelihood = joint_likelihood(others, self._grid)
        weight = np.exp(likelihood - likelihood.max()) * self._grid.prior
        weight *= SCATTER_WEIGHTS[:, None]
        total = self.group_counts.sum()
        distance = np.square(self.group_counts / total - self.shares).sum(axis=1)
        # Shares that scatter by a Dirichlet distribution vary like those of fewer
        # counts.
        strength = SCATTER_STRENGTHS[:, None]
        counts = total * (1.0 + strength) / (total + strength)
        chance = distance_chance(distance, self.shares, counts)
        return float((weight * chance).sum() / weight.sum())


def is_rolling_part(counted_part: CountedPart) -> bool:
    """Whether a part rolls on a full round surface, its poses alike for all sides.

    The counts are by these numbers, so a part whose poses change with the sides cannot
    tell them.
    """
    resting = counted_part.resting
    return (
        any(pose.rolls for pose in resting.poses)
        and any(run.full and run.kind == "round" for run in resting.body.runs)
        and all(
            resting.is_numbered_like(counted_part.with_round_sides(sides).resting)
            for sides in ROUND_SIDES
        )
    )


def _group_shares(counted_part: CountedPart, drop_scenes: Sequence[DropScene]) -> Array:
    """Shares (n, G) of the groups by `split`."""
    resting = counted_part.resting
    return np.array(
        [np.bincount(resting.group, split(resting, scene)) for scene in drop_scenes]
    )


def weigh_scenes(
    parts: Sequence[ExplainedPart], grid: SceneGrid
) -> tuple[Array, Array]:
    """Log likelihood (n,) of all parts together, and the scenes' probabilities."""
    likelihood = joint_likelihood(parts, grid)
    logarithm = np.asarray(logsumexp(likelihood, axis=0, b=SCATTER_WEIGHTS[:, None]))
    weight = grid.prior * np.exp(logarithm - logarithm.max())
    return logarithm, weight / weight.sum()


def joint_likelihood(parts: Sequence[ExplainedPart], grid: SceneGrid) -> Array:
    """Log likelihood (S, n) of all parts together, by scatter and scene."""
    return sum(
        (part.likelihood for part in parts),
        np.zeros((SHARE_SCATTERS.size, grid.prior.size)),
    )


def nearest_scene(parts: Sequence[ExplainedPart], weight: Array) -> int:
    """Number of the scene whose shares are nearest to the average over all scenes.

    Without parts it is the first.
    """
    distance = sum(
        (np.square(part.shares - weight @ part.shares).mean(axis=1) for part in parts),
        np.zeros(weight.size),
    )
    return int(distance.argmin())


def log_likelihood(counts: Index, shares: Array) -> Array:
    """Log likelihood (S, n) of counts (G,) where shares (n, G) are expected.

    The true ones scatter around them as by a Dirichlet distribution.
    """
    is_counted = counts > 0
    count = counts[is_counted].astype(np.float64)
    expected = np.maximum(shares[:, is_counted], SMALLEST_SHARE)
    total = SCATTER_STRENGTHS[:, None, None]
    alpha = expected * total
    normalization = gammaln(total + count.sum()) - gammaln(total)
    return np.asarray(
        (gammaln(alpha + count) - gammaln(alpha)).sum(axis=-1) - normalization[..., 0]
    )
