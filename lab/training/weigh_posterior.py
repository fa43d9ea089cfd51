"""Weighs the prior of `hybrid` against simpler ones, on parts that no fit has seen.

.venv/bin/python -m lab.training.weigh_posterior [--every N] [--reference DROPS] [--write]
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from ros_pose_stats.core.statistics.fitted_prior import FITTED_METHOD
from ros_pose_stats.core.statistics.prior import PriorFit, prior_fit

from ..benchmarks.auto.cases import Case, drop_parts
from ..benchmarks.auto.sharpening import bound_holds, intervals_hold
from ..benchmarks.report import MEASURED
from .fit_posterior import CLOSE, LIKELY, STEP, log_likelihood
from .posterior_samples import RESTITUTIONS, Sample, held_out, sample_of, samples

Array = NDArray[np.float64]
Fits = dict[float, PriorFit]

RARE = 0.01
DROPS = (0, 10, 100, 500)
MANY = (0, 100, 1000, 10_000)
PARTS = 80
USUAL = 0.5
"""Of the long references: so many parts, at this restitution."""
NO_SCATTER = 1e-9
PAGE = MEASURED / "posterior.md"

MODELS: dict[str, Callable[[Sequence[Sample]], PriorFit]] = {
    "one strength": lambda some: _simplest(some, (0.0,)),
    "scattered strength": lambda some: _simplest(some, (0.0, math.log(0.5))),
    "rare poses apart": lambda some: prior_fit(some[0].restitution),
}


def _simplest(some: Sequence[Sample], begin: tuple[float, ...]) -> PriorFit:
    """The likeliest center, and the spread if that is wanted, with nothing said of rare poses."""

    def fit(x: Array) -> PriorFit:
        return PriorFit(
            float(x[0]), math.exp(x[1]) if x.size > 1 else NO_SCATTER, 0.0, 0.0, 0.5
        )

    simplex = np.vstack((begin, np.array(begin) + STEP * np.eye(len(begin))))
    found = minimize(
        lambda x: -log_likelihood(some, fit(x)),
        begin,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": CLOSE, "fatol": LIKELY},
    )
    return fit(found.x)


def halve_drops(known: Sequence[Sample]) -> list[Case]:
    """Half of each body's drops in a row, in any order, and the counts of the other half."""
    draw = np.random.default_rng(1)
    cases = []
    for one in known:
        outcomes = draw.permutation(np.repeat(np.arange(one.count.size), one.count))
        half = outcomes.size // 2
        cases.append(
            Case(
                one.body,
                one.restitution,
                outcomes[:half].astype(np.int16),
                np.bincount(outcomes[half:], minlength=one.count.size),
            )
        )
    return cases


def long_cases(reference: int) -> tuple[list[Sample], list[Case]]:
    """Other parts that no fit has seen, dropped thousands of times."""
    cases = drop_parts(PARTS, print, (USUAL,), reference)
    return [
        sample_of(one.number, one.resting(), USUAL, FITTED_METHOD, one.reference)
        for one in cases
    ], cases


def compare(
    known: Sequence[Sample],
    cases: Sequence[Case],
    models: dict[str, Fits],
    told: Sequence[int] = DROPS,
) -> list[list[str]]:
    """Rows: model, drops, error in points, coverage of the poses and of the bound."""
    rare = [one.reference < RARE * one.reference.sum() for one in cases]
    rows = []
    for name, fits in models.items():
        priors = [one.prior(fits[one.restitution]) for one in known]
        for drops in told:
            both = list(zip(cases, priors, strict=True))
            squares = [
                case.square_error(prior.updated(case.counts(drops)).probability)
                for case, prior in both
            ]
            inside = [intervals_hold(case, prior, drops) for case, prior in both]
            poses = np.array([one.size for one in inside])
            error = math.sqrt(max(float(np.average(squares, weights=poses)), 0.0))
            rows.append(
                [
                    name,
                    f"{drops}",
                    f"{100.0 * error:.3f}",
                    _share(np.array([one.sum() for one in inside]), poses),
                    _share(
                        np.array(
                            [
                                one[few].sum()
                                for one, few in zip(inside, rare, strict=True)
                            ]
                        ),
                        np.array([few.sum() for few in rare]),
                    ),
                    _share(
                        np.array(
                            [bound_holds(case, prior, drops) for case, prior in both]
                        ),
                        np.ones(len(both)),
                    ),
                ]
            )
    return rows


