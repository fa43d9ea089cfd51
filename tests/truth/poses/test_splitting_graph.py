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

"""The splitting graph: a tree of levels whose products are the paper's energy
estimates.
"""

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import (
    REGULAR_SOLIDS,
    clamp_hull,
    oblique_prism,
    random_polyhedron,
)
from lab.bodies.variants import moved, rotation
from ros_pose_stats import estimate, part_from_mesh, resting_poses, splitting_graph

PARTS = {
    "icosahedron": part_from_mesh(*moved(REGULAR_SOLIDS["icosahedron"], rotation(3))),
    "box": part_from_mesh(*shapes.box(1.0, 2.0, 3.0)),
    "leaning prism": part_from_mesh(*oblique_prism(1.2, 2.0)),
    "cylinder": part_from_mesh(*shapes.cylinder(64, 1.0, 2.0)),
    "clamp hull": part_from_mesh(*clamp_hull(), unit="mm"),
    "random": part_from_mesh(*random_polyhedron(27, 7)),
}
GRAPHS = [  # every body once, and the one with a curve in every way
    ("icosahedron", 0.0, "r"),
    ("box", 0.0, "R"),
    ("leaning prism", 0.0, "r"),
    ("clamp hull", 0.005, "R"),
    ("random", 0.005, "r"),
    ("random", 0.0, "R"),
    ("cylinder", 0.0, "r"),
    ("cylinder", 0.0, "R"),
    ("cylinder", 0.005, "r"),
    ("cylinder", 0.005, "R"),
]


@pytest.mark.parametrize(("name", "tolerance", "function"), GRAPHS)
class TestTree:
    @staticmethod
    def graph(name, tolerance, function):
        resting = resting_poses(PARTS[name], tolerance, round_sides=0)
        return resting.poses, splitting_graph(resting, function)

    def test_a_binary_tree_over_all_poses_from_the_top_down(
        self, name, tolerance, function
    ):
        poses, root = self.graph(name, tolerance, function)
        nodes = list(root.walk())
        leaves = [node for node in nodes if not node.parts]
        assert root.poses == tuple(range(len(poses)))
        assert {node.poses for node in leaves} == {(pose.index,) for pose in poses}
        assert len({id(node) for node in nodes}) == len(nodes) == 2 * len(leaves) - 1
        position = {id(node): k for k, node in enumerate(nodes)}
        for node in nodes:
            if not node.parts:
                assert node.level is node.saddle is None
                assert node.angles == node.transitions == ()
                continue
            first, second = node.parts
            assert sorted({*first.poses, *second.poses}) == list(node.poses)
            assert min(position[id(first)], position[id(second)]) > position[id(node)]

    def test_levels_fall_to_the_poses_and_are_their_ways_out(
        self, name, tolerance, function
    ):
        poses, root = self.graph(name, tolerance, function)
        leaves = [node.poses[0] for node in root.walk() if not node.parts]
        for node in root.walk():
            for below in node.parts:
                if below.parts:
                    assert below.level <= node.level * (1.0 + 1e-9)
                    continue
                pose = poses[below.poses[0]]
                way_out = pose.height + pose.barrier
                assert pose.height < node.level
                assert way_out <= node.level * (1.0 + 1e-12)
                if (
                    leaves.count(pose.index) == 1
                ):  # else a shelf, maybe, which parts higher up
                    assert way_out == pytest.approx(node.level, rel=1e-12)

    def test_saddles_are_as_high_as_their_levels(self, name, tolerance, function):
        """With the saddle's direction down, the deepest corner is so far below."""
        part = PARTS[name]
        _, root = self.graph(name, tolerance, function)
        for node in root.walk():
            if node.parts:
                reach = (part.surface_vertices - part.center_of_mass) @ node.saddle
                assert np.linalg.norm(node.saddle) == pytest.approx(1.0, abs=1e-12)
                assert reach.max() == pytest.approx(node.level, rel=1e-6)

    def test_transitions_are_eq_8_and_their_products_the_estimate(
        self, name, tolerance, function
    ):
        _, root = self.graph(name, tolerance, function)
        assert root.probability == pytest.approx(1.0, abs=1e-15)
        total = dict.fromkeys(root.poses, 0.0)
        for node in root.walk():
            if node.parts:
                assert (
                    0.0
                    <= min(node.angles)
                    <= sum(node.angles)
                    <= 4.0 * np.pi * (1.0 + 1e-12)
                )
                assert np.array(node.transitions) * sum(node.angles) == pytest.approx(
                    node.angles, abs=1e-14
                )
                assert [below.probability for below in node.parts] == pytest.approx(
                    np.array(node.transitions) * node.probability, abs=1e-15
                )
            else:
                total[node.poses[0]] += node.probability
        method = "eae" if function == "R" else "meae"
        for pose in estimate(
            PARTS[name], method, cluster_tolerance=tolerance, round_sides=0
        ).poses:
            assert total[pose.index] == pytest.approx(pose.probability, abs=1e-13)


@pytest.mark.parametrize("name", PARTS)
def test_r_and_R_share_their_splits(name):
    of_r, of_R = (
        splitting_graph(resting_poses(PARTS[name], 0.0, 0), f) for f in ("r", "R")
    )
    for node_of_r, node_of_R in zip(of_r.walk(), of_R.walk(), strict=True):
        assert (node_of_r.poses, node_of_r.level) == (node_of_R.poses, node_of_R.level)
    assert str(splitting_graph(resting_poses(PARTS[name], 0.0, 0))) == str(of_r)


def test_a_box_written_out():
    """Faces at 1/2 and 1 join over edges at sqrt(1/4 + 1); those at 3/2 come in over
    sqrt(5/2).
    """
    root = splitting_graph(resting_poses(PARTS["box"], 0.0, round_sides=0))
    levels = sorted(node.level for node in root.walk() if node.parts)
    assert levels == pytest.approx([np.sqrt(1.25)] * 3 + [np.sqrt(2.5)] * 2)


def test_a_single_pose_is_a_tree_of_one_node():
    part = part_from_mesh(
        *random_polyhedron(6, 1329), center_of_mass=(-1.18, 0.55, 0.92)
    )
    root = splitting_graph(resting_poses(part, 0.0, round_sides=0))
    assert list(root.walk()) == [root]
    assert (root.poses, root.probability) == ((0,), 1.0)
