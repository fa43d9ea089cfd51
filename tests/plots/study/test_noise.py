"""The figure of the noise."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats.errors import RequestError
from ros_pose_stats.plots.files import save_figure
from ros_pose_stats.plots.study.probabilities import noise_figure

from ..synthetic import DROPS, counted, probabilities

SIMULATED = counted(probabilities())
DRAWN = counted(SIMULATED, seed=4)
LARGEST_FILE = 1_500_000


@pytest.fixture
def figure():
    return noise_figure(DRAWN, SIMULATED, DROPS, 0.0327)


@pytest.fixture
def axes(figure):
    return figure.axes[0]


def test_one_dot_a_pose_simulated_across_and_drawn_up(axes):
    dots = axes.lines[0]
    assert len(SIMULATED) > 20_000
    assert np.array_equal(dots.get_xdata(), SIMULATED)
    assert np.array_equal(dots.get_ydata(), DRAWN)
    assert dots.get_rasterized()


def test_axes_are_square_and_end_at_the_next_tenth():
    axes = noise_figure([0.1, 0.42], [0.12, 0.61], 100, 0.03).axes[0]
    assert axes.get_xlim() == axes.get_ylim() == pytest.approx((0.0, 0.7))
    assert axes.get_aspect() == 1.0
    axes = noise_figure([0.3], [0.0], 100, 0.03).axes[0]
    assert axes.get_xlim() == pytest.approx((0.0, 0.3))


def test_the_diagonal_is_drawn(axes):
    across, up = axes.lines[1].get_data()
    assert tuple(across) == tuple(up) == axes.get_xlim()


def test_it_is_said_in_words(axes):
    assert axes.get_xlabel() == "simulated probability"
    assert axes.get_ylabel() == "redrawn from it, n = 100"
    assert "perfect estimator" in axes.get_title()
    assert "noise of 100 drops is 3.3 %" in axes.get_title()


def test_rounding_beyond_the_bounds_is_let_through():
    axes = noise_figure([0.0, 1.0 + 1e-15], [-1e-17, 1.0], 100, 0.03).axes[0]
    assert axes.get_xlim() == (0.0, 1.0)


def test_few_dots_are_drawn_stronger(axes):
    few = noise_figure([0.1], [0.1], 100, 0.03).axes[0].lines[0]
    assert few.get_alpha() > 3.0 * axes.lines[0].get_alpha()


def test_equal_data_give_equal_small_files(figure, tmp_path):
    files = save_figure(figure, tmp_path / "a")
    again = save_figure(noise_figure(DRAWN, SIMULATED, DROPS, 0.0327), tmp_path / "b")
    assert [one.read_bytes() for one in files] == [one.read_bytes() for one in again]
    assert files[1].stat().st_size < LARGEST_FILE


@pytest.mark.parametrize(("drawn", "simulated", "says"), [
    ([], [], "at least one"),
    ([0.1, 0.2], [0.1], r"shapes \(1,\) and \(2,\)"),
    ([[0.1]], [[0.1]], "rows"),
    ([0.1, np.nan], [0.1, 0.2], "nan at place 1"),
    ([0.1, 0.2], [1.2, 0.2], "1.2 at place 0"),
])
def test_what_is_no_probability_is_refused(drawn, simulated, says):
    with pytest.raises(RequestError, match=says):
        noise_figure(drawn, simulated, 100, 0.03)