def _share(held: Array, of: Array) -> str:
    """Percent, with the standard error by the scatter between parts."""
    share = float(held.sum() / of.sum())
    error = math.sqrt(float(np.square(held - share * of).sum())) / float(of.sum())
    return f"{100.0 * share:.1f} ± {100.0 * error:.1f}"


def page(
    rows: Sequence[Sequence[str]],
    parts: int,
    long: Sequence[Sequence[str]],
    reference: int,
) -> str:
    """The page with its tables, by the halves of many parts and by long references of some."""
    return (
        f"{HEAD.format(parts=parts)}{_table(rows)}"
        f"{LONG.format(parts=PARTS, reference=reference, at=USUAL)}{_table(long)}"
    )


def _table(rows: Sequence[Sequence[str]]) -> str:
    return COLUMNS + "".join("| " + " | ".join(row) + " |\n" for row in rows)


HEAD = """# Priors of hybrid, weighed

*This page is written by `python -m lab.training.weigh_posterior --write`.*

How far to believe an estimate beside counted drops: three priors, fitted by likelihood, on
{parts} parts that no fit has seen, at restitution 0.2, 0.5 and 0.8. All have the strength that the
expected error of the part implies, times a fitted factor. `one strength` is a Dirichlet
distribution of that strength. `scattered strength` takes it to scatter over parts. `rare poses
apart`, the one that the package has, is also surer of rare poses, but for a share of them, as a
distribution of Connor and Mosimann can be.

Each part was dropped a thousand times: some of one half are told, the other half judges. Error:
root mean square over the poses, in points, the noise of that half taken off. Poses: share whose
reference lies in the 90 % interval, in %, and the same of those whose reference is below 1 %.
Bound: share of the parts whose error is within the 90 % bound. Each share with its standard error
by the scatter between parts. Intervals and bound are widened by the noise of the judging half,
which hides intervals that are too narrow where there are many drops or a pose is rare.

"""

LONG = """
## At many drops

The same of {parts} other parts that no fit has seen, at restitution {at:g}, each dropped ten
thousand times to tell and {reference} times to judge.

"""

COLUMNS = """| prior | drops | error | poses | rare poses | bound |
|---|---|---|---|---|---|
"""


def main() -> None:
    """Fit, compare, and print or write."""
    parser = argparse.ArgumentParser(
        prog="lab.training.weigh_posterior", description=__doc__.partition("\n")[0]
    )
    parser.add_argument(
        "--every",
        type=int,
        default=24,
        help="fit to every so many bodies (default: %(default)s)",
    )
    parser.add_argument(
        "--reference",
        type=int,
        default=20_000,
        metavar="DROPS",
        help=f"drop {PARTS} parts so often to judge (default: %(default)s)",
    )
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    options = parser.parse_args()
    some = samples(FITTED_METHOD, options.every)
    models = {
        name: {
            rho: fit([one for one in some if one.restitution == rho])
            for rho in RESTITUTIONS
        }
        for name, fit in MODELS.items()
    }
    for name, fits in models.items():
        print(name, *(f"{rho:g}: {fit}" for rho, fit in fits.items()), sep="\n  ")
    known = held_out(FITTED_METHOD)
    text = page(
        compare(known, halve_drops(known), models),
        len(known) // len(RESTITUTIONS),
        compare(*long_cases(options.reference), models, MANY),
        options.reference,
    )
    print(text)
    if options.write:
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
