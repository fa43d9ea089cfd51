"""The splitting graph as a tree: its levels, its transitions and what it says of itself."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, resting_poses, shapes, splitting_graph
from tests.bodies import (
    REGULAR_SOLIDS,
    clamp_hull,
    moved,
    oblique_prism,
    random_polyhedron,
    rotation,
)

PARTS = {
    "icosahedron": part_from_mesh(*moved(REGULAR_SOLIDS["icosahedron"], rotation(3))),
    "box": part_from_mesh(*shapes.box(1.0, 2.0, 3.0)),
    "leaning prism": part_from_mesh(*oblique_prism(1.2, 2.0)),
    "cylinder": part_from_mesh(*shapes.cylinder(64, 1.0, 2.0)),
    "clamp hull": part_from_mesh(*clamp_hull(), unit="mm"),
    "random": part_from_mesh(*random_polyhedron(27, 7)),
}
GRAPHS = [  # every body once, and the one with a curve in every way
    ("icosahedron", 0.0, "r"), ("box", 0.0, "R"), ("leaning prism", 0.0, "r"),
    ("clamp hull", 0.005, "R"), ("random", 0.005, "r"), ("random", 0.0, "R"),
    ("cylinder", 0.0, "r"), ("cylinder", 0.0, "R"), ("cylinder", 0.005, "r"),
    ("cylinder", 0.005, "R"),
]


@pytest.mark.parametrize(("part", "tolerance", "function"),
                         [(PARTS[name], *options) for name, *options in GRAPHS],
                         ids=["-".join(map(str, graph)) for graph in GRAPHS])
class TestTree:
    @staticmethod
    def graph(part, tolerance, function):
        resting = resting_poses(part, tolerance, round_sides=0)
        return resting, splitting_graph(resting, function)

    def test_a_binary_tree_over_all_poses(self, part, tolerance, function):
        resting, root = self.graph(part, tolerance, function)
        assert root.poses == tuple(range(len(resting.poses)))
        leaves = []
        for node in root.walk():
            if node.parts:
                first, second = node.parts
                assert sorted({*first.poses, *second.poses}) == list(node.poses)
            else:
                leaves += node.poses
                assert len(node.poses) == 1
                assert node.level is None
                assert node.saddle is None
                assert node.angles == node.transitions == ()
        assert sorted(set(leaves)) == list(range(len(resting.poses)))

    def test_levels_fall_on_the_way_down(self, part, tolerance, function):
        resting, root = self.graph(part, tolerance, function)
        slack = 1e-9 * resting.body.radius
        for node in root.walk():
            for below in node.parts:
                if below.parts:
                    assert below.level <= node.level + slack
                else:
                    assert resting.poses[below.poses[0]].height < node.level

    def test_a_pose_leaves_over_its_nodes_level(self, part, tolerance, function):
        resting, root = self.graph(part, tolerance, function)
        leaves = [node.poses[0] for node in root.walk() if not node.parts]
        for node in root.walk():
            for below in node.parts:
                if not below.parts:
                    pose = resting.poses[below.poses[0]]
                    way_out = pose.height + pose.barrier
                    if leaves.count(pose.index) == 1:
                        assert way_out == pytest.approx(node.level, rel=1e-12)
                    else:  # a shelf, maybe, which parts higher up
                        assert way_out <= node.level * (1.0 + 1e-12)

    def test_transitions_are_eq_8(self, part, tolerance, function):
        _, root = self.graph(part, tolerance, function)
        assert root.probability == pytest.approx(1.0, abs=1e-15)
        for node in root.walk():
            if node.parts:
                assert min(node.angles) >= 0.0
                assert sum(node.transitions) == pytest.approx(1.0, abs=1e-14)
                assert np.array(node.transitions) * sum(node.angles) == pytest.approx(
                    node.angles, abs=1e-14)
                for below, share in zip(node.parts, node.transitions, strict=True):
                    assert below.probability == pytest.approx(
                        node.probability * share, abs=1e-15)

    def test_products_down_the_tree_are_the_estimate(self, part, tolerance, function):
        _, root = self.graph(part, tolerance, function)
        found = estimate(part, "eae" if function == "R" else "meae",
                         cluster_tolerance=tolerance, round_sides=0)
        total = dict.fromkeys(root.poses, 0.0)
        waiting = [(root, 1.0)]
        while waiting:
            node, product = waiting.pop()
            waiting += [(below, product * share)
                        for below, share in zip(node.parts, node.transitions, strict=True)]
            if not node.parts:
                total[node.poses[0]] += product
        for pose in found.poses:
            assert total[pose.index] == pytest.approx(pose.probability, abs=1e-13)

    def test_saddles_are_equilibria_at_the_levels(self, part, tolerance, function):
        resting, root = self.graph(part, tolerance, function)
        body = resting.body
        for node in root.walk():
            if node.parts:
                assert np.linalg.norm(node.saddle) == pytest.approx(1.0, abs=1e-12)
                for height in (body.r(node.saddle), body.R(node.saddle)):
                    assert height * body.radius == pytest.approx(node.level, rel=1e-6)

    def test_components_do_not_exceed_the_sphere(self, part, tolerance, function):
        _, root = self.graph(part, tolerance, function)
        for node in root.walk():
            assert sum(node.angles) <= 4.0 * np.pi * (1.0 + 1e-12)

    def test_walk_goes_from_the_top_down_and_meets_every_node_once(
            self, part, tolerance, function):
        resting, root = self.graph(part, tolerance, function)
        nodes = list(root.walk())
        assert nodes[0] is root
        leaves = sum(not node.parts for node in nodes)
        assert len({id(node) for node in nodes}) == len(nodes) == 2 * leaves - 1
        assert leaves >= len(resting.poses)
        place = {id(node): k for k, node in enumerate(nodes)}
        for node in nodes:
            for below in node.parts:
                assert place[id(below)] > place[id(node)]

    def test_prints_a_line_a_node(self, part, tolerance, function):
        _, root = self.graph(part, tolerance, function)
        lines = str(root).splitlines()
        nodes = list(root.walk())
        assert len(lines) == len(nodes)
        for line, node in zip(lines, nodes, strict=True):
            assert line.lstrip().startswith("{" + " ".join(map(str, node.poses)) + "}")
            assert f"{node.probability:.4f}" in line
            assert ("splits at" in line) == bool(node.parts)


@pytest.mark.parametrize("tolerance", [0.0, 0.005])
@pytest.mark.parametrize("part", PARTS.values(), ids=PARTS)
def test_r_and_R_share_their_splits(part, tolerance):
    of_r, of_R = (splitting_graph(resting_poses(part, tolerance, 0), f) for f in ("r", "R"))
    for one, other in zip(of_r.walk(), of_R.walk(), strict=True):
        assert one.poses == other.poses
        assert one.level == other.level
        assert one.saddle is None or np.array_equal(one.saddle, other.saddle)


def test_r_is_measured_unless_R_is_asked_for():
    resting = resting_poses(PARTS["random"], 0.0, round_sides=0)
    assert str(splitting_graph(resting)) == str(splitting_graph(resting, "r"))
    assert str(splitting_graph(resting)) != str(splitting_graph(resting, "R"))


def test_a_box_written_out():
    # The faces at 1/2 and at 1 join over the edges at sqrt(1/4 + 1); those at 3/2 come in
    # over sqrt(1/4 + 9/4).
    root = splitting_graph(resting_poses(PARTS["box"], 0.0, round_sides=0))
    levels = sorted(node.level for node in root.walk() if node.parts)
    assert levels == pytest.approx([np.sqrt(5.0) / 2.0] * 3 + [np.sqrt(10.0) / 2.0] * 2)
    assert all(len(node.poses) > 4 for node in root.walk()
               if node.parts and node.level > 1.5)


def test_a_single_pose_is_a_tree_of_one_node():
    part = part_from_mesh(*random_polyhedron(6, 1329), center_of_mass=(-1.18, 0.55, 0.92))
    root = splitting_graph(resting_poses(part, 0.0, round_sides=0))
    assert list(root.walk()) == [root]
    assert root.poses == (0,)
    assert root.probability == 1.0
    assert str(root) == "{0}  p = 1.0000"
