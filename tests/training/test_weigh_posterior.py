"""The comparison of priors: how bodies are halved, and what is reported of them."""

from __future__ import annotations

import numpy as np

from benchmarks.auto import cases
from ros_pose_stats.statistics.posterior import PriorFit
from training import weigh_posterior
from training.posterior_samples import RESTITUTIONS, Sample
from training.weigh_posterior import (
    DROPS,
    MANY,
    PAGE,
    USUAL,
    compare,
    halve_drops,
    long_cases,
    page,
)


def body(number, restitution):
    counts = np.random.default_rng(number).multinomial(1000, (0.6, 0.3, 0.095, 0.005))
    return Sample(number, restitution, np.array((0.55, 0.33, 0.1, 0.02)), 0.03, np.arange(4),
                  counts)


def test_both_halves_are_all_drops():
    some = [body(number, 0.5) for number in range(3)]
    for one, case in zip(some, halve_drops(some), strict=True):
        assert case.sequence.size == 500
        assert (case.counts(500) + case.reference == one.count).all()


def test_long_references_have_as_many_drops_as_asked_for(monkeypatch):
    monkeypatch.setattr(cases, "SEQUENCE", 50)
    monkeypatch.setattr(weigh_posterior, "PARTS", 2)
    known, found = long_cases(120)
    assert [(one.number, one.restitution) for one in found] == [(0, USUAL), (1, USUAL)]
    for sample, case in zip(known, found, strict=True):
        assert case.sequence.size == 50 and case.reference.sum() == 120
        assert sample.estimate.shape == case.reference.shape
        assert sample.prior().mean.tolist() == case.prior().mean.tolist()


def test_a_row_for_each_prior_and_number_of_drops():
    fits = dict.fromkeys(RESTITUTIONS, PriorFit(0.0, 0.5, 0.0, 0.0, 0.5))
    some = [body(number, rho) for number in range(8) for rho in RESTITUTIONS]
    rows = compare(some, halve_drops(some), {"one": fits, "same": fits})
    assert [row[:2] for row in rows] == [[name, f"{drops}"] for name in ("one", "same")
                                         for drops in DROPS]
    assert [row[2:] for row in rows[:len(DROPS)]] == [row[2:] for row in rows[len(DROPS):]]
    errors = [float(row[2]) for row in rows[:len(DROPS)]]
    assert errors[-1] < errors[0] < 10.0


def test_the_stored_page_is_one_of_this_command():
    text = PAGE.read_text(encoding="utf-8")
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if " ± " in line]
    short = 3 * len(DROPS)
    assert len(rows) == short + 3 * len(MANY)
    assert page(rows[:short], 820, rows[short:], 20_000) == text
