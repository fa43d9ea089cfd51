"""Fits and judges what estimates tell of their error on parts that rock on a curve.

.venv/bin/python -m lab.training.rocking              8 bodies a family, some minutes
.venv/bin/python -m lab.training.rocking --write      writes docs/measured/rocking.md, too
"""

import argparse
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from ros_pose_stats import simulate
from ros_pose_stats.core.estimators.expected import (
    ROCKING as SHIPPED,
    expected_error,
    largest_of,
    rocking_errors,
)
from ros_pose_stats.core.estimators.fitted import ERROR_FITS
from ros_pose_stats.core.estimators.split import ACROSS, split
from ros_pose_stats.core.records import Array, DropScene
from study.output import markdown_table, points, write_page

from .families import CURVED, ROCKING, family_part, family_poses
from .lopsided import DOCS

SERIES = 4711
DROPS = 400
RESTITUTIONS = (0.2, 0.5, 0.8)
HEIGHTS = (20.0, 2.0)
BOUNDS = (0.01, 5.0)
BOUNDS_ACROSS = (0.0, 40.0)
"""Of the coefficient of expected errors, and of the effect of curves across a pose."""


class Case(NamedTuple):
    """A part in a scene: mean squares over the poses, as fractions."""

    family: str
    share: Array  # counted (P,)
    plain: Array  # estimated without what curves across a pose change
    across: Array  # how far they lie there
    seen: float  # difference of estimate and counted shares
    noise: float  # of the drops
    before: float  # expected, without what rocking may change
    rocking: float  # that, for a coefficient of 1
    kept: (
        bool  # whether the largest difference is within its bound, widened by the noise
    )

    def told(self, coefficient: float) -> float:
        """The expected mean square."""
        return self.before + coefficient**2 * self.rocking

    def true(self, across: float) -> float:
        """Mean square error with so strong an effect of curves across, without the noise."""
        odds = self.plain * np.exp(-across * self.across)
        return float(np.mean(np.square(odds / odds.sum() - self.share))) - self.noise


def measure(family: str, number: int) -> list[Case]:
    """Estimate and drop a body at every restitution, from one of the heights."""
    part = family_part(family, SERIES, number)
    cases = []
    resting = family_poses(family, part)
    for restitution in RESTITUTIONS:
        scene = DropScene(
            restitution, HEIGHTS[number % len(HEIGHTS)] * resting.body.radius
        )
        told = split(resting, scene)
        expected = expected_error("split", resting, told, scene)
        found = simulate(part, DROPS, restitution, number, scene.drop_height, workers=1)
        count = np.zeros(told.size)
        count[[pose.index for pose in found.poses]] = [
            pose.count for pose in found.poses
        ]
        drops = count.sum()
        share = count / drops
        likely = (count + 0.5) / (drops + 1.0)
        bound = largest_of(
            expected.each,
            resting.group,
            ERROR_FITS["split"],
            likely * (1.0 - likely) / drops,
        )
        own = float(np.mean(np.square(rocking_errors(resting, told))))
        across = resting.curves[1]
        plain = told * np.exp(ACROSS * (across - across.max()))
        cases.append(
            Case(
                family,
                share,
                plain,
                across,
                float(np.mean(np.square(share - told))),
                float(np.mean(share * (1.0 - share))) / (drops - 1.0),
                expected.here**2 - own,
                own / SHIPPED**2,
                bool(np.abs(share - told).max() <= bound),
            )
        )
    return cases


def fit(cases: Sequence[Case]) -> float:
    """The likeliest coefficient; square errors scatter exponentially about the expected ones."""

    def unlikely(coefficient: float) -> float:
        whole = [one.told(coefficient) + one.noise for one in cases]
        return sum(
            math.log(all_) + one.seen / all_
            for all_, one in zip(whole, cases, strict=True)
        )

    return float(minimize_scalar(unlikely, bounds=BOUNDS, method="bounded").x)


def fit_across(cases: Sequence[Case]) -> float:
    """The effect of curves across a pose with the least square error."""

    def square(across: float) -> float:
        return sum(one.true(across) for one in cases)

    return float(minimize_scalar(square, bounds=BOUNDS_ACROSS, method="bounded").x)


