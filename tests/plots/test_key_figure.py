"""The key figure: poses, probabilities and the splitting graph in one picture."""

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, resting_poses, simulate, splitting_graph
from ros_pose_stats.plots.files import RASTER
from ros_pose_stats.plots.key_figure import key_picture
from ros_pose_stats.plots.poses import poses_figure
from ros_pose_stats.plots.shares import shares_figure
from ros_pose_stats.shapes.closed_forms import box
from tests.bodies import random_polyhedron
from tests.plots.texts import clipped, overlapping


@pytest.fixture(scope="module")
def block():
    part = part_from_mesh(*box(0.04, 0.03, 0.02), part_id="block")
    return part, simulate(part, 300, seed=1, workers=1), estimate(part)


def test_bars_are_the_probabilities_with_their_intervals(block):
    _, counted, guessed = block
    figure = shares_figure((counted, guessed))
    axes = figure.axes[0]
    bars = [bar.get_width() for bar in axes.patches]
    by_index = {pose.index: pose for pose in guessed.poses}
    expected = [100 * pose.probability for pose in counted.poses]
    expected += [100 * by_index[pose.index].probability for pose in counted.poses]
    assert bars == pytest.approx(expected)
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == [f"pose {pose.index}" for pose in counted.poses]
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["300 drops", f"estimate ({guessed.method})"]
    assert "%" in axes.get_xlabel()


@pytest.mark.parametrize("surface", [box(0.04, 0.03, 0.02), random_polyhedron(14, 5)])
def test_no_text_of_the_bars_covers_another_or_is_cut_off(surface):
    part = part_from_mesh(*surface)
    figure = shares_figure((simulate(part, 200, seed=1, workers=1), estimate(part)))
    figure.canvas.draw()
    assert overlapping(figure) == []
    assert clipped(figure) == []


def test_the_picture_holds_the_poses_and_more_below(block):
    part, counted, guessed = block
    picture = key_picture(part, (counted, guessed), splitting_graph(resting_poses(part)))
    wide, high = poses_figure(part, counted).get_size_inches()
    assert picture.dtype == np.uint8
    assert picture.shape[1] >= int(wide * RASTER)
    below = picture[int(high * RASTER):]
    assert len(below) > 4 * RASTER
    half = picture.shape[1] // 2
    for side in (below[:, :half], below[:, half:]):  # bars on the left, the graph on the right
        assert 0.01 < (side < 250).any(axis=2).mean() < 0.9


def test_a_part_with_one_pose_has_no_graph():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    graph = splitting_graph(resting_poses(part, 0.9))
    assert graph.level is None
    found = estimate(part, cluster_tolerance=0.9)
    assert key_picture(part, (found,), graph).shape[2] == 3
