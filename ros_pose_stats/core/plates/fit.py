"""The restitution and the drop height that explain what was counted on a plate.

The estimator `split` gives each part's shares at every scene of a grid, and these how likely each
scene makes the counts. A real plate differs from the model, and the model from its estimate, by
more than chance: the likelihood averages over how widely shares scatter around those of a scene.
"""

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, gammaln, logsumexp

from ...base import errors, text
from ..estimators.expected import expected_error
from ..estimators.split import split
from ..records import Array, DropScene, Index
from ..records.scene import DEFAULT_PLATE_ERROR, DEFAULT_ROUND_SIDES, Numbering
from ..statistics.chi_square import goodness_of_fit
from .counts import CountedPart

FEWEST_COUNTS = 50  # parts of all kinds together

MOST_PARTS = 16
"""Kinds; those counted most. More of them hardly change a fit, and each takes its time."""

RESTITUTIONS = np.arange(19) / 20.0
HEIGHTS = 24
LOWEST_RADII = 0.75
HIGHEST_RADII = 100.0
"""Of the smallest part and of the largest: below, all parts touch the plate at release, and above
they forget the height."""

SIDES = (DEFAULT_ROUND_SIDES, 96, 384, 48)
"""Sides a turn that are looked at; of those as likely the first is taken."""

UNTOLD_SIDES = DEFAULT_ROUND_SIDES, min(SIDES), max(SIDES)
"""What counts without round parts say: nothing is excluded."""

DEFAULT_WEIGHT = 0.5  # of the default scene beforehand

SCATTERS = np.array([0.03, 0.04, 0.05, 0.06, 0.08, 0.16])
"""By how much an estimated share of one half may be off on a real plate; one of p by
sqrt(4 p (1 - p)) of that. `split` alone errs by the least."""

SCATTER_WEIGHTS = np.array([0.5, 0.25, 0.125, 0.0625, 0.03125, 0.03125])
"""Each is as likely beforehand as all that exceed it."""

REACH = 2.7055
"""Twice the fall of the logarithm of the likelihood at the bounds of a 90 % interval (Wilks)."""

UNTESTED = 0.1
"""Parts that the error of an unknown plate counts as, beside those that a fit was tested on;
chosen on plates that the study does not judge."""

LEAST_SHARE = 1e-12  # a share that was never met may still occur
AS_DEFAULT = -1.0  # drop height of the default scene: 20 radii of each part

Triple = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class PartEvidence:
    """What one part says about a plate."""

    part_id: str
    part_digest: str
    counted: int
    # indices of the poses of each group, whose poses look alike
    poses: tuple[tuple[int, ...], ...]
    observed: Array  # (G,); shares of the groups as counted, and in the fitted scene
    expected: Array
    error: float  # root mean square of their difference, the noise of the counts taken off; 0 to 1
    # numbers its poses; (P,): their probabilities in the scene that the other parts ask for, in
    # the default one where there are none; and the error there
    numbering: Numbering
    left_out: Array
    left_out_error: float


@dataclass(frozen=True, eq=False)
class PlateFit:
    """The scene that stands for a plate."""

    # effective value, and the bounds of its 90 % interval; the height in metres, or AS_DEFAULT
    restitution: Triple
    drop_height: Triple
    # effective sides a turn of round parts, and the least and most of those looked at that the
    # counts do not exclude
    round_sides: tuple[int, int, int]
    default_weight: float  # probability that the default scene explains the counts best
    # expected root mean square error, over groups of poses, on a part that was not counted
    plate_error: float
    p_value: (
        float  # of the counts in the fitted scene; NaN where nothing is left to test it
    )
    counted: int  # parts of all kinds
    parts: tuple[PartEvidence, ...]  # by digest
    seconds: float = math.nan

    @property
    def verdict(self) -> str:
        """In words, whether the default scene does as well."""
        how = "as well" if self.default_weight >= DEFAULT_WEIGHT else "less well"
        return (
            f"the default scene explains the counts {how} (probability "
            f"{self.default_weight:.2f})"
        )