def row(name: str, some: Sequence[Case], others: Sequence[Case]) -> list[str]:
    """True and told errors of some cases, and true ones with the effect fitted to other cases."""

    def root(squares: Sequence[float]) -> float:
        return math.sqrt(max(float(np.mean(squares)), 0.0))

    true = root([one.seen - one.noise for one in some])
    told = root([one.told(SHIPPED) for one in some])
    effect = fit_across(others)
    twice = np.mean([one.seen > 4.0 * one.told(SHIPPED) + one.noise for one in some])
    return [
        name,
        f"{len(some)}",
        *(points(root([one.true(each) for one in some])) for each in (0.0, effect)),
        points(true),
        points(root([one.before for one in some])),
        points(told),
        f"{true / told:.2f}",
        points(float(twice), 0),
        points(float(np.mean([one.kept for one in some])), 0),
    ]


def page(cases: Sequence[Case], bodies: int) -> str:
    """The page docs/measured/rocking.md."""
    rows = [
        row(
            family,
            [one for one in cases if one.family == family],
            [one for one in cases if one.family != family],
        )
        for family in (*ROCKING, *CURVED)
    ]
    head = (
        "family",
        "cases",
        "without it, points",
        "held out",
        "true",
        "told without rocking",
        "told",
        "true over told",
        "over twice, %",
        "largest error kept, %",
    )
    return HEAD.format(
        bodies=bodies,
        drops=DROPS,
        shipped=SHIPPED,
        fitted=fit(cases),
        across=ACROSS,
        best=fit_across(cases),
    ) + (markdown_table(head, [*rows, row("all", cases, cases)]) + "\n")


HEAD = """# Parts that rock on a curve

Written by `python -m lab.training.rocking --write`; edits here are lost. {bodies} bodies a
family, {drops} drops at restitution 0.2, 0.5 and 0.8, from 20 or 2 radii. The networks of `split`
know none of these families.

Rocking on a curve is a turn about its generators. It lasts while all other motion dies: narrow
facets take little of its energy, and without friction nothing turns it about another axis. So a
part does not lie down where the generators stand on end (a lens on its flat sides). `split`
multiplies odds by exp(-{across:g} x); x is the solid angle of facets to rock on that lead to
other poses, each times the share of energy that they leave in a radian, times the share of a blow
that becomes a turn about the generator, times the square of its component along the pose's
vertical, over all that leads to other poses. *Without it*: true errors of the networks
alone. The best number for all is {best:.1f}; *held out*: with the best for all other families.

*True* is the root mean square error over all poses, the noise of the drops taken off; *told* the
expected error, without and with what rocking adds: {shipped:g} sqrt(p) |c² - mean c²| for each
pose, where c is the share of curves in the solid angle that leads to it; the likeliest factor here
is {fitted:.2f}.

What did not pay, judged on families held out: a network of the inputs and the curved share added
to the weights; what is lost in the wells on both sides of a saddle, as a factor of the weights;
the energy that impacts take in a component as its weight, the more flats and surfaces curved both
ways a part has: better for cut eggs and slices, but far off for half balls, which turn in one
plane, and wedges, and a corner more on the rim of a flat, or a facet that breaks in two, moves it;
odds of curves changed by restitution, height, barrier and area; partial rims counted by facets a
turn, by their share of a turn, or not at all.

"""


def main() -> None:
    """Measure, print the page, and write it where that is asked."""
    parser = argparse.ArgumentParser(
        prog="lab.training.rocking", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument(
        "--bodies", type=int, default=8, help="a family (default: %(default)s)"
    )
    parser.add_argument(
        "--write", action="store_true", help="write what is found to its place"
    )
    options = parser.parse_args()
    text = page(
        [
            case
            for family in (*ROCKING, *CURVED)
            for number in range(options.bodies)
            for case in measure(family, number)
        ],
        options.bodies,
    )
    print(text)
    if options.write:
        write_page(DOCS, "rocking.md", text, {}, {})


if __name__ == "__main__":
    main()
