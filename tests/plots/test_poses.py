"""The picture of the poses shows what the statistics say."""

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, simulate
from ros_pose_stats.geometry.shapes.closed_forms import box, cylinder
from ros_pose_stats.plots.poses import MOST, poses_figure


def drawn(figure):
    """Heights (low, high) of the part in each of the drawings."""
    found = []
    for axes in figure.axes:
        body = axes.collections[1]
        heights = body._vec[2]
        found.append((float(heights.min()), float(heights.max())))
    return found


def test_one_drawing_a_pose_most_probable_first_each_with_its_number():
    part = part_from_mesh(*box(0.04, 0.03, 0.02), part_id="block")
    found = estimate(part)
    figure = poses_figure(part, found)
    titles = [axes.get_title() for axes in figure.axes]
    assert len(titles) == len(found.poses) == 6
    for title, pose in zip(titles, found.poses, strict=True):
        assert title.startswith(f"pose {pose.index}: {100 * pose.probability:.1f} %")
        assert f"{1e3 * pose.height:.3g} mm" in title
    assert "block" in figure.get_suptitle()
    assert "combined" in figure.get_suptitle()


def test_the_part_stands_on_the_plate_at_its_height():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    found = estimate(part)
    for (low, high), pose in zip(drawn(poses_figure(part, found)), found.poses, strict=True):
        assert low >= -1e-12
        assert high == pytest.approx(pose.top, abs=1e-12)


def test_many_poses_are_cut_and_that_is_said():
    part = part_from_mesh(*cylinder(24, 0.01, 0.03))
    found = estimate(part, cluster_tolerance=0.0)
    figure = poses_figure(part, found)
    assert len(figure.axes) == MOST
    assert f"{len(found.poses) - MOST} less probable" in figure.get_suptitle()


def test_counted_probabilities_come_with_their_errors_and_a_large_mesh_is_thinned(tmp_path):
    rng = np.random.default_rng(1)
    points = rng.normal(size=(4000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    from ros_pose_stats.geometry.shapes.closed_forms import hull_mesh

    part = part_from_mesh(*hull_mesh(points * [0.03, 0.02, 0.01]))
    found = simulate(part, 200, seed=1, workers=1)
    figure = poses_figure(part, found)
    assert "±" in figure.axes[0].get_title()
    assert "200 drops" in figure.get_suptitle()
    assert all(len(axes.collections[1]._vec[0]) <= 3 * 4000 for axes in figure.axes)
    file = tmp_path / "poses.png"
    figure.savefig(file)
    assert file.stat().st_size > 10_000
