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

"""A body prepared for drops, for measurements of the kernel itself."""

from collections.abc import Iterator
from functools import partial
from itertools import count, islice
from typing import NamedTuple

from lab.bodies import curved
from lab.bodies.curved import Body
from lab.frame.timing import timed
from ros_pose_stats import DropScene, part_from_mesh
from ros_pose_stats.core.kernels.drops.layout import DropRules
from ros_pose_stats.core.simulation.drop_body import drop_body
from ros_pose_stats.core.simulation.drops import (
    DropOutcomes,
    compute_drops,
    drop_rules,
    random_starts,
)

RESTITUTIONS = (0.2, 0.5, 0.8)

PAPER_BODIES = 12
PAPER_DROPS = 200


class Effort(NamedTuple):
    """Mean cost of a drop: single impacts, and steps of the motion between them."""

    impacts: float
    steps: float


class Dropper:
    """A body with its poses merged at a cluster tolerance."""

    def __init__(self, body: Body, tolerance: float = 0.0) -> None:
        self.body = body
        self.name = body.name
        self.vertices = len(body.vertices)
        self.part = part_from_mesh(body.vertices, body.triangles)
        self.prepared = drop_body(
            self.part, DropScene(cluster_tolerance=tolerance, round_sides=0)
        )
        self.poses = len(self.prepared.resting.poses)

    def rules(self, restitution: float, height: float = 20.0) -> DropRules:
        """Rules of a scene; the height of release is in radii."""
        scene = DropScene(restitution, height * self.prepared.radius)
        return drop_rules(scene, self.prepared.radius)

    def drop(self, rules: DropRules, seed: int, drops: int) -> DropOutcomes:
        """Compute the first drops of a seed on this thread, as a worker does."""
        return compute_drops(self.prepared, rules, random_starts(seed, 0, drops))

    def effort(self, rules: DropRules, seed: int, drops: int) -> Effort:
        """Mean cost of such drops."""
        outcomes = self.drop(rules, seed, drops)
        steps = outcomes.events - outcomes.impacts
        return Effort(float(outcomes.impacts.mean()), float(steps.mean()))


def paper_droppers(number: int) -> list[Dropper]:
    """The first of the paper's random polyhedra that have at least two stable faces."""
    return list(islice(_paper_droppers(), number))


def _paper_droppers() -> Iterator[Dropper]:
    for seed in count():
        dropper = Dropper(curved.paper_polyhedron(seed))
        if dropper.poses >= 2:
            yield dropper


def paper_seconds(restitution: float, seed: int) -> float:
    """Mean processor time of a drop of one of the paper's random polyhedra."""
    seconds = 0.0
    for dropper in paper_droppers(PAPER_BODIES):
        rules = dropper.rules(restitution)
        dropper.drop(rules, 0, 1)  # compiles or loads the kernel
        seconds += timed(partial(dropper.drop, rules, seed, PAPER_DROPS))[1]
    return seconds / (PAPER_BODIES * PAPER_DROPS)
