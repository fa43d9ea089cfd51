"""The figures of cost against vertices."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from benchmarks.pictures import STYLES, cost_figure, drop_cost_figure
from ros_pose_stats.plots.files import save_figure
from tests.running import ROOT

VERTICES = (20, 200, 2000, 20000)
STAGES = [("hull", (0.1, 0.5, 3.0, 40.0)), ("body", (0.2, 0.6, 3.1, 41.0)),
          ("nine", (1.5, 3.0, 12.0, 42.0))]

FAMILIES = [("ellipsoid", (10, 100, 1000, 5000), (46.0, 130.0, 456.0, 4000.0)),
            ("rounded box", (24, 120, 1088), (38.0, 50.0, 170.0))]


@pytest.fixture
def figure():
    return cost_figure(VERTICES, STAGES, "Cost")


@pytest.fixture
def axes(figure):
    return figure.axes[0]


def labels(axes):
    return {text.get_text(): text for text in axes.texts}


def test_axes_are_logarithmic_and_named_with_their_units(axes):
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert axes.get_xlabel() == "hull vertices"
    assert axes.get_ylabel() == "time, ms"
    assert axes.get_title() == "Cost"


def test_every_stage_is_drawn_and_named_at_its_end(axes):
    for line, (label, values) in zip(axes.lines, STAGES, strict=False):
        assert line.get_ydata().tolist() == list(values)
        assert label in labels(axes)
        leader = labels(axes)[label].arrow_patch
        assert to_rgb(leader.get_edgecolor()) == to_rgb(line.get_color())


def test_labels_do_not_overlap(figure, axes):
    figure.canvas.draw()
    boxes = [Text.get_window_extent(labels(axes)[label]) for label, _ in STAGES]
    heights = sorted((box.y0, box.y1) for box in boxes)
    assert all(low[1] <= high[0] + 1.0 for low, high in pairwise(heights))


def test_nothing_is_cut_off(figure, axes):
    figure.canvas.draw()
    for text in axes.texts:
        box = text.get_window_extent()
        assert box.x0 >= 0.0
        assert box.x1 <= figure.bbox.x1


def test_the_reference_rises_in_proportion(axes):
    x, y = axes.lines[-1].get_data()
    assert np.log(y[1] / y[0]) == pytest.approx(np.log(x[1] / x[0]))
    assert "slope 1" in labels(axes)


def test_styles_differ_without_colour():
    assert len({(dash, marker) for _, dash, marker in STYLES}) == len(STYLES)
    assert len({to_rgb(colour) for colour, *_ in STYLES}) == len(STYLES)


@pytest.mark.long
def test_both_files_are_written_and_repeatable(figure, tmp_path):
    files = save_figure(figure, tmp_path / "figures" / "cost")
    assert [file.name for file in files] == ["cost.png", "cost.svg"]
    assert files[0].read_bytes().startswith(b"\x89PNG")
    assert "hull vertices" in files[1].read_text(encoding="utf-8")
    again = save_figure(cost_figure(VERTICES, STAGES, "Cost"), tmp_path / "again")
    assert [one.read_bytes() for one in files] == [one.read_bytes() for one in again]


def test_pyplot_is_not_loaded():
    code = ("import sys, benchmarks.pictures as cost\n"
            "cost.cost_figure((1, 10), [('a', (1.0, 2.0))])\n"
            "sys.exit('matplotlib.pyplot' in sys.modules)")
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT).returncode == 0


class TestTheTimeOfADrop:
    @pytest.fixture
    def figure(self):
        return drop_cost_figure(FAMILIES, "Cost of a drop")

    @pytest.fixture
    def axes(self, figure):
        return figure.axes[0]

    def test_axes_are_logarithmic_and_named_with_their_units(self, axes):
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
        assert axes.get_xlabel() == "hull vertices"
        assert axes.get_ylabel() == "time of a drop, µs"
        assert axes.get_title() == "Cost of a drop"

    def test_every_family_is_drawn_and_named(self, axes):
        for line, (label, vertices, cost) in zip(axes.lines, FAMILIES, strict=False):
            assert line.get_xdata().tolist() == list(vertices)
            assert line.get_ydata().tolist() == list(cost)
            assert line.get_label() == label
        assert [text.get_text() for text in axes.get_legend().get_texts()] == [
            label for label, *_ in FAMILIES]

    def test_the_legend_hides_no_point(self, figure, axes):
        figure.canvas.draw()
        box = axes.get_legend().get_window_extent()
        for line in axes.lines:
            shown = axes.transData.transform(np.column_stack(line.get_data()))
            assert not any(box.contains(x, y) for x, y in shown)

    def test_the_reference_rises_in_proportion_and_stays_inside(self, axes):
        x, y = axes.lines[-1].get_data()
        assert np.log(y[1] / y[0]) == pytest.approx(np.log(x[1] / x[0]))
        low, high = axes.get_ylim()
        assert low < y[0] < y[1] < high

    @pytest.mark.long
    def test_an_equal_figure_gives_equal_files(self, figure, tmp_path):
        files = save_figure(figure, tmp_path / "a")
        again = save_figure(drop_cost_figure(FAMILIES, "Cost of a drop"), tmp_path / "b")
        assert [one.read_bytes() for one in files] == [one.read_bytes() for one in again]
        assert files[0].read_bytes().startswith(b"\x89PNG")
