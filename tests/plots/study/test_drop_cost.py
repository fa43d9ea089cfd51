"""The figure of the cost of a drop against vertices."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats.plots.files import save_figure
from ros_pose_stats.plots.study.cost import drop_cost_figure

FAMILIES = [("ellipsoid", (10, 100, 1000, 5000), (46.0, 130.0, 456.0, 4000.0)),
            ("rounded box", (24, 120, 1088), (38.0, 50.0, 170.0))]


@pytest.fixture
def figure():
    return drop_cost_figure(FAMILIES, "Cost of a drop")


@pytest.fixture
def axes(figure):
    return figure.axes[0]


def test_axes_are_logarithmic_and_named_with_their_units(axes):
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert axes.get_xlabel() == "hull vertices"
    assert axes.get_ylabel() == "time of a drop, µs"
    assert axes.get_title() == "Cost of a drop"


def test_every_family_is_drawn_and_named(axes):
    for line, (label, vertices, cost) in zip(axes.lines, FAMILIES, strict=False):
        assert line.get_xdata().tolist() == list(vertices)
        assert line.get_ydata().tolist() == list(cost)
        assert line.get_label() == label
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        label for label, *_ in FAMILIES]


def test_the_legend_hides_no_point(figure, axes):
    figure.canvas.draw()
    box = axes.get_legend().get_window_extent()
    for line in axes.lines:
        shown = axes.transData.transform(np.column_stack(line.get_data()))
        assert not any(box.contains(x, y) for x, y in shown)


def test_the_reference_rises_in_proportion_and_stays_inside(axes):
    x, y = axes.lines[-1].get_data()
    assert np.log(y[1] / y[0]) == pytest.approx(np.log(x[1] / x[0]))
    low, high = axes.get_ylim()
    assert low < y[0] < y[1] < high


@pytest.mark.long
def test_an_equal_figure_gives_equal_files(figure, tmp_path):
    files = save_figure(figure, tmp_path / "a")
    again = save_figure(drop_cost_figure(FAMILIES, "Cost of a drop"), tmp_path / "b")
    assert [one.read_bytes() for one in files] == [one.read_bytes() for one in again]
    assert files[0].read_bytes().startswith(b"\x89PNG")