class SceneGrid:
    """Scenes that a plate may stand for: the default one, then for each of some sides a grid."""

    def __init__(self, radii: Iterable[float], sides: Sequence[int]) -> None:
        known = list(radii)
        ends = LOWEST_RADII * min(known), HIGHEST_RADII * max(known)
        self.height: Array = np.geomspace(*ends, HEIGHTS, dtype=np.float64)
        self.sides = sides
        self.scenes = [
            DropScene(),
            *(
                DropScene(restitution, height, round_sides=each)
                for each in sides
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

    def __init__(self, counted: CountedPart, grid: SceneGrid) -> None:
        self.counted = counted
        self.count = counted.by_group
        self.rolls = rolls_about(counted)
        places = grid.scenes[1 : 1 + RESTITUTIONS.size * HEIGHTS]
        ways = {
            stands.numbering: _shares(stands, places)
            for stands in map(self.standing, grid.sides)
        }
        self.share = np.concatenate(
            (
                _shares(self.standing(SIDES[0]), [DropScene()]),
                *(ways[self.standing(sides).numbering] for sides in grid.sides),
            )
        )  # (n, G)
        # (S, n); logarithm
        self.likelihood = log_likelihood(self.count, self.share)

    def standing(self, sides: int) -> CountedPart:
        """The part with so many sides a turn, where that matters."""
        return self.counted.with_sides(sides) if self.rolls else self.counted

    @property
    def noise(self) -> float:
        """Mean square error over the groups by the chance of the counts."""
        smooth = (self.count + 0.5) / (self.count + 0.5).sum()
        return float((smooth * (1.0 - smooth)).mean() / max(self.count.sum() - 1, 1))

    def square_error(self, place: int) -> float:
        """Mean square error over the groups at a scene, less the noise: it may be below 0."""
        away = self.count / self.count.sum() - self.share[place]
        return float(np.square(away).mean() - self.noise)


def fit_plate(counted: Sequence[CountedPart]) -> PlateFit:
    """Fit restitution, drop height and what rolling loses to counts of one part or several.

    The fitted scene is the one, default or of the grid, whose shares are nearest to those averaged
    over all scenes by their probability. The same counts give the same fit to the last bit, in any
    order. Poses that look alike count together.
    """
    begin = time.perf_counter()
    told = choose_parts(counted)
    rounds = any(map(rolls_about, told))
    sides = SIDES if rounds else SIDES[:1]
    grid = SceneGrid([one.resting.body.radius for one in told], sides)
    parts = [ExplainedPart(one, grid) for one in told]
    logarithm, weight = weigh_scenes(parts, grid)
    place = nearest_scene(parts, weight)
    evidence: list[PartEvidence] = []
    tested: dict[str, tuple[float, float]] = {}  # weight and square error, by digest
    unknown = DEFAULT_PLATE_ERROR**2
    for one in parts:
        part = one.counted.part
        group = one.counted.resting.group
        others = [other for other in parts if other.counted.part.digest != part.digest]
        left = nearest_scene(others, weigh_scenes(others, grid)[1])
        tested[part.digest] = max(
            tested.get(part.digest, (0.0, 0.0)),
            (
                (unknown / (unknown + one.noise)) ** 2,
                one.square_error(left if others else place),
            ),
        )
        evidence.append(
            PartEvidence(
                part.part_id,
                part.digest,
                one.counted.counted,
                tuple(
                    tuple(np.flatnonzero(group == each).tolist())
                    for each in range(one.count.size)
                ),
                one.count / one.count.sum(),
                one.share[place],
                math.sqrt(max(one.square_error(place), 0.0)),
                one.counted.numbering,
                (one.share[left] / np.bincount(group))[group],
                math.sqrt(max(one.square_error(left), 0.0)),
            )
        )
    if len(tested) > 1:
        total = max(sum(of * square for of, square in tested.values()), 0.0)
        plate_square = (total + UNTESTED * unknown) / (
            sum(of for of, _ in tested.values()) + UNTESTED
        )
    else:  # the scene was fitted to this very part, which can only speak against the plate
        plate_square = max(unknown, tested.popitem()[1][1])
    found = grid.scenes[place]
    table = logarithm[1:].reshape(len(sides), RESTITUTIONS.size, HEIGHTS)
    profile = table.max(axis=(1, 2))
    likely = [
        found.round_sides,
        *np.array(sides)[profile >= profile.max() - 0.5 * REACH].tolist(),
    ]
    return PlateFit(
        _interval(RESTITUTIONS, table.max(axis=(0, 2)), found.restitution),
        _interval(grid.height, table.max(axis=(0, 1)), found.drop_height or AS_DEFAULT),
        (found.round_sides, min(likely), max(likely)) if rounds else UNTOLD_SIDES,
        float(weight[0]),
        math.sqrt(plate_square),
        _p_value(parts, place, grid),
        sum(one.counted for one in told),
        tuple(evidence),
        time.perf_counter() - begin,
    )


def choose_parts(counted: Iterable[CountedPart]) -> list[CountedPart]:
    """Parts that a fit can use, by digest; counts of equally numbered poses are added up."""
    added: dict[tuple[str, Numbering], CountedPart] = {}
    for one in counted:
        key = one.part.digest, one.numbering
        added[key] = (
            one
            if key not in added
            else replace(added[key], count=added[key].count + one.count)
        )
    merged = [added[key] for key in sorted(added)]
    told = sorted(
        (one for one in merged if one.counted and one.by_group.size > 1),
        key=lambda one: -one.counted,
    )[:MOST_PARTS]
    if not told:
        raise errors.RequestError(
            "counts of a part that can lie in two ways",
            text.listed([one.part.part_id for one in merged]) or "none",
            "count another part on this plate",
        )
    total = sum(one.counted for one in told)
    if total < FEWEST_COUNTS:
        raise errors.RequestError(
            f"at least {FEWEST_COUNTS} counted parts",
            f"{total}",
            f"count {FEWEST_COUNTS - total} more",
        )
    return [one for one in merged if one in told]


def rolls_about(one: CountedPart) -> bool:
    """Whether a part rolls on a full round surface, its poses numbered alike for all sides.

    The counts are by these numbers, so a part whose poses change with the sides cannot tell them.
    """
    own = one.resting
    return (
        any(pose.rolls for pose in own.poses)
        and any(run.full and run.kind == "round" for run in own.body.runs)
        and all(own.is_numbered_like(one.with_sides(sides).resting) for sides in SIDES)
    )


def _shares(counted: CountedPart, wanted: Sequence[DropScene]) -> Array:
    """Shares (n, G) of the groups by `split`."""
    resting = counted.resting
    return np.array(
        [np.bincount(resting.group, split(resting, scene)) for scene in wanted]
    )


def weigh_scenes(
    parts: Sequence[ExplainedPart], grid: SceneGrid
) -> tuple[Array, Array]:
    """Logarithm (n,) of the likelihood of all parts together, and the scenes' probabilities."""
    together = sum(
        (one.likelihood for one in parts), np.zeros((SCATTERS.size, grid.prior.size))
    )
    logarithm = np.asarray(logsumexp(together, axis=0, b=SCATTER_WEIGHTS[:, None]))
    weight = grid.prior * np.exp(logarithm - logarithm.max())
    return logarithm, weight / weight.sum()


def nearest_scene(parts: Sequence[ExplainedPart], weight: Array) -> int:
    """Place whose shares are nearest to the average over all scenes; without parts the first."""
    away = sum(
        (np.square(one.share - weight @ one.share).mean(axis=1) for one in parts),
        np.zeros(weight.size),
    )
    return int(away.argmin())


def _interval(values: Array, profile: Array, found: float) -> Triple:
    """A value with the outermost ones at which a profile crosses its level, linear between."""
    level = profile.max() - 0.5 * REACH
    inside = np.flatnonzero(profile >= level)
    first, last = inside[[0, -1]]
    low, high = (
        float(np.interp(level, profile[edge], values[edge]))
        for edge in ([max(first - 1, 0), first], [min(last + 1, values.size - 1), last])
    )
    return (
        (found, low, high)
        if found == AS_DEFAULT
        else (found, min(low, found), max(high, found))
    )


def _p_value(parts: Sequence[ExplainedPart], place: int, grid: SceneGrid) -> float:
    """Chance of counts this far from the scene, to which two or three numbers were fitted."""
    statistic = 0.0
    free = -2 - (len(grid.sides) > 1)
    scene = grid.scenes[place]
    for one in parts:
        resting = one.standing(scene.round_sides).resting
        probability = split(resting, scene)
        expected = expected_error("split", resting, probability, scene)
        test = goodness_of_fit(
            one.count, one.share[place], np.bincount(resting.group, expected.each)
        )
        if not test.too_few:
            statistic += test.statistic
            free += test.degrees_of_freedom
    return float(chdtrc(free, statistic)) if free > 0 else math.nan


def log_likelihood(counts: Index, shares: Array) -> Array:
    """Logarithm (S, n) of the likelihood of counts (G,) where shares (n, G) are expected.

    The true ones scatter around them as by a Dirichlet distribution.
    """
    met = counts > 0
    of = counts[met].astype(np.float64)
    expected = np.maximum(shares[:, met], LEAST_SHARE)
    total = 0.25 / np.square(SCATTERS)[:, None, None] - 1.0
    alpha = expected * total
    constant = gammaln(total + of.sum()) - gammaln(total)
    return np.asarray(
        (gammaln(alpha + of) - gammaln(alpha)).sum(axis=-1) - constant[..., 0]
    )
