"""The picture of the poses shows what the statistics say."""

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, simulate
from ros_pose_stats.mesh.decimation import visible_triangles
from ros_pose_stats.plots.poses import MOST, placed, pose_pictures, poses_figure
from ros_pose_stats.shapes.closed_forms import box, cylinder
from tests.plots.texts import clipped, figure_texts, overlapping


def test_one_drawing_a_pose_most_probable_first_each_with_its_number():
    part = part_from_mesh(*box(0.04, 0.03, 0.02), part_id="block")
    found = estimate(part)
    figure = poses_figure(part, found)
    heights = [axes.texts[0].get_text() for axes in figure.axes]
    assert heights == [f"centre of mass {1e3 * pose.height:.3g} mm up" for pose in found.poses]
    titles = [axes.get_title() for axes in figure.axes]
    assert len(titles) == len(found.poses) == 6
    for title, pose in zip(titles, found.poses, strict=True):
        assert title.startswith(f"pose {pose.index}: {100 * pose.probability:.1f} %")
    assert f"block: {found.scene}" in figure_texts(figure)
    assert "split" in figure_texts(figure)


def test_the_part_stands_on_the_plate_at_its_height():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    found = estimate(part)
    triangles = visible_triangles(part, 100) - part.center_of_mass
    for pose in found.poses:
        heights = placed(triangles, pose)[:, :, 2]
        assert heights.min() == pytest.approx(0.0, abs=1e-12)
        assert heights.max() == pytest.approx(pose.top, abs=1e-12)


def test_nothing_of_the_part_or_the_plate_is_cut_off():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    for picture in pose_pictures(part, estimate(part).poses, 0.027, 120):
        rim = np.concatenate([picture[0], picture[-1], picture[:, 0], picture[:, -1]])
        assert (rim == 255).all()
        assert (picture < 255).any()


def test_no_text_covers_another_or_is_cut_off():
    part = part_from_mesh(*box(0.04, 0.03, 0.02), part_id="block")
    figure = poses_figure(part, estimate(part))
    figure.canvas.draw()
    assert overlapping(figure) == []
    assert clipped(figure) == []


def test_many_poses_are_cut_and_that_is_said():
    part = part_from_mesh(*cylinder(24, 0.01, 0.03))
    found = estimate(part, cluster_tolerance=0.0)
    figure = poses_figure(part, found)
    assert len(figure.axes) == MOST
    assert f"{len(found.poses) - MOST} less probable" in figure_texts(figure)


def test_counted_probabilities_come_with_their_errors_and_a_large_mesh_is_thinned(tmp_path):
    rng = np.random.default_rng(1)
    points = rng.normal(size=(4000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    from ros_pose_stats.shapes.closed_forms import hull_mesh

    part = part_from_mesh(*hull_mesh(points * [0.03, 0.02, 0.01]))
    found = simulate(part, 200, seed=1, workers=1)
    figure = poses_figure(part, found)
    assert "±" in figure.axes[0].get_title()
    assert "200 drops" in figure_texts(figure)
    assert 3900 < len(visible_triangles(part, 4000)) <= 4000
    file = tmp_path / "poses.png"
    figure.savefig(file)
    assert file.stat().st_size > 10_000
