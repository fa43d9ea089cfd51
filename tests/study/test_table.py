"""Table I: the paper's, another implementation's, and errors that are known exactly."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from ros_pose_stats.errors import RequestError
from ros_pose_stats.estimators import ESTIMATORS
from ros_pose_stats.study import paper
from ros_pose_stats.study.errors.bootstrap import body_bootstrap
from ros_pose_stats.study.errors.partition import noise_of
from ros_pose_stats.study.errors.simulated_poses import SimulatedPoses, pooled
from ros_pose_stats.study.table import dataset_table, table, table_text
from tests.running import strict_json
from tests.study.tables import compared, drawn, mixed, shipped, some, told
from tests.volume import few_quick

SIGMAS = 3.5
"""Standard errors of a difference that may lie between two implementations. Both drew 1 057
bodies of their own. Of some 60 figures one is further off by chance once in 40 times."""

KNOWN = {
    (0.0, "inertia"): {
        "area": 10.7, "csae": 8.7, "adre": 7.7, "qse": 7.4, "nqse": 6.5, "eae": 6.4, "meae": 3.1,
        "combined": 3.0, "faces": 6.89, "sensitivity": 4.3, "noise": 3.14},
    (0.25, "inertia"): {
        "area": 13.4, "csae": 10.3, "adre": 8.8, "qse": 8.7, "nqse": 7.8, "eae": 8.4, "meae": 3.9,
        "combined": 3.7, "faces": 6.88, "sensitivity": 5.8, "noise": 3.07},
    (0.65, "second"): {
        "area": 15.1, "csae": 11.3, "adre": 9.1, "qse": 9.8, "nqse": 8.7, "eae": 8.9, "meae": 4.0,
        "combined": 3.9, "faces": 6.31, "sensitivity": 6.4, "noise": 3.13},
    (1.0, "inertia"): {
        "area": 27.0, "csae": 15.7, "adre": 10.3, "qse": 14.5, "nqse": 14.2, "eae": 9.1,
        "meae": 5.2, "combined": 5.4, "faces": 5.44, "sensitivity": 8.0, "noise": 2.65},
}
"""Of another implementation with 100 drops a body; points, but for the stable faces."""

KNOWN_BY_RESTITUTION = {"meae": (5.2, 3.2, 2.8), "combined": (4.5, 2.8, 3.6),
                        "eae": (10.4, 8.2, 5.9)}
"""Likewise, at shift 0.25."""

BEST_WEIGHTS = (0.67, 0.81, 1.00)
"""Best c of Eq. 9 there. It was sought from 0 to 1, so that 1.00 stands for all beyond."""

TIED = {"nqse", "eae"}
"""Indistinguishable at shift 0; the paper's data set them 0.6 points apart."""

TURNED = {"pqse", "qse"}
"""0.2 points apart on the paper's bodies, and 0.16 the other way on ours (standard error 0.07)."""


def allowed(error, rounding):
    """Of a difference, in points, where ours has this standard error as a fraction."""
    return SIGMAS * 100.0 * error + rounding


EVERY_DATASET = pytest.mark.parametrize("key", few_quick(KNOWN, 1))


@pytest.fixture
def both(key):
    return compared(*key), KNOWN[key]


@pytest.mark.long
@EVERY_DATASET
class TestAnotherImplementation:
    def test_errors(self, both):
        """Its 100 drops scatter as ours do when the first 100 alone are taken."""
        ours, known = both
        for name in ESTIMATORS.keys() & known:
            row = ours.row(name)
            error = math.hypot(row.pooled.standard_error, row.first.standard_error)
            assert 100.0 * row.pooled.error == pytest.approx(known[name],
                                                             abs=allowed(error, 0.05))

    def test_sensitivity(self, both):
        ours, known = both
        error = math.sqrt(2.0) * ours.sensitivity.standard_error
        assert 100.0 * ours.sensitivity.error == pytest.approx(known["sensitivity"],
                                                               abs=allowed(error, 0.05))

    def test_noise(self, both):
        ours, known = both
        error = math.sqrt(2.0) * ours.pooled_noise.standard_error
        assert 100.0 * ours.pooled_noise.error == pytest.approx(known["noise"],
                                                                abs=allowed(error, 0.005))

    def test_stable_faces(self, both):
        ours, known = both
        poses = shipped(ours.spec.shift, ours.spec.shift_moment).arrays["poses"]
        error = math.sqrt(2.0 / len(poses)) * poses.std()
        assert ours.shapes.mean_poses == pytest.approx(known["faces"],
                                                       abs=SIGMAS * error + 0.005)


