"""What a node has learned of a plate, as it is drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, simulate
from ros_pose_stats.errors import RequestError
from ros_pose_stats.planning.observed import observe_counts
from ros_pose_stats.plots.learning import MOST, learning_figure
from tests.bodies import random_polyhedron
from tests.plots.texts import clipped, overlapping


@pytest.fixture(scope="module", params=[8, 20], ids=["few poses", "many poses"])
def learned(request):
    part = part_from_mesh(*random_polyhedron(request.param, 3))
    model, truth = estimate(part), simulate(part, 1000, restitution=0.1, seed=1)
    shares = np.array([one.probability for one in sorted(truth.poses, key=lambda one: one.index)])
    results = [observe_counts(model, np.round(seen * shares).astype(np.int64))
               for seen in (20, 100, 1000)]
    return [model, *results], truth


def test_every_line_is_what_it_says(learned):
    results, truth = learned
    figure = learning_figure(results, truth)
    drawn = [axes for axes in figure.axes if axes.axison]
    assert len(drawn) == min(MOST, len(truth.poses))
    for axes, true in zip(drawn, truth.poses, strict=False):
        assert axes.get_title(loc="left") == f"pose {true.index}"
        lines = {line.get_label(): line for line in axes.lines}
        of_pose = [next(pose for pose in one.poses if pose.index == true.index)
                   for one in results]
        course = lines["learned from what the camera saw"]
        assert course.get_xdata().tolist() == [one.observed for one in results[1:]]
        assert course.get_ydata().tolist() == pytest.approx(
            [100.0 * pose.probability for pose in of_pose[1:]])
        for label, probability in (("predicted by the model", of_pose[0].probability),
                                   ("true on this plate", true.probability)):
            assert lines[label].get_ydata()[0] == pytest.approx(100.0 * probability)
        low, high = axes.get_ylim()
        band = axes.collections[0].get_paths()[0].vertices[:, 1]
        assert low - 1e-9 <= band.min() <= band.max() <= high + 1e-9
    assert len({round(np.ptp(axes.get_ylim()), 6) for axes in drawn}) == 1


def test_texts_are_whole_and_apart(learned):
    figure = learning_figure(*learned)
    figure.canvas.draw()
    assert overlapping(figure) == [] and clipped(figure) == []


def test_nothing_learned_is_refused(learned):
    results, truth = learned
    with pytest.raises(RequestError, match="method observed"):
        learning_figure([replace(results[0], observed=0)], truth)
