"""The checked estimate, `auto` without a target, on parts that rock, which no fit has
seen.

.venv/bin/python -m lab.benchmarks.checked [--quick] [--write]
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lab.bodies.families import family_options, family_part
from lab.bodies.rocking import ROCKING
from lab.frame.results import Row, Section, Target
from ros_pose_stats import Part, auto, estimate, simulate

from .auto.cases import by_index
from .program import benchmark_parser, run_benchmark

Array = NDArray[np.float64]

KNOWN = (
    "polyhedra 0.25",
    "prisms",
    "plates",
    "machined",
    "milled",
    "stepped",
    "hollow",
    "flat balls",
    "lumps",
)
"""Families of the fits for comparison, in bodies that they have not seen."""

SERIES = 4321
BODIES = 8
QUICK = 1
RESTITUTIONS = (0.2, 0.5, 0.8)
TARGETS = (0.05, 0.03, 0.02)
EVENTS = 600_000
FEWEST = 800
MOST = 6000
"""Impacts that the reference drops of a case may take, and bounds of their number."""

LARGEST = 1.645
"""Standard errors of the reference that are added to a bound of every pose."""

KEPT = 0.9
TRUE = 1.2

ABOUT = (
    "Root mean square errors over the poses in points, against {} to {} other drops "
    "with their noise taken off, of {} bodies a family at restitution 0.2, 0.5 and "
    "0.8. `split`, `told`: that estimate alone, and what it expects. `drops`: those of "
    "the checked estimate by themselves. `checked`, `its told`: `auto(part)` and what "
    "it expects. `largest`: share of the cases in which every pose is within "
    "`largest_error`, widened by the reference's noise, in %; `5/3/2`: in which `auto` "
    "keeps a target of so many points. Not times."
)


class Case(NamedTuple):
    """A body at one restitution: square errors over the poses, and what was kept."""

    split: float
    split_told: float
    drops: float
    checked: float
    told: float
    largest: bool
    kept: tuple[bool, ...]


def judged(part: Part, restitution: float, options: dict[str, Any]) -> Case:
    """Drop a part often, and judge all answers by that."""
    scene = {"restitution": restitution, **options}
    impacts: list[int] = []
    simulate(
        part,
        30,
        seed=1,
        on_drops=lambda chunk: impacts.append(int(chunk.outcomes.impacts.sum())),
        **scene,
    )
    drops = min(max(30 * EVENTS // sum(impacts), FEWEST), MOST)
    true = by_index(simulate(part, drops, seed=2, **scene), "probability")
    noise = true * (1.0 - true) / (drops - 1)

    def square(shares: Array) -> float:
        return float(np.mean(np.square(shares - true) - noise))

    estimated = estimate(part, "split", **scene)
    checked = auto(part, **scene)
    counts = by_index(checked, "count")
    away = np.abs(by_index(checked, "probability") - true)
    return Case(
        square(by_index(estimated, "probability")),
        estimated.expected_error**2,
        square(counts / counts.sum()) if counts.any() else math.nan,
        square(by_index(checked, "probability")),
        checked.expected_error**2,
        bool((away <= checked.largest_error + LARGEST * np.sqrt(noise)).all()),
        tuple(
            square(by_index(auto(part, target, seed=3, **scene), "probability"))
            <= target**2
            for target in TARGETS
        ),
    )


def row(name: str, cases: Sequence[Case], targets: bool) -> Row:
    """Root mean squares and shares of some cases."""

    def root(of: Callable[[Case], float]) -> float:
        return 100.0 * math.sqrt(
            max(float(np.nanmean([of(case) for case in cases])), 0.0)
        )

    checked, told, drops = (
        root(lambda case, name=name: getattr(case, name))  # type: ignore[misc]
        for name in ("checked", "told", "drops")
    )
    largest = float(np.mean([case.largest for case in cases]))
    target_shares = np.mean([case.kept for case in cases], axis=0)
    return Row(
        name,
        {
            "cases": len(cases),
            "split": root(lambda case: case.split),
            "told": root(lambda case: case.split_told),
            "drops": drops,
            "checked": checked,
            "its told": told,
            "ratio": checked / told,
            "largest": 100.0 * largest,
            "5/3/2": " / ".join(f"{100.0 * share:.0f}" for share in target_shares),
        },
        (
            Target("checked / drops", checked / drops, 1.0),
            Target("ratio", checked / told, TRUE),
            Target("largest", largest, KEPT, at_least=True),
            Target("targets kept", float(target_shares.mean()), KEPT, at_least=True),
        )
        if targets
        else (),
    )


def sections(bodies: int) -> Iterator[Section]:
    """Measure the families that no fit has seen, and those of the fits."""
    description = ABOUT.format(FEWEST, MOST, bodies)
    for key, title, families in (
        ("checked", "Checked estimates of parts that rock", tuple(ROCKING)),
        ("checked_known", "Checked estimates of other families", KNOWN),
    ):
        rows = []
        all_cases = []
        for family in families:
            tolerance, sides = family_options(family)
            options = {"cluster_tolerance": tolerance, "round_sides": sides}
            cases = [
                judged(part, rho, options)
                for part in (
                    family_part(family, SERIES, number) for number in range(bodies)
                )
                for rho in RESTITUTIONS
            ]
            rows.append(row(family, cases, False))
            all_cases += cases
        rows.append(row("all", all_cases, True))
        yield Section(key, title, description, tuple(rows))


if __name__ == "__main__":
    run_benchmark(
        benchmark_parser("lab.benchmarks.checked", __doc__ or "", "one body a family"),
        lambda options: sections(QUICK if options.quick else BODIES),
    )