@pytest.mark.long
class TestAnotherImplementationAtShiftAQuarter:
    @pytest.mark.parametrize("name", KNOWN_BY_RESTITUTION)
    def test_errors_by_restitution(self, name):
        found = compared(0.25, "inertia").row(name).by_restitution
        for one, known in zip(found.values(), KNOWN_BY_RESTITUTION[name], strict=True):
            error = math.sqrt(2.0) * one.standard_error
            assert 100.0 * one.error == pytest.approx(known, abs=allowed(error, 0.05))

    def test_best_weights(self):
        fits = {one.name: one for one in compared(0.25, "inertia").refits}
        for restitution, known in zip((0.2, 0.5, 0.8), BEST_WEIGHTS, strict=True):
            fit = fits[f"combined, {restitution:g}"]
            assert min(fit.fitted[0], 1.0) == pytest.approx(
                known, abs=SIGMAS * math.sqrt(2.0) * fit.standard_error[0] + 0.005)


class TestThePaper:
    def test_within_a_point_of_table_one_without_shift(self):
        for name in ("csae", "adre", "qse", "pqse", "nqse", "eae", "meae", "combined"):
            assert compared().row(name).pooled.error == pytest.approx(paper.ERRORS[name],
                                                                      abs=0.01)

    def test_pqse_errs_as_in_table_one_without_shift_and_has_lost_the_trend_of_qse(self):
        """The paper: its error is 7.2 points, and its predictions lack the nonlinear trend."""
        found, every = compared(), pooled([
            shipped().simulated(one) for one in shipped().spec.restitutions])
        row = found.row("pqse")
        assert row.pooled.error == pytest.approx(paper.ERRORS["pqse"],
                                                 abs=2.0 * row.pooled.standard_error + 0.0005)
        slope = {name: np.polyfit(told, every.probability - told, 1)[0] for name, told in (
            (name, np.concatenate([one[name] for one in found.estimates.values()]))
            for name in ("qse", "pqse"))}
        assert slope["qse"] > 0.1
        assert abs(slope["pqse"]) < 0.02

    def test_the_order_of_the_estimators_without_shift(self):
        ours = {row.name: row.pooled.error for row in compared().rows if row.name in paper.ERRORS}
        names = sorted(ours, key=lambda name: -paper.ERRORS[name])
        turned = {frozenset((worse, better)) for k, worse in enumerate(names)
                  for better in names[k + 1:] if ours[worse] <= ours[better]}
        assert turned <= {frozenset(TIED), frozenset(TURNED)}

    def test_tied_estimators_differ_by_less_than_two_standard_errors(self):
        dataset, found = shipped(), compared()
        every = pooled([dataset.simulated(one) for one in dataset.spec.restitutions])
        told = found.estimates.values()
        squares = [(np.concatenate([one[name] for one in told]) - every.probability) ** 2
                   - every.noise_variance() for name in sorted(TIED)]
        terms = np.column_stack((*squares, np.ones(len(every.body))))

        def difference(sums):
            return np.sqrt(sums[0] / sums[2]) - np.sqrt(sums[1] / sums[2])

        here = difference(terms.sum(axis=0)[:, None])[0]
        assert abs(here) < 2.0 * body_bootstrap(every.body, terms, difference).std(ddof=1)

    @EVERY_DATASET
    def test_the_standard_errors_and_intervals_fit_a_second_set_of_drops(self, key):
        """|z| below 4 for the rms of z and the coverage, at each shift and restitution."""
        for one in compared(*key).calibration.values():
            assert abs(one.z_rms - one.expected_z_rms) < 4.0 * one.z_rms_error
            assert abs(one.coverage - one.expected_coverage) < 4.0 * one.coverage_error


