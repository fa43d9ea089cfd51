"""The figure of square prisms."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from ros_pose_stats.plots.files import save_figure
from ros_pose_stats.plots.study.prisms import DICE, GREYS, LINES, OFFSET, TICKS, prisms_figure
from tests.plots.texts import figure_texts

RATIOS = np.geomspace(0.3, 3.0, 31)
LOW = RATIOS / (1.0 + RATIOS)
HIGH = RATIOS ** 2 / (1.0 + RATIOS ** 2)
PANELS = [("old", [("a", LOW), ("b", HIGH), ("c", LOW)]), ("new", [("d", 0.9 * LOW)])]
ROWS = np.array([(0.5, 0.3, 0.25, 0.36), (1.0, 0.66, 0.6, 0.7), (2.0, 1.0, 0.98, 1.0)])
SIMULATED = [("soft", ROWS), ("middle", ROWS), ("hard", ROWS)]


@pytest.fixture
def figure():
    return prisms_figure(RATIOS, PANELS, SIMULATED, ROWS, "Prisms", "Bars: 95 % intervals.")


@pytest.fixture
def old(figure):
    return figure.axes[0]


def lines(axes):
    """Curves by label, without the lines of the points."""
    return {line.get_label(): line for line in axes.lines if len(line.get_xdata()) == len(RATIOS)}


def points(axes):
    return {bars.get_label(): bars.lines for bars in axes.containers}


def test_axes_are_named_with_their_units_and_have_plain_ticks(figure, old):
    figure.canvas.draw()
    for axes in figure.axes:
        assert axes.get_xscale() == "log"
        assert axes.get_xlabel() == "length / width of the prism"
        assert [text.get_text() for text in axes.get_xticklabels()] == [
            "0.3", "0.5", "1", "2", "3"]
        assert axes.get_ylim()[0] <= 0.0 < 100.0 <= axes.get_ylim()[1]
        assert axes.get_xlim()[0] < TICKS[0] < TICKS[-1] < axes.get_xlim()[1]
    assert old.get_ylabel() == "probability of the four sides together, %"
    assert [axes.get_title() for axes in figure.axes] == ["old", "new"]
    assert "Prisms" in figure_texts(figure).splitlines()
    assert "Bars: 95 % intervals." in figure_texts(figure).splitlines()


def test_curves_are_in_percent_and_equal_ones_are_one(figure, old):
    assert lines(old).keys() == {"a = c", "b"}
    assert lines(old)["b"].get_ydata() == pytest.approx(100.0 * HIGH)
    assert lines(old)["a = c"].get_xdata() == pytest.approx(RATIOS)
    assert lines(figure.axes[1]).keys() == {"d"}


def test_the_legend_lists_curves_from_the_highest_at_the_right(old):
    assert [text.get_text() for text in old.get_legend().get_texts()] == ["b", "a = c"]


def test_points_are_in_every_panel_with_their_bars(figure):
    for axes in figure.axes:
        found = points(axes)
        assert list(found) == ["soft", "middle", "hard", "measured dice"]
        for markers, _, (bars,) in found.values():
            assert markers.get_ydata() == pytest.approx(100.0 * ROWS[:, 1])
            ends = np.array(bars.get_segments())[:, :, 1]
            assert ends == pytest.approx(100.0 * ROWS[:, 2:])


def test_bars_of_one_prism_stand_side_by_side(old):
    ratios = [markers.get_xdata() / ROWS[:, 0] for markers, *_ in points(old).values()]
    assert np.array(ratios) == pytest.approx(
        np.array([[1.0 / OFFSET] * 3, [1.0] * 3, [OFFSET] * 3, [1.0] * 3]))


def test_the_dice_are_squares_and_the_simulation_diamonds(old):
    markers = {label: parts[0] for label, parts in points(old).items()}
    assert [each.get_marker() for each in markers.values()] == ["D", "D", "D", "s"]
    assert to_rgb(markers["measured dice"].get_markeredgecolor()) == to_rgb(DICE)
    assert len({each.get_markerfacecolor() for each in markers.values()}) == 4


def test_nothing_overlaps_and_nothing_is_cut_off(figure):
    figure.canvas.draw()
    for axes in figure.axes:
        curves, marks = axes.get_legend(), next(
            each for each in axes.artists if hasattr(each, "get_texts"))
        boxes = [curves.get_window_extent(), marks.get_window_extent()]
        assert not boxes[0].overlaps(boxes[1])
        for box in boxes:
            assert axes.bbox.x0 <= box.x0 < box.x1 <= axes.bbox.x1
            assert axes.bbox.y0 <= box.y0 < box.y1 <= axes.bbox.y1
    texts = [figure._suptitle, figure._supxlabel, *(axes.xaxis.label for axes in figure.axes),
             *(axes.title for axes in figure.axes)]
    boxes = [text.get_window_extent() for text in texts]
    for place, box in enumerate(boxes):
        assert 0.0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert 0.0 <= box.y0 < box.y1 <= figure.bbox.y1
        assert not any(box.overlaps(other) for other in boxes[:place])


def test_styles_differ_without_colour_within_a_panel_of_four(figure):
    assert len({to_rgb(colour) for colour, _ in LINES}) == len(LINES)
    for first in range(len(LINES)):
        four = [str(LINES[(first + step) % len(LINES)][1]) for step in range(4)]
        assert len(set(four)) == 4
    drawn = [line.get_color() for axes in figure.axes for line in lines(axes).values()]
    assert len(set(drawn)) == len(drawn)
    assert to_rgb(DICE) not in {to_rgb(colour) for colour, _ in LINES}
    assert len(set(GREYS)) == len(GREYS)


def test_without_points_there_is_one_legend_a_panel():
    bare = prisms_figure(RATIOS, PANELS[1:], [("stopped", np.empty((0, 4)))])
    assert [text.get_text() for text in bare.axes[0].get_legend().get_texts()] == ["d"]
    assert not bare.axes[0].containers


@pytest.mark.long
def test_both_files_are_written_and_repeatable(figure, tmp_path):
    files = save_figure(figure, tmp_path / "figures" / "prisms")
    assert files[0].read_bytes().startswith(b"\x89PNG")
    assert "measured dice" in files[1].read_text(encoding="utf-8")
    again = save_figure(prisms_figure(RATIOS, PANELS, SIMULATED, ROWS, "Prisms",
                                      "Bars: 95 % intervals."), tmp_path / "again")
    assert [one.read_bytes() for one in files] == [one.read_bytes() for one in again]


def test_pyplot_is_not_loaded():
    code = ("import sys, ros_pose_stats.plots.study.prisms as prisms\n"
            "prisms.prisms_figure((0.3, 3.0), [('all', [('a', (0.1, 0.9))])])\n"
            "sys.exit('matplotlib.pyplot' in sys.modules)")
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
