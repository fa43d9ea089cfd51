"""The comparison of priors: how bodies are halved, and what is reported of them."""

from __future__ import annotations

import numpy as np

from ros_pose_stats.statistics.posterior import PriorFit
from training.posterior_samples import RESTITUTIONS, Sample
from training.weigh_posterior import DROPS, PAGE, compare, halved, page


def body(number, restitution):
    counts = np.random.default_rng(number).multinomial(1000, (0.6, 0.3, 0.095, 0.005))
    return Sample(number, restitution, np.array((0.55, 0.33, 0.1, 0.02)), 0.03, np.arange(4),
                  counts)


def test_both_halves_are_all_drops():
    some = [body(number, 0.5) for number in range(3)]
    for one, case in zip(some, halved(some), strict=True):
        assert case.sequence.size == 500
        assert (case.counts(500) + case.reference == one.count).all()


def test_a_row_for_each_prior_and_number_of_drops():
    fits = dict.fromkeys(RESTITUTIONS, PriorFit(0.0, 0.5, 0.0, 0.0, 0.5))
    some = [body(number, rho) for number in range(8) for rho in RESTITUTIONS]
    rows = compare(some, {"one": fits, "same": fits})
    assert [row[:2] for row in rows] == [[name, f"{drops}"] for name in ("one", "same")
                                         for drops in DROPS]
    assert [row[2:] for row in rows[:len(DROPS)]] == [row[2:] for row in rows[len(DROPS):]]
    errors = [float(row[2]) for row in rows[:len(DROPS)]]
    assert errors[-1] < errors[0] < 10.0


def test_the_stored_page_is_one_of_this_command():
    text = PAGE.read_text(encoding="utf-8")
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if " ± " in line]
    assert len(rows) == 3 * len(DROPS)
    assert page(rows, 820) == text
