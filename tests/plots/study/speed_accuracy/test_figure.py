"""The chart of speed against accuracy."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.collections import LineCollection

from ros_pose_stats.errors import RequestError
from ros_pose_stats.plots.files import save_figure
from ros_pose_stats.plots.study.speed_accuracy import (
    ChartPanel,
    ChartPoint,
    pareto_front,
    speed_accuracy_figure,
)
from ros_pose_stats.plots.study.speed_accuracy.points import ESTIMATORS, KINDS, key_label
from tests.volume import few_quick

from ...synthetic import chart_panels, chart_points
from ...texts import clipped, figure_texts, overlapping

PANELS = chart_panels()


@pytest.fixture(scope="module")
def figure():
    drawn = speed_accuracy_figure(PANELS)
    drawn.canvas.draw()
    return drawn


def markers(axes):
    """Places of the markers of each kind."""
    return {line.get_marker(): np.column_stack(line.get_data()) for line in axes.lines
            if line.get_marker() != "None"}


def bars(axes):
    """Seconds, low and high of every bar."""
    return np.array([(line[0, 0], line[0, 1], line[1, 1]) for drawn in axes.collections
                     if isinstance(drawn, LineCollection) for line in drawn.get_segments()])


def written(axes):
    return [text.get_text() for text in axes.texts]


@pytest.mark.long
def test_axes_are_logarithmic_and_shared(figure):
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "paper-size, 9 vertices", "200 vertices", "2 000 vertices"]
    for axes in figure.axes:
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
        assert axes.get_xlim() == figure.axes[0].get_xlim()
        assert axes.get_ylim() == figure.axes[0].get_ylim()


def test_ticks_are_times_and_plain_percentage_points(figure):
    axes = figure.axes[0]
    across = [text.get_text() for text in axes.get_xticklabels()]
    assert {"100 µs", "1 ms", "10 ms", "100 ms", "1 s", "10 s"} == set(across)
    assert [text.get_text() for text in axes.get_yticklabels()] == [
        "0.2", "0.5", "1", "2", "5", "10"]
    assert figure.axes[-1].get_xlabel() == "time of a part on one core"
    assert "error of a probability, percentage points" in figure_texts(figure).splitlines()


def test_it_says_what_is_measured_and_what_the_markers_mean(figure):
    head = "\n".join(text.get_text() for text in figure.texts)
    for part in ("one core", "median over parts", "root mean square", "0.2, 0.5\nand 0.8",
                 "noise of the reference removed", "Bars: 90 % interval"):
        assert part in head
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "estimator of the paper or before it", "split estimator", "split and n drops (hybrid)",
        "n drops", "other software"]


def test_another_estimator_is_named_beside_split():
    new = ChartPoint("even", "estimator", 1.0, 0.2, 0.1, 0.3)
    points = [*PANELS[0].points, new]
    assert key_label("estimator", points) == "split and even estimators"
    assert key_label("simulation", points) == "n drops"


@pytest.mark.parametrize("place", range(3))
def test_every_point_is_drawn_with_its_bar(figure, place):
    axes, points = figure.axes[place], PANELS[place].points
    bottom, top = axes.get_ylim()
    for name, kind in KINDS.items():
        mine = [(one.seconds, 100.0 * one.error) for one in points if one.kind == name]
        assert markers(axes)[kind.marker] == pytest.approx(np.array(mine))
    expected = sorted((one.seconds, max(100.0 * one.low, bottom), 100.0 * one.high)
                      for one in points)
    assert np.array(sorted(map(tuple, bars(axes)))) == pytest.approx(np.array(expected))
    assert (bars(axes)[:, 1] >= bottom).all()
    assert (bars(axes)[:, 2] <= top).all()
    assert any(one.low <= 0.0 for one in points)


@pytest.mark.parametrize("place", range(3))
def test_every_point_and_series_is_named_once(figure, place):
    names = [one.name for one in PANELS[place].points]
    assert sorted(written(figure.axes[place])) == sorted([
        *names, "hybrid", "drop simulation", "MuJoCo", "nothing is both\nfaster and more exact"])


def test_no_text_lies_on_another_or_is_cut_off(figure):
    assert overlapping(figure) == []
    assert clipped(figure) == []


def test_names_lie_in_their_panel_and_cover_no_marker(figure):
    for axes in figure.axes:
        places = axes.transData.transform(np.vstack(list(markers(axes).values())))
        for text in axes.texts:
            box = super(type(text), text).get_window_extent()
            assert axes.bbox.x0 <= box.x0 < box.x1 <= axes.bbox.x1
            assert axes.bbox.y0 <= box.y0 < box.y1 <= axes.bbox.y1
            assert not any(box.contains(x, y) for x, y in places)


def test_estimators_stand_in_one_column_in_the_order_of_their_errors(figure):
    for axes, panel in zip(figure.axes, PANELS, strict=True):
        errors = {one.name: one.error for one in panel.points if one.kind in ESTIMATORS}
        boxes = {text.get_text(): super(type(text), text).get_window_extent()
                 for text in axes.texts if text.get_text() in errors}
        assert np.ptp([box.x1 for box in boxes.values()]) < 1.5
        assert sorted(boxes, key=lambda name: boxes[name].y0) == sorted(errors, key=errors.get)
        assert all(text.arrow_patch is not None for text in axes.texts
                   if text.get_text() in errors)


def test_the_stair_runs_along_the_front_to_the_edges(figure):
    for axes, panel in zip(figure.axes, PANELS, strict=True):
        corners = np.column_stack(axes.lines[0].get_data())
        for place in pareto_front(panel.points):
            one = panel.points[place]
            assert np.isclose(corners, (one.seconds, 100.0 * one.error)).all(axis=1).any()
        assert corners[0, 1] == pytest.approx(axes.get_ylim()[1])
        assert corners[-1, 0] == pytest.approx(axes.get_xlim()[1])


def test_series_are_joined_the_fastest_first():
    shuffled = ChartPanel("a", chart_points(1.0, 1.0)[::-1])
    lines = [line for line in speed_accuracy_figure([shuffled]).axes[0].lines[1:]
             if line.get_marker() == "None"]
    assert [len(line.get_xdata()) for line in lines] == [2, 4, 3]
    assert all((np.diff(line.get_xdata()) > 0.0).all() for line in lines)


def test_markers_differ_without_colour():
    assert len({kind.marker for kind in KINDS.values()}) == len(KINDS)


@pytest.mark.long
@pytest.mark.parametrize("seed", few_quick(range(6), 2))
def test_names_keep_apart_for_other_numbers_too(seed):
    rng = np.random.default_rng(seed)
    points = []
    for one in chart_points(1.0, 1.0):
        slower, worse = rng.lognormal(0.0, (0.3, 0.15))
        points.append(one._replace(seconds=slower * one.seconds, error=worse * one.error,
                                   low=worse * one.low, high=worse * one.high))
    drawn = speed_accuracy_figure([ChartPanel("other numbers", points)])
    drawn.canvas.draw()
    assert overlapping(drawn) == []
    assert clipped(drawn) == []


def test_a_lone_point_is_drawn_too():
    one = ChartPoint("trimesh.poses", "outside", 0.005, 0.087, 0.087, 0.087)
    drawn = speed_accuracy_figure([ChartPanel("one", [one])])
    drawn.canvas.draw()
    assert overlapping(drawn) == []
    assert clipped(drawn) == []
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == ["other software"]


@pytest.mark.long
def test_equal_data_give_equal_files(figure, tmp_path):
    files = save_figure(figure, tmp_path / "a")
    again = save_figure(speed_accuracy_figure(chart_panels()), tmp_path / "b")
    assert [one.read_bytes() for one in files] == [one.read_bytes() for one in again]
    assert "Speed against accuracy" in files[1].read_text(encoding="utf-8")


GOOD = ChartPoint("QSE", "estimator", 1e-3, 0.07, 0.06, 0.08)


@pytest.mark.parametrize(("panels", "says"), [
    ([], "at least one panel, got none"),
    ([ChartPanel("small", [])], "at least one point in the panel 'small', got none"),
    ([ChartPanel("small", [GOOD._replace(error=math.nan)])],
     "an error above 0 for 'QSE' in the panel 'small', got nan; leave the point out"),
    ([ChartPanel("small", [GOOD._replace(error=0.0)])], "got 0.0"),
    ([ChartPanel("small", [GOOD._replace(seconds=math.inf)])], "a time in seconds above 0"),
    ([ChartPanel("small", [GOOD._replace(low=math.nan)])], "finite bounds in order"),
    ([ChartPanel("small", [GOOD._replace(low=0.09)])], "0.09 and 0.08"),
    ([ChartPanel("small", [GOOD._replace(kind="guess")])], "'guess'"),
    ([ChartPanel("small", [GOOD._replace(series="all")])], "without a series"),
])
def test_what_has_no_place_on_the_axes_is_refused(panels, says):
    with pytest.raises(RequestError, match=says):
        speed_accuracy_figure(panels)


def test_pyplot_is_not_loaded():
    code = ("import sys, ros_pose_stats.plots.study.speed_accuracy as chart\n"
            "one = chart.ChartPoint('a', 'outside', 1.0, 0.1, 0.1, 0.1)\n"
            "chart.speed_accuracy_figure([chart.ChartPanel('a', [one])])\n"
            "sys.exit('matplotlib.pyplot' in sys.modules)")
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
