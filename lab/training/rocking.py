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
from ros_pose_stats.estimators.expected import (
    ROCKING as SHIPPED,
    expected_error,
    largest_of,
    rocking_errors,
)
from ros_pose_stats.estimators.fitted import ERROR_FITS
from ros_pose_stats.estimators.split import ACROSS, MIXED, split
from ros_pose_stats.records import Array, DropScene
from ros_pose_stats.resting.turns import FEWEST
from study.output import markdown_table, points, write_page

from .families import CURVED, ROCKING, family_part, family_poses
from .lopsided import DOCS

SERIES, DROPS, RESTITUTIONS, HEIGHTS = 4711, 400, (0.2, 0.5, 0.8), (20.0, 2.0)
BOUNDS, BOUNDS_ACROSS = (0.01, 5.0), (0.0, 40.0)
"""Of the coefficient of expected errors, and of the effect of curves across a pose."""

MIXTURES = (math.inf, 0.1, 0.05, 0.03, 0.02, 0.01, 0.005)
"""Where the energy lost may have half of a say; at the first it has none."""


class Case(NamedTuple):
    """A part in a scene: mean squares over the poses, as fractions."""

    family: str
    share: Array  # counted (P,)
    plain: Array  # (M, P); estimated at each of `MIXTURES` without curves across a pose
    across: Array  # how far they lie there
    seen: float  # difference of estimate and counted shares
    noise: float  # of the drops
    before: float  # expected, without what rocking may change
    rocking: float  # that, for a coefficient of 1
    kept: bool  # whether the largest difference is within its bound, widened by the noise

    def told(self, coefficient: float) -> float:
        """The expected mean square."""
        return self.before + coefficient**2 * self.rocking

    def true(self, mixture: int, across: float) -> float:
        """Mean square error with such effects of energy lost and of curves across, less noise."""
        odds = self.plain[mixture] * np.exp(-across * self.across)
        return float(np.mean(np.square(odds / odds.sum() - self.share))) - self.noise


def measure(family: str, number: int) -> list[Case]:
    """Estimate and drop a body at every restitution, from one of the heights."""
    part, cases = family_part(family, SERIES, number), []
    resting = family_poses(family, part)
    for restitution in RESTITUTIONS:
        scene = DropScene(restitution, HEIGHTS[number % len(HEIGHTS)] * resting.body.radius)
        told = split(resting, scene)
        expected = expected_error("split", resting, told, scene)
        found = simulate(part, DROPS, restitution, number, scene.drop_height, workers=1)
        count = np.zeros(told.size)
        count[[pose.index for pose in found.poses]] = [pose.count for pose in found.poses]
        drops = count.sum()
        share, likely = count / drops, (count + 0.5) / (drops + 1.0)
        bound = largest_of(expected.each, resting.group, ERROR_FITS["split"],
                           likely * (1.0 - likely) / drops)
        own = float(np.mean(np.square(rocking_errors(resting, told))))
        across = resting.curves.across
        plain = np.exp(ACROSS * (across - across.max())) * [
            split(resting, scene, mixture) for mixture in MIXTURES]
        cases.append(Case(family, share, plain, across, float(np.mean(np.square(share - told))),
                          float(np.mean(share * (1.0 - share))) / (drops - 1.0),
                          expected.here**2 - own, own / SHIPPED**2,
                          bool(np.abs(share - told).max() <= bound)))
    return cases


def fit(cases: Sequence[Case]) -> float:
    """The likeliest coefficient; square errors scatter exponentially about the expected ones."""
    def unlikely(coefficient: float) -> float:
        whole = [one.told(coefficient) + one.noise for one in cases]
        return sum(math.log(all_) + one.seen / all_
                   for all_, one in zip(whole, cases, strict=True))

    return float(minimize_scalar(unlikely, bounds=BOUNDS, method="bounded").x)


def fit_effects(cases: Sequence[Case]) -> tuple[int, float]:
    """The effects of energy lost, by its mixture, and of curves across of least square error."""
    found = [minimize_scalar(
        lambda across, mixture=mixture: sum(one.true(mixture, across) for one in cases),
        bounds=BOUNDS_ACROSS, method="bounded") for mixture in range(len(MIXTURES))]
    best = int(np.argmin([one.fun for one in found]))
    return best, float(found[best].x)


