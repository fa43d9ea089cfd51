"""Derivatives and suggestions against drops: the summary by itself, and a part of the study."""

from __future__ import annotations

import math

import numpy as np
import pytest

from training.design.bodies import INSERT, all_parts, make_case
from training.design.gains import Gain, measure_gain
from training.design.page import page, summarise_gains, summarise_slopes
from training.design.slopes import Slope, measure_slopes

SOME = ("polyhedra 0.25", "prisms", "machined", "weighted", INSERT)


def made_up(count, factor, noise):
    """Cases whose estimates are the truth times a factor, measured with noise."""
    draw = np.random.default_rng(3)
    truth = draw.normal(0.0, 0.05, count)
    return [Slope("made up", k, "face", factor * one, 0.005, one + draw.normal(0.0, noise), noise,
                  1000) for k, one in enumerate(truth.tolist())]


def test_the_slope_is_found_through_the_noise_of_the_drops():
    # Noise as large as the effects would halve a slope that does not take it off.
    found = summarise_slopes(made_up(4000, 1.1, 0.05))
    assert found["slope"] == pytest.approx(1.1, abs=4.0 * found["slope_error"])
    assert found["slope_error"] < 0.06
    assert found["apart"] == pytest.approx(0.005, abs=0.01)
    assert found["parts"] == 4000
    assert summarise_slopes(made_up(400, 1.1, 1e-5))["right"] == 1.0
    assert summarise_slopes(made_up(400, -1.0, 1e-5))["right"] == 0.0


def test_the_page_tells_all_of_it():
    gains = [Gain("made up", k, 0.3, 0.05, 0.01, 0.04, 0.01, 9, 10, 3, 1.0) for k in range(4)]
    assert summarise_gains(gains) == {
        "parts": 4, "unchanged": 0, "rose": 4, "held": 0.9, "told": 40,
        "estimated": pytest.approx(0.05), "measured": pytest.approx(0.04)}
    text = page(made_up(40, 1.0, 0.01), gains)
    assert "40 parts of all families" in text and "nan" not in text
    assert text.count("| made up") == 4


def test_equal_arguments_give_the_same_case():
    one, two = make_case(INSERT, 1), make_case(INSERT, 1)
    assert one.space.part.digest == two.space.part.digest
    assert (one.wanted, one.restitution) == (two.wanted, two.restitution)
    assert len(list(all_parts(2))) == 50


@pytest.mark.long
def test_some_families():
    slopes, gains = [], []
    for family in SOME:
        case = make_case(family, 3)
        slopes += measure_slopes(case, 2)
        gains.append(measure_gain(case, 2))
    told, gained = summarise_slopes(slopes), summarise_gains(gains)
    assert abs(told["slope"] - 1.0) < 0.2 + 3.0 * told["slope_error"]
    clear = told["clear"]
    assert clear >= 5
    # Nine in ten are right, but for three standard errors of so few.
    assert told["right"] >= 0.9 - 3.0 * math.sqrt(0.9 * 0.1 / clear)
    assert told["held"] >= 0.9 - 3.0 * math.sqrt(0.9 * 0.1 / told["cases"])
    assert gained["held"] >= 0.9 - 3.0 * math.sqrt(0.9 * 0.1 / gained["told"])
    # A gain may be no larger than its error.
    assert sum(one.measured > -3.0 * one.measured_error for one in gains) == len(gains)
    assert gained["rose"] >= len(gains) - 1
