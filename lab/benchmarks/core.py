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

"""Speed of the numeric core: `python -m lab.benchmarks.core [--quick] [--write]`."""

from collections.abc import Iterator
from dataclasses import dataclass

from lab.bodies import curved
from lab.bodies.curved import Body
from lab.frame.results import Section
from lab.frame.timing import Pace

from .estimates import (
    NEAR_SPHERE_SECONDS,
    TOLERANCES,
    all_estimators,
    answers,
    paper_size,
)
from .program import benchmark_parser, run_benchmark

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
    seeds : int
        Random polyhedra a size.
    slow, quick : Pace
        For whole meshes, and for single small calls.
    """

    random: tuple[int, ...] = (10, 23)
    smooth: tuple[int, ...] = (200, 2000, 20000)
    near_sphere: int = 4000
    seeds: int = 3
    slow: Pace = MESHES
    quick: Pace = CALLS


QUICK = Plan(
    smooth=(200, 2000),
    near_sphere=1000,
    seeds=1,
    slow=Pace(5, 1.0),
    quick=Pace(50, 0.5),
)


def sections(plan: Plan) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    polyhedra = [
        [curved.random_polyhedron(vertices, seed) for seed in range(plan.seeds)]
        for vertices in plan.random
    ]
    warm_up(polyhedra[0][0])
    yield all_estimators(
        [
            *(of_size[0] for of_size in polyhedra),
            *(
                make(vertices)
                for make in (curved.ellipsoid, curved.sphere)
                for vertices in plan.smooth
            ),
        ],
        plan.slow,
    )
    yield all_estimators(curved.demo_parts(), plan.slow, "demo", "The demo parts")
    yield all_estimators(
        [curved.near_sphere(plan.near_sphere), curved.sphere(plan.near_sphere)],
        plan.slow,
        "near_sphere",
        "Hundreds of stable poses and more",
        NEAR_SPHERE_SECONDS,
    )
    yield paper_size([body for of_size in polyhedra for body in of_size], plan.quick)


def warm_up(body: Body) -> None:
    """Compile or load every kernel, and what scipy and trimesh load on their first
    call.
    """
    for tolerance in TOLERANCES:
        answers(body, tolerance)
    all_estimators([body], Pace(1, 1.0))
    paper_size([body], Pace(1, 1.0))


if __name__ == "__main__":
    run_benchmark(
        benchmark_parser("lab.benchmarks.core", __doc__, "fewer and smaller bodies"),
        lambda options: sections(QUICK if options.quick else Plan()),
    )
