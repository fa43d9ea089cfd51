"""All measurements of the drop simulation, section after section."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from .. import bodies
from ..report import collect_results, command
from ..results import Results, Section
from ..timing import Pace
from .beside_mujoco import beside_mujoco
from .dropper import Dropper, paper_droppers, pick_evenly
from .rates import growth, rates, scaling, slopes
from .soundness import stopping

MERGED = 0.005
"""The default cluster tolerance."""

RATES = Pace(41, 15.0)
SCALING = Pace(7, 30.0)
GROWTH = Pace(5, 2.0)


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Attributes
    ----------
    bodies, few : int
        Random polyhedra for the rates, and how many of them for longer measurements.
    drops : int
        Of each body in a round of the rates.
    rates, scaling, growth : Pace
    theirs, ours : int
        Drops of each body by MuJoCo and by this package beside it.
    scaling_drops, pieces : int
        Of a call of `simulate`, and of the arithmetic beside it.
    ellipsoids, fineness, flattened : tuple of int
        Sizes of the bodies for the cost against vertices.
    growth_seconds : float
        Drops of such a body in one round.
    target : float
        Wanted error of the runs that stop.
    stop_seeds, long_drops : int
    """

    bodies: int = 24
    few: int = 3
    drops: int = 100
    rates: Pace = RATES
    theirs: int = 30
    ours: int = 400
    scaling_drops: int = 15_000
    pieces: int = 200
    scaling: Pace = SCALING
    ellipsoids: tuple[int, ...] = (10, 30, 100, 300, 1000, 2000, 5000)
    fineness: tuple[int, ...] = (1, 2, 4, 8, 15, 22, 34)
    flattened: tuple[int, ...] = (30, 200, 500, 1000, 2000, 5000)
    growth_seconds: float = 0.2
    growth: Pace = GROWTH
    target: float = 0.02
    stop_seeds: int = 300
    long_drops: int = 150_000


QUICK = Plan(
    bodies=20,
    few=2,
    rates=Pace(9, 5.0),
    theirs=8,
    ours=200,
    scaling_drops=6000,
    pieces=80,
    scaling=Pace(3, 10.0),
    ellipsoids=(10, 100, 1000),
    fineness=(1, 4, 15),
    flattened=(30, 200, 1000),
    growth_seconds=0.1,
    growth=Pace(3, 0.5),
    stop_seeds=100,
    long_drops=20_000,
)


def sections(plan: Plan) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    droppers = paper_droppers(plan.bodies)
    droppers[0].drop(droppers[0].rules(0.5), 0, 100)  # compiles or loads the kernel
    few = pick_evenly(droppers, plan.few)
    merged = [Dropper(one.body, MERGED) for one in few]
    yield rates(droppers, plan.drops, plan.rates)
    yield beside_mujoco(merged, plan.theirs, plan.ours)
    yield scaling(few[len(few) // 2], plan.scaling_drops, plan.pieces, plan.scaling)
    grown = growth(families(plan), plan.growth_seconds, plan.growth)
    yield grown
    yield slopes(grown)
    yield stopping(few[:2], plan.target, plan.stop_seeds, plan.long_drops)


def families(plan: Plan) -> list[tuple[str, float, list[bodies.Body]]]:
    """Bodies for the cost against vertices: name, cluster tolerance, sizes."""
    ellipsoids = [bodies.ellipsoid(size) for size in plan.ellipsoids]
    return [
        ("ellipsoid at tolerance 0.005", MERGED, ellipsoids),
        ("ellipsoid at tolerance 0", 0.0, ellipsoids),
        ("rounded box", MERGED, [bodies.rounded_box(fine) for fine in plan.fineness]),
        (
            "flattened ellipsoid",
            MERGED,
            [bodies.flattened_ellipsoid(size) for size in plan.flattened],
        ),
    ]


def run(plan: Plan, say: Callable[[str], object] = print) -> Results:
    """Measure everything, and say each table as it comes."""
    return collect_results(sections(plan), say)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print, and with `--write` store the results and render the page."""
    command(
        "drops",
        __doc__,
        "fewer bodies and drops",
        lambda quick: run(QUICK if quick else Plan()),
        arguments,
    )


if __name__ == "__main__":
    main()
