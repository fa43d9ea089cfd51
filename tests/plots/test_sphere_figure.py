"""The sphere of poses and the reachable sets as figures."""

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, resting_poses, splitting_graph
from ros_pose_stats.plots.reachable import components_at, reachable_figure, telling_energies
from ros_pose_stats.plots.sphere import sphere_figure
from ros_pose_stats.resting.pose_sphere import pose_sphere
from ros_pose_stats.shapes.closed_forms import box
from tests.bodies import random_polyhedron
from tests.plots.texts import clipped, overlapping


@pytest.fixture(scope="module")
def block():
    resting = resting_poses(part_from_mesh(*box(0.04, 0.03, 0.02)))
    return resting, splitting_graph(resting), pose_sphere(resting, 60)


@pytest.mark.parametrize("function", ["r", "R"])
def test_numbers_units_and_axes_are_there_and_nothing_overlaps(block, function):
    _, root, sphere = block
    figure = sphere_figure(sphere, function, root)
    texts = {text.get_text() for axes in figure.axes for text in axes.texts}
    assert {str(index) for index in root.poses} <= texts
    assert any("+y" in text for text in texts)
    assert "mm" in figure.axes[-1].get_xlabel()
    assert figure.axes[-1].get_xlabel().startswith(f"{function}(u)")
    figure.canvas.draw()
    assert overlapping(figure) == []
    assert clipped(figure) == []


def test_components_of_a_box_at_an_energy_are_those_of_its_edges(block):
    _, root, sphere = block
    half = np.array([0.02, 0.015, 0.01])
    # R over an edge: two half sides; the lowest way out of the largest faces leads over it.
    edges = sorted(float(np.hypot(*half[list(pair)])) for pair in ((0, 1), (0, 2), (1, 2)))
    assert sorted({node.level for node in root.walk() if node.level}) == pytest.approx(
        edges[:2], rel=1e-9)
    assert len(components_at(root, 1.01 * edges[1], sphere.heights)) == 1
    assert len(components_at(root, 0.99 * edges[1], sphere.heights)) == 3
    # The two smallest faces lie higher than this.
    assert len(components_at(root, 0.99 * edges[0], sphere.heights)) == 4
    assert len(components_at(root, 1.01 * half[2], sphere.heights)) == 2


def test_reachable_pixels_are_those_below_the_energy(block):
    _, root, sphere = block
    energies = telling_energies(root)
    assert energies == sorted(energies, reverse=True)
    figure = reachable_figure(sphere, root, energies)
    discs = [axes for axes in figure.axes if axes.images]
    assert len(discs) == 2 * len(energies)
    for k, axes in enumerate(discs):
        shown = np.ma.getdata(axes.images[0].get_array())
        inside = sphere.pose[k % 2] >= 0
        below = sphere.R[k % 2][inside] <= energies[k // 2]
        assert ((shown[inside] > 0) == below).all()
    figure.canvas.draw()
    assert clipped(figure) == []


def test_a_random_body_is_drawn_with_labels_that_share_a_place():
    resting = resting_poses(part_from_mesh(*random_polyhedron(60, 2)), 0.0)
    figure = sphere_figure(pose_sphere(resting, 60), "R", splitting_graph(resting))
    labels = [text.get_text() for axes in figure.axes[:2] for text in axes.texts]
    told = {int(number) for label in labels if label[0].isdigit()
            for number in label.rstrip(".").split(",")}
    assert told <= set(range(len(resting.poses)))
    assert len(told) > 3
    figure.canvas.draw()
    assert clipped(figure) == []