def row(name: str, some: Sequence[Case], others: Sequence[Case]) -> list[str]:
    """True and told errors of some cases, and true ones with the effect fitted to other cases."""
    def root(squares: Sequence[float]) -> float:
        return math.sqrt(max(float(np.mean(squares)), 0.0))

    true = root([one.seen - one.noise for one in some])
    told = root([one.told(SHIPPED) for one in some])
    effects = fit_effects(others)
    twice = np.mean([one.seen > 4.0 * one.told(SHIPPED) + one.noise for one in some])
    return [name, f"{len(some)}", *(points(root([one.true(*each) for one in some]))
                                    for each in ((0, 0.0), (0, ACROSS), effects)),
            points(true), points(root([one.before for one in some])), points(told),
            f"{true / told:.2f}", points(float(twice), 0),
            points(float(np.mean([one.kept for one in some])), 0)]


def page(cases: Sequence[Case], bodies: int) -> str:
    """The page docs/measured/rocking.md."""
    rows = [row(family, [one for one in cases if one.family == family],
                [one for one in cases if one.family != family])
            for family in (*ROCKING, *CURVED)]
    best, across = fit_effects(cases)
    head = ("family", "cases", "networks, points", "with 2", "held out", "true",
            "told without rocking", "told", "true over told", "over twice, %",
            "largest error kept, %")
    return HEAD.format(bodies=bodies, drops=DROPS, shipped=SHIPPED, fitted=fit(cases),
                       across=ACROSS, best=across, mixed=MIXED, fewest=FEWEST,
                       mixture=MIXTURES[best],
                       mixtures=", ".join(f"{one:g}" for one in MIXTURES[1:])) + (
        markdown_table(head, [*rows, row("all", cases, cases)]) + "\n")


HEAD = """# Parts that rock on a curve

Written by `python -m lab.training.rocking --write`; edits here are lost. {bodies} bodies a
family, {drops} drops at restitution 0.2, 0.5 and 0.8, from 20 or 2 radii. The networks of `split`
know none of these families.

1. A part that rocks on surfaces curved both ways loses little at each facet. So it passes from
flat to curve many times, and ends where most energy is lost, as slowly damped motion is caught by
wells (Neishtadt; Henrard). Where R < E in a component, an impact on crossing an edge takes the
share sin² a, with a the angle between the impulses at its corners, of E - R; `split` sums that
over the lengths of all edges' arcs, in the metric of the inertia. Nothing in it is fitted. The log
of the sum stands in for the log of the network's weight with the share m / (m + {mixed:g}), where
m is the share of facets curved to all sides in the sphere times the standard deviation over it of
the share of curves c below, less {fewest:g}: a body of curves alone, or of flats alone, is the
networks'. The best of {mixtures} is {mixture:g}; with less, bodies that the networks know lose.

2. Rocking on a curve is a turn about its generators. It lasts while all other motion dies: narrow
facets take little of its energy, and without friction nothing turns it about another axis. So a
part does not lie down where the generators stand on end (a lens on its flat sides). `split`
multiplies odds by exp(-{across:g} x); x is the solid angle of facets to rock on that lead to
other poses, each times the share of energy that they leave in a radian, times the share of a blow
that becomes a turn about the generator, times the square of its component along the pose's
vertical, over all that leads to other poses. The best number for all is {best:.1f}.

Curves of a full turn count in neither: spin about their axis stays. *Networks*: true errors of
these alone, then with 2 alone; *held out*: with the numbers that are best for all other families.

*True* is the root mean square error over all poses, the noise of the drops taken off; *told* the
expected error, without and with what rocking adds: {shipped:g} sqrt(p) |c² - mean c²| for each
pose, where c is the share of curves in the solid angle that leads to it; the likeliest factor here
is {fitted:.2f}.

What did not pay, judged on families held out: a network of the inputs and the curved share added
to the weights; what is lost in the wells on both sides of a saddle as a factor of the weights, and
as the weights of all bodies, of all curves, or of full turns, too;
odds of curves changed by restitution, height, barrier and area; partial rims counted by facets a
turn, by their share of a turn, or not at all.

"""


def main() -> None:
    """Measure, print the page, and write it where that is asked."""
    parser = argparse.ArgumentParser(prog="lab.training.rocking",
                                     description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--bodies", type=int, default=8, help="a family (default: %(default)s)")
    parser.add_argument("--write", action="store_true", help="write what is found to its place")
    options = parser.parse_args()
    text = page([case for family in (*ROCKING, *CURVED) for number in range(options.bodies)
                 for case in measure(family, number)], options.bodies)
    print(text)
    if options.write:
        write_page(DOCS, "rocking.md", text, {}, {})


if __name__ == "__main__":
    main()
