"""A drop over time as a figure."""

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, record_drop, resting_poses, splitting_graph
from ros_pose_stats.plots.trajectory import (
    MOST_LEVELS,
    energy_heights,
    settling_time,
    telling_levels,
    trajectory_figure,
)
from ros_pose_stats.resting.splitting_graph import levels_above, poses_within
from ros_pose_stats.shapes.closed_forms import box, hull_mesh
from tests.plots.texts import clipped, figure_texts, overlapping


@pytest.fixture(scope="module")
def dropped():
    part = part_from_mesh(*box(0.04, 0.03, 0.02), part_id="block")
    return (record_drop(part, 3, seed=7, to_rest=True),
            splitting_graph(resting_poses(part)))


def test_energy_over_weight_begins_at_the_drop_height_and_ends_at_the_pose(dropped):
    drop, _ = dropped
    energy = energy_heights(drop)
    assert energy[0] == drop.heights[0]
    assert energy[-1] == pytest.approx(drop.heights[-1], rel=1e-6)
    assert (energy >= drop.heights - 1e-12).all()


def test_levels_on_the_way_lead_to_the_pose(dropped):
    drop, root = dropped
    levels = levels_above(root, drop.pose)
    heights = [level for level, _ in levels]
    assert heights == sorted(heights, reverse=True)
    assert levels[-1][1] == (drop.pose,)
    assert poses_within(levels, heights[0] * 1.01, root.poses) == root.poses
    assert poses_within(levels, heights[-1] * 0.99, root.poses) == (drop.pose,)
    assert levels_above(root, -1) == []


def test_of_many_levels_those_are_drawn_that_part_most():
    points = np.random.default_rng(3).normal(size=(120, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    part = part_from_mesh(*hull_mesh(points * (0.020, 0.019, 0.018)))
    root = splitting_graph(resting_poses(part, 0.0))
    drop = record_drop(part, 2, seed=1, to_rest=True, cluster_tolerance=0.0)
    levels = levels_above(root, drop.pose)
    assert len(levels) > MOST_LEVELS
    shown = telling_levels(levels, len(root.poses))
    assert len(shown) == MOST_LEVELS
    assert set(shown) <= set(levels)
    assert shown[-1] == levels[-1]
    assert [level for level, _ in shown] == sorted((level for level, _ in shown), reverse=True)
    assert telling_levels(levels[-3:], 9) == levels[-3:]
    assert telling_levels([], 1) == []
    figure = trajectory_figure(drop, root)
    figure.canvas.draw()
    assert clipped(figure) == []
    assert overlapping(figure) == []


def test_what_is_drawn_is_what_was_recorded(dropped):
    drop, root = dropped
    figure = trajectory_figure(drop, root)
    energy, events = figure.axes
    lines = {line.get_label(): line for line in energy.get_lines()}
    assert lines["energy / weight"].get_ydata() == pytest.approx(1e3 * energy_heights(drop))
    assert lines["height of the centre of mass"].get_ydata() == pytest.approx(1e3 * drop.heights)
    impacts = events.get_lines()[0].get_xdata()
    assert len(impacts) == drop.impacts
    assert energy.get_xlim()[1] == settling_time(drop) <= drop.times[-1]
    assert f"pose {drop.pose}" in figure_texts(figure)
    names = [label.get_text() for label in events.get_yticklabels()]
    for name, line in zip(names, events.get_lines(), strict=True):
        assert (line.get_xdata() <= settling_time(drop)).any(), f"nothing to be seen of {name}"
    levels = levels_above(root, drop.pose)
    assert names[-1] == "split"
    assert len(events.get_lines()[-1].get_xdata()) == len(levels)
    assert f"of {drop.impacts}" in events.texts[0].get_text()
    figure.canvas.draw()
    assert clipped(figure) == []
    assert overlapping(figure) == []
    assert np.diff(energy_heights(drop)).max() <= 1e-9 * drop.heights[0]
