"""Speed of the numeric core: `python -m lab.benchmarks.core [--quick] [--write]`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from . import bodies
from .bodies import Body
from .estimates import TOLERANCES, all_estimators, answers, near_spheres, paper_size
from .growth import FIT_FROM, growth, slopes
from .report import collect_results, command
from .results import Results, Section
from .timing import Pace

MESHES = Pace(15, 8.0)
CALLS = Pace(300, 2.0)


@dataclass(frozen=True)
class Plan:
    """Sizes to measure and for how long.

    Attributes
    ----------
    random, smooth : tuple of int
        Vertices of random polyhedra, and of ellipsoids and spheres.
    near_sphere : int
        Vertices.
    fineness : tuple of int
        Of the rounded boxes.
    flattened : tuple of int
        Vertices of the flattened ellipsoids, at least 200.
    fit_from : int
        Vertices from which on slopes are fitted.
    seeds : int
        Random polyhedra a size.
    demo : bool
        Whether to measure the demo parts.
    slow, quick : Pace
        For whole meshes, and for single small calls.
    """

    random: tuple[int, ...] = (10, 23)
    smooth: tuple[int, ...] = (200, 2000, 20000)
    near_sphere: int = 4000
    fineness: tuple[int, ...] = (1, 2, 3, 5, 7, 11, 16, 22, 35, 50, 70, 110)
    flattened: tuple[int, ...] = (200, 500, 1000, 2000, 5000, 10000, 20000, 50000)
    fit_from: int = FIT_FROM
    seeds: int = 3
    demo: bool = True
    slow: Pace = MESHES
    quick: Pace = CALLS


QUICK = Plan(
    smooth=(200, 2000),
    near_sphere=1000,
    fineness=(1, 3, 7, 16, 24, 35),
    flattened=(300, 1000, 2000, 5000),
    fit_from=200,
    seeds=1,
    slow=Pace(5, 1.0),
    quick=Pace(50, 0.5),
)


def sections(plan: Plan) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    polyhedra = [
        [bodies.random_polyhedron(vertices, seed) for seed in range(plan.seeds)]
        for vertices in plan.random
    ]
    warm_up(polyhedra[0][0])
    yield all_estimators(
        [
            *(some[0] for some in polyhedra),
            *(
                make(vertices)
                for make in (bodies.ellipsoid, bodies.sphere)
                for vertices in plan.smooth
            ),
        ],
        plan.slow,
    )
    if plan.demo:
        yield all_estimators(bodies.demo_parts(), plan.slow, "demo", "The demo parts")
    yield near_spheres(
        [bodies.near_sphere(plan.near_sphere), bodies.sphere(plan.near_sphere)],
        plan.slow,
    )
    yield paper_size([body for some in polyhedra for body in some], plan.quick)
    grown = growth(
        [
            *map(bodies.rounded_box, plan.fineness),
            *map(bodies.flattened_ellipsoid, plan.flattened),
        ],
        plan.slow,
    )
    yield grown
    yield slopes(grown, plan.fit_from)


def warm_up(body: Body) -> None:
    """Compile or load every kernel, and what scipy and trimesh load on their first call."""
    for tolerance in TOLERANCES:
        answers(body, tolerance)
    all_estimators([body], Pace(1, 1.0))
    paper_size([body], Pace(1, 1.0))


def run(plan: Plan, say: Callable[[str], object] = print) -> Results:
    """Measure everything, and say each table as it comes."""
    return collect_results(sections(plan), say)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print, and with `--write` store the results and render the page."""
    command(
        "core",
        __doc__,
        "fewer and smaller bodies",
        lambda quick: run(QUICK if quick else Plan()),
        arguments,
    )


if __name__ == "__main__":
    main()
