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

"""The parts of the study: of all families, prisms with a hidden insert, and the demo
parts.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from lab.bodies.families import FAMILIES, family_options, family_part
from ros_pose_stats import estimate
from ros_pose_stats.core.mesh.parts import part_from_mesh, shift_center
from ros_pose_stats.core.records import DropScene, Part
from ros_pose_stats.core.shapes.demo_parts import DEMO_PARTS
from ros_pose_stats.tools.design.changes import DesignSpace
from ros_pose_stats.tools.design.shares import GoalModel

SEED = 2024
INSERT = "prisms with an insert"
DEMO = "demo parts"

LEAST = 0.1
MOST = 0.9
"""Share of the wanted poses, where a group of poses has one between them."""

INSERTED = 0.2
"""How far an insert moves the centre of mass of a prism, in radii."""


class Case(NamedTuple):
    """A part with its wanted poses: one group that symmetry makes alike."""

    family: str
    number: int
    space: DesignSpace
    model: GoalModel
    restitution: float
    draw: np.random.Generator


RESTITUTIONS = (0.3, 0.5, 0.7)


def all_parts(count: int) -> Iterator[tuple[str, int]]:
    """Family and number of `each` parts a family, and of the demo parts."""
    for number in range(count):
        yield from ((family, number) for family in (*FAMILIES, INSERT))
    yield from ((DEMO, number) for number in range(len(DEMO_PARTS)))


def make_case(family: str, number: int) -> Case:
    """A part of a family; equal arguments give the same one."""
    draw = np.random.default_rng([SEED, number, *family.encode()])
    part, tolerance, sides = _part(family, number, draw)
    restitution = RESTITUTIONS[int(draw.integers(len(RESTITUTIONS)))]
    space = DesignSpace(part, DropScene(restitution, None, tolerance, sides))
    groups: dict[int, list[int]] = {}
    share: dict[int, float] = {}
    for pose in estimate(
        part,
        "split",
        restitution=restitution,
        cluster_tolerance=tolerance,
        round_sides=sides,
    ).poses:
        groups.setdefault(pose.group, []).append(pose.index)
        share[pose.group] = pose.group_probability
    candidates = [group for group in groups if LEAST < share[group] < MOST] or list(
        groups
    )
    wanted_poses = tuple(groups[candidates[int(draw.integers(len(candidates)))]])
    return Case(
        family, number, space, GoalModel(space, wanted_poses), restitution, draw
    )


def _part(
    family: str, number: int, draw: np.random.Generator
) -> tuple[Part, float, int]:
    if family == DEMO:
        name = list(DEMO_PARTS)[number]
        part = part_from_mesh(*DEMO_PARTS[name](), unit="mm", part_id=name)
        return part, *family_options("machined")
    if family != INSERT:
        return family_part(family, SEED, number), *family_options(family)
    prism = family_part("prisms", SEED + 1, number)
    corners = prism.surface_vertices
    inside = draw.dirichlet(np.ones(len(corners))) @ corners - prism.center_of_mass
    step = inside * min(1.0, INSERTED / float(np.linalg.norm(inside)))
    return shift_center(prism, step), *family_options("prisms")
