"""The figure of the estimators."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats.errors import RequestError
from ros_pose_stats.plots.files import save_figure
from ros_pose_stats.plots.study.probabilities import Panel, estimators_figure

from ..synthetic import DROPS, ERRORS, panels
from ..texts import clipped, figure_texts, overlapping

FEW = panels(parts=40)


@pytest.fixture
def figure():
    return estimators_figure(FEW, DROPS)


def test_one_panel_an_estimator_in_three_columns(figure):
    places = [axes.get_subplotspec() for axes in figure.axes]
    assert len(places) == 9
    assert [(place.rowspan.start, place.colspan.start) for place in places] == [
        (row, column) for row in range(3) for column in range(3)]


def test_titles_say_name_error_and_largest_deviation(figure):
    for axes, panel in zip(figure.axes, FEW, strict=True):
        assert axes.get_title() == f"{panel.title}, error {100 * ERRORS[panel.title]:.1f} %"
        assert axes.texts[0].get_text().startswith(
            f"largest deviation {100 * panel.largest:.1f} %")


def test_predictions_lie_across_and_simulated_probabilities_up(figure):
    assert "probability predicted by the estimator" in figure_texts(figure).splitlines()
    assert "simulated probability, n = 100" in figure_texts(figure).splitlines()
    for axes, panel in zip(figure.axes, FEW, strict=True):
        dots = axes.lines[0]
        assert np.array_equal(dots.get_xdata(), panel.estimated)
        assert np.array_equal(dots.get_ydata(), panel.simulated)
        assert dots.get_rasterized()


def test_all_panels_have_the_same_square_axes_and_the_diagonal(figure):
    assert len({(*axes.get_xlim(), *axes.get_ylim(), axes.get_aspect())
                for axes in figure.axes}) == 1
    for axes in figure.axes:
        across, up = axes.lines[1].get_data()
        assert tuple(across) == tuple(up) == axes.get_xlim()


def test_only_the_panel_with_a_curve_has_one_and_says_so(figure):
    for axes, panel in zip(figure.axes, FEW, strict=True):
        assert len(axes.lines) == (3 if panel.title == "QSE" else 2)
        assert ("curve: fitted" in axes.texts[0].get_text()) == (panel.title == "QSE")
    curve = figure.axes[3].lines[2]
    assert curve.get_linestyle() == "-"
    assert curve.get_xdata().max() <= figure.axes[3].get_xlim()[1]


def test_no_text_lies_on_another_or_is_cut_off(figure):
    figure.canvas.draw()
    assert overlapping(figure) == []
    assert clipped(figure) == []


def test_a_lone_panel_is_drawn_too():
    figure = estimators_figure(FEW[:1], DROPS)
    figure.canvas.draw()
    assert len(figure.axes) == 1
    assert overlapping(figure) == []
    assert clipped(figure) == []


@pytest.mark.long
def test_equal_data_give_equal_small_files(tmp_path):
    first = save_figure(estimators_figure(panels(), DROPS), tmp_path / "a")
    again = save_figure(estimators_figure(panels(), DROPS), tmp_path / "b")
    assert [one.read_bytes() for one in first] == [one.read_bytes() for one in again]
    assert first[1].stat().st_size < 1_500_000


@pytest.mark.parametrize(("given", "says"), [
    ([], "at least one panel, got none"),
    ([Panel("MEAE", [], [], 0.03, 0.3)], "MEAE"),
    ([Panel("MEAE", [0.1, 0.2], [0.1], 0.03, 0.3)], "shapes"),
    ([Panel("MEAE", [np.nan], [0.1], 0.03, 0.3)], "nan at place 0"),
])
def test_what_cannot_be_drawn_is_refused(given, says):
    with pytest.raises(RequestError, match=says):
        estimators_figure(given, DROPS)