@pytest.fixture(scope="module")
def probabilities():
    return told(TestKnownErrors.BODIES)[1]


@pytest.fixture(scope="module")
def found():
    """The first forty bodies, the outliers dropped again."""
    return table(some(40))


@pytest.mark.long
class TestKnownErrors:
    BODIES, DROPS = 250, 200

    def test_an_error_beside_as_much_noise_is_recovered(self, probabilities):
        """Within 4 of the told standard errors; with the noise it would be 10 off."""
        dataset = some(self.BODIES)
        truth, known = mixed(dataset, probabilities["meae"], probabilities["csae"], 0.4)
        found = table(drawn(dataset, truth, self.DROPS, 3), rerun=False)
        for one in (found.row("meae").pooled, found.row("meae").first):
            assert one.error == pytest.approx(known, abs=4.0 * one.standard_error)
            assert one.deviation - known > 4.0 * one.standard_error
        for one in found.row("meae").by_restitution.values():
            assert one.error == pytest.approx(known, abs=4.0 * one.standard_error)

    def test_an_exact_estimator_has_none(self, probabilities):
        """Its excess is below 4 of its standard errors, here from sums over bodies."""
        dataset = some(self.BODIES)
        counted = drawn(dataset, probabilities["eae"], self.DROPS, 4)
        found = table(counted, rerun=False)
        every = pooled([counted.simulated(one) for one in counted.spec.restitutions])
        excess = ((np.tile(probabilities["eae"], 3) - every.probability) ** 2
                  - every.noise_variance())
        error = np.sqrt((np.bincount(every.body, excess) ** 2).sum()) / len(excess)
        assert abs(found.row("eae").pooled.error_variance) < 4.0 * error
        assert found.row("eae").pooled.low == 0.0
        assert found.row("csae").pooled.low > 0.03

    def test_equal_probabilities_at_all_restitutions_have_no_sensitivity(self, probabilities):
        found = table(drawn(some(self.BODIES), probabilities["meae"], self.DROPS, 5), rerun=False)
        assert found.sensitivity.low == 0.0
        assert found.sensitivity.error < 0.01  # the two noises together are 0.032

    def test_noise_is_unbiased(self):
        """Its square averages to p (1 - p) / n, for every number of drops that tell p."""
        p, drops = 0.3, 100
        for settled in (2, 3, 7):
            mean = sum(math.comb(settled, count) * p ** count * (1.0 - p) ** (settled - count)
                       * noise_of(SimulatedPoses([0], [count], [settled]), drops).error ** 2
                       for count in range(settled + 1))
            assert mean == pytest.approx(p * (1.0 - p) / drops, rel=1e-12)


class TestCombined:
    def test_the_first_drops_help_the_estimate_and_the_estimate_helps_them(self):
        """Their noise alone is 3 points; the gains are ten times the standard errors."""
        found = compared()
        both = found.combined.pooled
        assert both.error + 10.0 * both.standard_error < found.pooled_noise.error
        assert both.error + 3.0 * both.standard_error < found.row("split").pooled.error

    def test_it_is_held_against_drops_that_it_was_not_given(self):
        """A body's first drops alone would agree with themselves but for nothing."""
        dataset = some(60)
        found = table(drawn(dataset, told(60)[1]["meae"], 1000, 7), rerun=False)
        assert 0.0 < found.combined.pooled.error < found.pooled_noise.error


