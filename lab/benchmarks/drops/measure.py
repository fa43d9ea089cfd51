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

"""All measurements of the drop simulation, section after section."""

from collections.abc import Iterator
from dataclasses import dataclass

from lab.bodies import curved
from lab.frame.results import Section
from lab.frame.timing import Pace
from ros_pose_stats.core.records.scene import DEFAULT_CLUSTER_TOLERANCE

from .dropper import paper_droppers
from .rates import growth, rates

RATES = Pace(41, 15.0)
GROWTH = Pace(5, 2.0)


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Attributes
    ----------
    bodies : int
        Random polyhedra for the rates.
    drops : int
        Of each body in a round of the rates.
    rates, growth : Pace
    ellipsoids, fineness : tuple of int
        Sizes of the bodies for the cost against vertices.
    growth_seconds : float
        Drops of such a body in one round.
    """

    bodies: int = 24
    drops: int = 100
    rates: Pace = RATES
    ellipsoids: tuple[int, ...] = (10, 30, 100, 300, 1000, 2000, 5000)
    fineness: tuple[int, ...] = (1, 2, 4, 8, 15, 22, 34)
    growth_seconds: float = 0.2
    growth: Pace = GROWTH


QUICK = Plan(
    bodies=20,
    rates=Pace(9, 5.0),
    ellipsoids=(10, 100, 1000),
    fineness=(1, 4, 15),
    growth_seconds=0.1,
    growth=Pace(3, 0.5),
)


def sections(plan: Plan) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    droppers = paper_droppers(plan.bodies)
    droppers[0].drop(droppers[0].rules(0.5), 0, 100)  # compiles or loads the kernel
    yield rates(droppers, plan.drops, plan.rates)
    yield growth(families(plan), plan.growth_seconds, plan.growth)


def families(plan: Plan) -> list[tuple[str, float, list[curved.Body]]]:
    """Bodies for the cost against vertices: name, cluster tolerance, sizes."""
    ellipsoids = [curved.ellipsoid(size) for size in plan.ellipsoids]
    return [
        (
            f"ellipsoid at tolerance {DEFAULT_CLUSTER_TOLERANCE:g}",
            DEFAULT_CLUSTER_TOLERANCE,
            ellipsoids,
        ),
        ("ellipsoid at tolerance 0", 0.0, ellipsoids),
        (
            "rounded box",
            DEFAULT_CLUSTER_TOLERANCE,
            [curved.rounded_box(fine) for fine in plan.fineness],
        ),
    ]
