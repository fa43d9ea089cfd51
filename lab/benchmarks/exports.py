"""One part exported with 16 to 2048 sides a turn: poses, estimates and drops beside
each other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2_contingency

from lab.bodies import exports, shapes
from lab.bodies.variants import in_float32
from lab.frame.page import Page
from lab.frame.results import Row, Section, Target
from ros_pose_stats import PoseStatistics, estimate, part_from_mesh, simulate
from ros_pose_stats.core.statistics.chi_square import SMALLEST_EXPECTED

from .program import benchmark_parser, run_benchmark

Array = NDArray[np.float64]

EXPORTS = Page(
    "exports.md",
    """# One part, many exports

Written by `python -m lab.benchmarks.exports --write`; edits here are lost.

A CAD program divides a round surface into flat facets, more or fewer as its settings say. A part
that rolls loses energy at each facet, so that drops and estimates of the file as it is depend on
its division. Here round surfaces are taken as polygons of 192 sides a turn, whatever the file
has; the tables say what is left of the difference, and how near thrown parts are.
""",
    ("exports",),
)

SIDES = (16, 24, 32, 64, 128, 512, 2048)
METHODS = ("split", "meae")
ESTIMATED = 0.5
DROPPED = 1.5
LEAST_CHANCE = 0.001
"""Aims: points between estimates, points between drops beyond noise, chi-square
probability.
"""

SAME_KIND = 0.02
"""Distance in height (over the radius) and in the vertical of `down` between like
poses.
"""


@dataclass(frozen=True)
class Exports:
    """A body as several files.

    Attributes
    ----------
    name : str
    make : callable
        Surface from the number of sides a turn and the angle at which they begin.
    sides : tuple of int
    """

    name: str
    make: Callable[[int, float], shapes.Surface]
    sides: tuple[int, ...] = SIDES


BODIES = (
    *(
        Exports(
            f"cylinder h/d {ratio:g}",
            partial(
                lambda sides, start, ratio: exports.cylinder(sides, ratio, start),
                ratio=ratio,
            ),
        )
        for ratio in (0.3, 0.5, 1.0, 3.0)
    ),
    Exports("ring", exports.tube),
    Exports("bearing ring, chamfered", exports.ring),
    Exports("stepped shaft", exports.shaft),
    Exports("cone frustum", exports.frustum),
    Exports("screw, hexagon head", exports.screw),
    Exports(
        "filleted box",
        lambda sides, _: exports.filleted_box(sides),
        (16, 24, 32, 64, 128),
    ),
)

PUBLISHED = (
    ("thick coin h/d 0.354", 0.354, "86.8"),
    ("thick coin h/d 0.577", 0.577, "59.0"),
    ("cylinder h/d 1", 1.0, "24 and 38"),
)
"""Name, height over diameter, and the share of both ends in per cent that throwers
counted.
"""

COMPARED = (
    "Each body is exported with {sides} sides a turn (fillets up to 128), as float32 "
    "and begun at a random angle, and taken at default settings. `poses`: the lists, "
    "of all exports. `split`, `meae`: the largest difference between two exports in "
    "the probability of one kind of pose, in points (poses that are alike by height "
    "and tilt are one kind). Then {drops} drops of each export at restitution 0.5: "
    "`drops`, the largest such difference between them; `noise`, the largest that "
    "chance alone would give on the average; `beyond`, the standard deviation among "
    "the exports of the worst kind, less that of chance; `p`, the probability of "
    "chi-square that all have the same probabilities."
)

THROWN = (
    "Both ends together in {drops} drops at default settings (restitution 0.5, "
    "released at rest from 20 radii, 192 sides a turn), with the standard error of the "
    "counts, beside what was counted in throws. Published for a height equal to the "
    "diameter are 38 % for thick and 24 % for thin glass."
)


def compare(bodies: Sequence[Exports], drops: int) -> Section:
    """Table with a row for each body."""
    rng = np.random.default_rng(20)
    rows = tuple(_row(body, drops, rng) for body in bodies)
    sides = ", ".join(map(str, bodies[0].sides))
    return Section(
        "exports",
        "One part, many exports",
        COMPARED.format(sides=sides, drops=drops),
        rows,
    )


def _row(body: Exports, drops: int, rng: np.random.Generator) -> Row:
    exported_parts = [
        part_from_mesh(*in_float32(body.make(sides, float(rng.uniform(0.0, 6.0)))))
        for sides in body.sides
    ]
    answers = {
        method: [estimate(part, method) for part in exported_parts]
        for method in METHODS
    }
    kinds = _kinds(answers["meae"][0])
    lists = {_list(kinds, answer) for answer in answers["meae"]}
    spreads = {
        method: _spread(
            np.array([_of_kinds(kinds, answer) for answer in method_answers])
        )
        for method, method_answers in answers.items()
    }
    counted = [simulate(part, drops, seed=k) for k, part in enumerate(exported_parts)]
    shares = np.array([_of_kinds(kinds, answer) for answer in counted])
    mean = shares.mean(axis=0)
    variance = mean * (1.0 - mean) / drops
    excess = np.maximum(shares.var(axis=0, ddof=1) - variance, 0.0)
    beyond = 100.0 * float(np.sqrt(excess.max()))
    chance = _chance(np.rint(shares * drops))
    return Row(
        body.name,
        {
            "exports": len(exported_parts),
            "poses": " or ".join(
                "+".join(map(str, pose_list)) for pose_list in sorted(lists)
            ),
            **{
                f"{method}, points": method_answers
                for method, method_answers in spreads.items()
            },
            "drops, points": _spread(shares),
            "noise, points": 100.0
            * _usual_range(len(exported_parts))
            * float(np.sqrt(variance.max())),
            "beyond, points": beyond,
            "p": chance,
        },
        (
            Target("lists", float(len(lists)), 2.0),
            *(
                Target(f"{method}, points", method_answers, ESTIMATED)
                for method, method_answers in spreads.items()
            ),
            Target("drops beyond noise, points", beyond, DROPPED),
            Target("p", chance, LEAST_CHANCE, at_least=True),
        ),
    )


def _kinds(answer: PoseStatistics) -> Array:
    """Height over the radius and vertical of `down` (K, 2) of poses that differ."""
    kinds: list[Array] = []
    for features in _seen(answer):
        if all(np.abs(features - kind).max() > SAME_KIND for kind in kinds):
            kinds.append(features)
    return np.array(sorted(map(tuple, kinds)))


def _seen(answer: PoseStatistics) -> Array:
    """What poses are told apart by, (P, 2)."""
    largest = max(pose.height for pose in answer.poses)
    return np.array([(pose.height / largest, pose.down[2]) for pose in answer.poses])


def _kind_of(kinds: Array, answer: PoseStatistics) -> NDArray[np.int64]:
    """Kind (P,) of each pose; one more than there are for a pose that is none of
    them.
    """
    gap = np.abs(_seen(answer)[:, None] - kinds).max(axis=2)
    return np.where(gap.min(axis=1) <= SAME_KIND, gap.argmin(axis=1), len(kinds))


def _list(kinds: Array, answer: PoseStatistics) -> tuple[int, ...]:
    """How many poses there are of each kind."""
    numbers: list[int] = np.bincount(
        _kind_of(kinds, answer), minlength=len(kinds)
    ).tolist()
    return tuple(numbers)


def _of_kinds(pose_kinds: Array, answer: PoseStatistics) -> Array:
    """Probability (K + 1,) of each kind, and of all poses that are none."""
    return np.bincount(
        _kind_of(pose_kinds, answer),
        [pose.probability for pose in answer.poses],
        minlength=len(pose_kinds) + 1,
    ).astype(np.float64)


def _spread(shares: Array) -> float:
    """Largest difference between two rows, in points."""
    return 100.0 * float(np.ptp(shares, axis=0).max())


def _usual_range(count: int) -> float:
    """Mean range of so many normally distributed numbers, in standard deviations."""
    return float(
        np.ptp(np.random.default_rng(0).standard_normal((20_000, count)), axis=1).mean()
    )


def _chance(counts: Array) -> float:
    """Probability of chi-square that all rows (E, K) have one distribution."""
    enough = counts[:, counts.mean(axis=0) >= SMALLEST_EXPECTED]
    return float(chi2_contingency(enough)[1]) if enough.shape[1] > 1 else 1.0


def compare_with_throws(drops: int) -> Section:
    """Table of the published shares of both ends."""
    rows = []
    for name, ratio, published in PUBLISHED:
        statistics = simulate(
            part_from_mesh(*in_float32(exports.cylinder(64, ratio, 0.3))),
            drops,
            seed=1,
        )
        share = sum(
            pose.probability for pose in statistics.poses if abs(pose.down[2]) > 0.9
        )
        rows.append(
            Row(
                name,
                {
                    "published, %": published,
                    "drops, %": 100.0 * share,
                    "±": 100.0 * float(np.sqrt(share * (1.0 - share) / drops)),
                },
            )
        )
    return Section(
        "throws",
        "Thick coins beside what was thrown",
        THROWN.format(drops=drops),
        tuple(rows),
    )


def sections(drops: int, thrown: int) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    yield compare(BODIES, drops)
    yield compare_with_throws(thrown)


def main() -> None:
    """Read the arguments and compare."""
    parser = benchmark_parser("lab.benchmarks.exports", __doc__)
    parser.add_argument(
        "--drops", type=int, default=8000, help="of each export (default: %(default)s)"
    )
    parser.add_argument(
        "--thrown",
        type=int,
        default=10_000,
        help="of each published part (default: %(default)s)",
    )
    run_benchmark(
        parser, lambda options: sections(options.drops, options.thrown), EXPORTS
    )


if __name__ == "__main__":
    main()
