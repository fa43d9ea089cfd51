"""The benchmark of hybrid and auto and the fit behind them, tiny: what is reported and how."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.auto import cases, choosing, measure, promises
from benchmarks.auto.sharpening import coverage, drops_needed, sharpening
from benchmarks.report import render_page
from benchmarks.results import Results
from ros_pose_stats.statistics.posterior import PriorFit
from ros_pose_stats.statistics.posterior import fitted as shipped
from training import fit_posterior
from training.posterior_samples import samples


@pytest.fixture(scope="module")
def few():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cases, "SEQUENCE", 300)
        patch.setattr(cases, "REFERENCE", 600)
        return cases.drop_parts(2, lambda _: None)


@pytest.fixture(scope="module")
def parts():
    return samples(shipped.FITTED_METHOD, 60)


class TestTheRun:
    @pytest.mark.long
    def test_sections(self, few, monkeypatch):
        monkeypatch.setattr(choosing, "TARGETS", (0.3, 0.06))
        found = [sharpening(few), drops_needed(few), coverage(few), *choosing.choosing(few)]
        for section in found[:-1]:
            assert len({tuple(row.cells) for row in section.rows}) == 1
            for row in section.rows:
                assert row.targets
                assert all(isinstance(cell, str) or math.isfinite(cell)
                           for cell in row.cells.values())
        assert [row.name for row in found[-2].rows] == ["auto, 30 points", "auto, 6 points",
                                                        "auto, all"]
        assert [row.name for row in found[-1].rows] == sorted({one.family for one in few})
        page = render_page([Results({}, tuple(found))])
        assert all(f"## {section.title}" in page for section in found)

    def test_unsettled_drops_are_not_counted(self, few):
        case = few[0]._replace(sequence=np.array([0, -1, 1, 0], np.int16))
        assert case.counts(3).sum() == 2 and case.counts(4)[0] == 2

    def test_promises_by_family(self, few):
        for section in promises.promises(few):
            assert [row.name for row in section.rows] == [*sorted({one.family for one in few}),
                                                          "all"]
            assert section.rows[-1].cells["cases"] == len(few)
            assert all(row.targets == () for row in section.rows)  # too few to be judged
        stops = [promises.stop_alone(one, 0.1) for one in few]
        assert all(one is not None and one.drops in (100, 150, 225) for one in stops)
        assert promises.stop_alone(few[0], 1e-4) is None  # its drops do not suffice

    def test_cases_are_kept_in_a_file(self, few, tmp_path):
        file = tmp_path / "cases.npz"
        cases.write_cases(few, file)
        again = measure.cases_of(1, file, print)
        assert [one.restitution for one in again] == list(cases.RESTITUTIONS)
        for one, other in zip(again, few, strict=False):
            assert one.counts(300).tolist() == other.counts(300).tolist()
            assert one.reference.tolist() == other.reference.tolist()

    def test_the_noise_of_the_reference_is_taken_off(self, few):
        """The error of as many other drops of the same part is their own noise alone."""
        case, random = few[0], np.random.default_rng(1)
        p, n = case.reference / 600, 600
        squares = [case._replace(reference=random.multinomial(n, p)).square_error(p)
                   for _ in range(400)]
        noise = float(np.mean(p * (1.0 - p) / n))
        assert np.mean(squares) == pytest.approx(0.0, abs=4.0 * noise / math.sqrt(400))


    def test_old_cases_are_refused(self, few, tmp_path):
        file = tmp_path / "cases.npz"
        cases.write_cases([one._replace(number=one.number + 1) for one in few], file)
        with np.load(file) as found:
            columns = dict(found) | {"family": np.array([one.family for one in few])}
        np.savez(file, **columns)
        with pytest.raises(ValueError, match="remove it"):
            measure.cases_of(1, file, print)

    def test_all_families_are_timed_at_all_restitutions(self):
        order = [(number % len(cases.KINDS), rho) for number in range(200)
                 for rho in cases.RESTITUTIONS]
        assert set(order[::choosing.TIMED_EVERY]) == set(order)


@pytest.mark.long
class TestFit:
    @pytest.mark.long
    def test_the_shipped_numbers_are_about_the_likeliest(self, parts):
        """On a few of the bodies; any of the five moved by half its size or so is less likely.

        If the shipped ones were right, a given other one would be e^3 times as likely in at most
        one of e^3 sets of bodies.
        """
        moves = []
        for restitution, row in zip(shipped.FITTED_AT, shipped.FITTED, strict=True):
            some = [one for one in parts if one.restitution == restitution]
            best = fit_posterior.log_likelihood(some, PriorFit(*row))
            for which, factors in enumerate(((), (0.2, 4.0), (0.1, 8.0), (0.1, 8.0),
                                              (0.1, 3.0))):
                steps = factors or (row[0] - 0.7, row[0] + 0.7)
                for step in steps:
                    moved = list(row)
                    moved[which] = step * row[which] if factors else step
                    moves.append(fit_posterior.log_likelihood(some, PriorFit(*moved)) - best)
        assert max(moves) < 3.0
        assert sum(move < -3.0 for move in moves) > 0.6 * len(moves)

    def test_the_bound_of_an_estimate_alone_is_kept_on_nine_parts_of_ten(self, parts):
        """Of n parts, within three standard errors of the binomial distribution; the drops'
        noise widens both the distance and the bound."""
        kept = []
        for one in parts:
            share, drops = one.count / one.count.sum(), one.count.sum()
            noise = float(np.mean(share * (1.0 - share))) / drops
            alone = one.prior().updated(np.zeros_like(one.count))
            apart = float(np.mean(np.square(alone.probability - share)))
            kept.append(apart <= alone.error_quantile() ** 2
                        * (1.0 + noise / alone.expected_error ** 2))
        error = math.sqrt(0.9 * 0.1 / len(kept))
        assert np.mean(kept) == pytest.approx(0.9, abs=3.0 * error + 0.03)

    def test_the_source_holds_what_was_fitted(self):
        fits = {rho: PriorFit(*row) for rho, row in
                zip(shipped.FITTED_AT, shipped.FITTED, strict=True)}
        text = fit_posterior.source(shipped.FITTED_METHOD, fits)
        assert text == fit_posterior.MODULE.read_text(encoding="utf-8")
