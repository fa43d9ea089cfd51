"""The splitting graph as it is drawn."""

import pytest

from ros_pose_stats import part_from_mesh, resting_poses, splitting_graph
from ros_pose_stats.plots.splitting import MOST, drawn_tree, splitting_figure
from ros_pose_stats.shapes.closed_forms import box, cylinder
from tests.bodies import random_polyhedron
from tests.plots.texts import clipped, overlapping


def drawing(surface, tolerance=0.005):
    resting = resting_poses(part_from_mesh(*surface), tolerance, round_sides=0)
    root = splitting_graph(resting)
    return root, splitting_figure(root, resting.poses)


def test_ties_are_one_split_whose_shares_are_those_of_the_poses():
    root, figure = drawing(box(0.02, 0.02, 0.02))
    top = drawn_tree(root)
    assert len(top.parts) == 6
    assert all(not part.parts for part in top.parts)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts.count(".17") == 6
    assert "6 poses" in texts
    assert sum(text.startswith("16.7 %") for text in texts) == 6


@pytest.mark.parametrize("surface", [box(0.02, 0.02, 0.02), cylinder(12, 0.01, 0.03),
                                     random_polyhedron(14, 5)])
def test_no_text_covers_another_not_even_the_box_of_a_split_into_many(surface):
    _, figure = drawing(surface, 0.0)
    figure.canvas.draw()
    assert overlapping(figure) == []


def test_every_pose_and_every_level_of_a_random_body_is_there():
    root, figure = drawing(random_polyhedron(14, 5), 0.0)
    texts = [text.get_text() for text in figure.axes[0].texts]
    for index in root.poses:
        assert str(index) in texts
    ticks = [float(label.get_text()) for label in figure.axes[0].get_yticklabels()]
    levels = sorted({1e3 * node.level for node in root.walk() if node.level is not None})
    assert ticks == pytest.approx(levels, rel=1e-3)


@pytest.mark.parametrize("surface", [box(0.04, 0.03, 0.02), random_polyhedron(14, 5),
                                     cylinder(64, 0.01, 0.02)])
def test_parts_lie_below_what_they_part_from(surface):
    resting = resting_poses(part_from_mesh(*surface))
    root = splitting_graph(resting)
    figure = splitting_figure(root, resting.poses)
    figure.canvas.draw()
    assert clipped(figure) == []
    ends = [branch for branch in drawn_tree(root).walk() if not branch.parts]
    assert sum(branch.node.probability for branch in ends) == pytest.approx(1.0)


def test_levels_that_are_almost_equal_have_different_labels():
    _, figure = drawing(random_polyhedron(60, 2), 0.0)
    ticks = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert len(set(ticks)) == len(ticks) > 5


def test_a_split_into_too_many_stays_closed():
    root, figure = drawing(cylinder(40, 0.03, 0.01), 0.0)
    top = drawn_tree(root)
    assert {len(branch.node.poses) for branch in top.walk() if not branch.parts} == {1, 40}
    assert any(text.get_text() == "40 poses" for text in figure.axes[0].texts)


def test_a_graph_of_many_poses_is_cut_where_little_comes():
    root, figure = drawing(random_polyhedron(300, 3), 0.0)
    ends = [branch for branch in drawn_tree(root).walk() if not branch.parts]
    assert len(root.poses) > MOST
    assert len(ends) <= MOST
    assert sorted(index for branch in ends for index in branch.node.poses) == list(root.poses)
    figure.canvas.draw()
    assert clipped(figure) == []
