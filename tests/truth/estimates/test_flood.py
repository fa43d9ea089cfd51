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

"""EAE, MEAE and the splitting graph against an independent flood of a grid on the
sphere.
"""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lab.bodies.samples import clamp_hull, oblique_prism, random_polyhedron
from ros_pose_stats import estimate, part_from_mesh, resting_poses, splitting_graph
from tests.matching import downs, values
from tests.truth.reference.sphere_grid import SPACING, Shape, flood

BODIES = {
    "oblique prism": (oblique_prism(1.3, 2.9), None),
    "clamp hull, shifted centre": (clamp_hull(), (12.0, 15.0, 2.0)),
    "random, shifted centre": (random_polyhedron(12, 3), (-0.2, 0.1, 0.25)),
}

# Errors of the grid are of second order in its spacing. With twice as many directions,
# on these bodies and thirty more: a level 5e-6 of the radius, an area 8e-4 sr, a
# probability 2e-4. In a component of a few cells they are larger: there the first
# figures hold, elsewhere the second.
LEVEL = (1e-3, 4e-5)  # of the radius
AREA = (1e-2, 2e-3)  # steradians
PROBABILITY = (4e-3, 6e-4)
MANY_CELLS = 50.0 * SPACING**2


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize(("function", "method"), [("r", "meae"), ("R", "eae")])
def test_tree_levels_areas_and_probabilities(name, function, method):
    surface, center = BODIES[name]
    part = part_from_mesh(*surface, center_of_mass=center)
    shape = Shape(surface[0], part.center_of_mass)
    # A stable foot closer to its face's rim has a component that the grid sees at a
    # wrong level.
    resolved = shape.clearance() > 2.0 * SPACING
    expected = flood(shape, function)
    fine = int(resolved and expected.smallest_component > MANY_CELLS)
    statistics = estimate(part, method, cluster_tolerance=0.0)
    gap, leaf = cKDTree(expected.stable).query(downs(statistics.poses))
    assert len(statistics.poses) == len(expected.stable) == len(set(leaf.tolist()))
    assert gap.max() < 1e-6
    assert values(statistics.poses, "probability") == pytest.approx(
        expected.probability[leaf], abs=PROBABILITY[fine]
    )
    assert resolved or "clamp" in name
    if not resolved:
        return

    leaf_of = dict(
        zip(values(statistics.poses, "index").tolist(), leaf.tolist(), strict=True)
    )
    nodes = [
        node
        for node in splitting_graph(resting_poses(part, 0.0), function).walk()
        if node.parts
    ]
    assert len(nodes) == len(expected.splits)
    levels = np.array([split.level for split in expected.splits])
    assert np.sort([node.level for node in nodes])[::-1] == pytest.approx(
        levels, abs=LEVEL[fine] * statistics.radius
    )
    ours = {
        frozenset(leaf_of[k] for k in piece.poses): angle
        for node in nodes
        for piece, angle in zip(node.parts, node.angles, strict=True)
    }
    theirs = {
        piece: area
        for split in expected.splits
        for piece, area in zip(split.parts, split.areas, strict=True)
    }
    if np.diff(levels).max(initial=-1.0) < -2.0 * LEVEL[fine] * statistics.radius:
        assert ours.keys() == theirs.keys()  # else ties are split in any order
    for component in ours.keys() & theirs.keys():
        assert ours[component] == pytest.approx(theirs[component], abs=AREA[fine])