@pytest.mark.long
class TestOutliers:
    def test_they_are_the_largest_of_different_bodies(self, found):
        dataset = some(40)
        combined = found.estimates[0.2]["combined"]
        away = np.stack([abs(dataset.simulated(one, 100).probability - combined)
                         for one in (0.2, 0.5, 0.8)], axis=1)
        largest = np.array([away[dataset.body == body].max() for body in range(40)])
        order = np.argsort(-largest)[:3]
        assert [one.body for one in found.outliers] == order.tolist()
        assert [abs(one.first - one.estimate) for one in found.outliers] == pytest.approx(
            largest[order])

    def test_fresh_drops_agree_with_the_dataset_s_other_900(self, found):
        """Within 4 standard errors of the difference; the first 100 are biased."""
        dataset = some(40)
        for one in found.outliers:
            place = dataset.pose_starts[one.body] + one.pose
            others = dataset.rest(one.restitution, 100).probability[place]
            for drops, probability in one.again:
                error = math.sqrt(others * (1.0 - others) * (1.0 / 900 + 1.0 / drops))
                assert probability == pytest.approx(others, abs=4.0 * error)
                assert probability * drops == pytest.approx(round(probability * drops))

    def test_every_run_has_drops_of_its_own(self, monkeypatch):
        seeds = []

        def noted(part, drops, restitution, seed, *rest, **options):
            seeds.append(seed)
            return simulate(part, 10, restitution, seed, *rest, **options)

        simulate = dataset_table.simulate
        monkeypatch.setattr(dataset_table, "simulate", noted)
        dataset = some(40)
        found = dataset_table.outliers(dataset, told(40)[1]["combined"], 100)
        own = {dataset.spec.drop_seed(one.body, one.restitution) for one in found}
        assert len(set(seeds) | own) == len(seeds) + len(own) == 9


class TestOddDatasets:
    @pytest.mark.parametrize(("bodies", "drops", "restitutions"), [
        (1, 100, (0.5,)), (1, 300, (0.2, 0.8)), (2, 50, (0.3,)), (19, 99, (0.2, 0.5, 0.8)),
        (25, 2, (0.1, 0.9)), (3, 20_000, (0.8, 0.2)), (22, 10_100, (0.123456789,)),
    ])
    def test_text_and_json_without_nan(self, bodies, drops, restitutions, monkeypatch):
        monkeypatch.setattr(dataset_table, "MORE_DROPS", (5, 7))
        dataset = some(bodies)
        found = table(drawn(dataset, told(bodies)[1]["meae"], drops, 1, restitutions))
        plain = strict_json(json.dumps(found.as_dict()))
        assert list(plain["estimators"][0]["by_restitution"]) == [str(r) for r in restitutions]
        assert plain["first_drops"] == found.first == min(max(100, -(-drops // 100)), drops)
        assert (plain["sensitivity"] is None) == (len(restitutions) == 1)
        assert bool(plain["refits"]) == (bodies >= 20)
        assert bool(plain["calibration_of_first"]) == (drops > found.first)
        assert (plain["combined"] is not None) == (drops > found.first)
        assert len(plain["outliers"]) == min(bodies, 3)
        assert (plain["estimators"][0]["pooled"]["standard_error"] is None) == (bodies == 1)
        text = table_text(found)
        assert "nan" not in text
        assert f"first {found.first} " in text

    def test_a_single_drop_is_refused(self):
        with pytest.raises(RequestError, match="2 settled drops"):
            table(drawn(some(3), told(3)[1]["meae"], 1, 1), rerun=False)


class TestText:
    def test_the_paper_s_figures_stand_beside_ours(self):
        found = compared()
        text = table_text(found)
        assert text.startswith(
            "### Shift 0 (inertia), 1057 bodies, 1000 drops of each, released 20 m above a "
            "frictionless plate, restitution 0.2, 0.5 and 0.8\n")
        row = next(line for line in text.splitlines() if line.startswith("| MEAE "))
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        one = found.row("meae")
        assert cells[1] == "4.0"
        assert cells[2] == (f"{100 * one.pooled.error:.2f} ± "
                            f"{100 * one.pooled.standard_error:.2f}")
        assert cells[-3:] == ["32.7", f"{100 * one.first.largest:.1f}",
                              f"{100 * one.pooled.largest:.1f}"]
        assert "(paper 5.63 between 0.2 and 0.8)" in text
        assert "| hybrid, 100 drops |" in text
        assert " 19995 |" in text

    def test_json_holds_every_estimator_and_no_nan(self):
        plain = strict_json(json.dumps(compared().as_dict()))
        assert [one["name"] for one in plain["estimators"]] == list(ESTIMATORS)
        assert plain["noise_of_100"].keys() == {"0.2", "0.5", "0.8"}
        assert plain["shapes"]["values"] == 3 * len(shipped().body)
