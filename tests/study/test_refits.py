"""Refitted coefficients: known ones come back, and an optimizer finds the same."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar

from ros_pose_stats.estimators.energy_absorption import COMBINED_WEIGHT
from ros_pose_stats.estimators.quasi_static import NQSE_COEFFICIENTS
from ros_pose_stats.study.errors.simulated_poses import SimulatedPoses, pooled
from ros_pose_stats.study.table.refits import FEWEST_BODIES, refits
from tests.study.tables import compared, drawn, shipped, some, told

BODIES, DROPS = 300, 300
SIGMAS = 4.0
"""Of the told standard errors; for a dozen numbers, once in 1 300 times by chance."""


def simulated_of(dataset):
    """Pooled, and by restitution."""
    single = {one: dataset.simulated(one) for one in dataset.spec.restitutions}
    return pooled(list(single.values())), single


def fitted(dataset, bodies=BODIES):
    return {one.name: one for one in refits(told(bodies)[1], *simulated_of(dataset))}


class TestKnownCoefficients:
    def test_weight_of_the_combination(self):
        estimated = told(BODIES)[1]
        truth = 0.6 * estimated["meae"] + 0.4 * estimated["nqse"]
        found = fitted(drawn(some(BODIES), truth, DROPS, 11))
        for name in ("combined", "combined, 0.2", "combined, 0.5", "combined, 0.8"):
            (weight,), (error,) = found[name].fitted, found[name].standard_error
            assert weight == pytest.approx(0.6, abs=SIGMAS * error), name
            assert error < 0.03
            assert found[name].error < found[name].published_error
        assert found["combined"].published == (COMBINED_WEIGHT,)

    def test_nonlinear_coefficients(self):
        """Binomial counts of each pose by itself, as f leaves the sums of a body open."""
        estimated = told(BODIES)[1]
        x = estimated["qse"]
        mean = x + x * (1.0 - x) * np.polynomial.polynomial.polyval(x, (-0.7, 6.0, -9.0, 2.0))
        body, settled = some(BODIES).body, np.full(len(x), DROPS)
        random = np.random.default_rng(12)
        single = {one: SimulatedPoses(body, random.binomial(DROPS, np.clip(mean, 0.0, 1.0)),
                                      settled) for one in (0.2, 0.5, 0.8)}
        found = next(refits(estimated, pooled(list(single.values())), single))
        assert mean.min() > 0.0
        assert found.name == "NQSE"
        assert found.published == NQSE_COEFFICIENTS
        away = np.subtract(found.fitted, (-0.7, 6.0, -9.0, 2.0))
        assert np.all(np.abs(away) < SIGMAS * np.array(found.standard_error))
        assert np.all(np.array(found.standard_error) < (0.1, 1.0, 4.0, 4.0))


@pytest.fixture(scope="module")
def fits():
    return {one.name: one for one in compared().refits}


@pytest.fixture(scope="module")
def data():
    return simulated_of(shipped())


@pytest.mark.long
class TestAnOptimizer:
    """On the reference dataset without shift."""

    def test_nonlinear_coefficients(self, fits, data):
        x, s = np.tile(compared().estimates[0.2]["qse"], 3), data[0].probability
        bend = (x * (1.0 - x))[:, None] * x[:, None] ** np.arange(4)
        best = minimize(lambda c: 1e4 * np.mean((x + bend @ c - s) ** 2), np.zeros(4),
                        jac=lambda c: 2e4 * bend.T @ (x + bend @ c - s) / len(s),
                        method="BFGS", options={"gtol": 1e-9})
        assert fits["NQSE"].fitted == pytest.approx(best.x, rel=1e-5)

    @pytest.mark.parametrize("restitution", [None, 0.2, 0.5, 0.8])
    def test_weight(self, fits, data, restitution):
        simulated = data[0] if restitution is None else data[1][restitution]
        times = 3 if restitution is None else 1
        one, other = (np.tile(compared().estimates[0.2][name], times) for name in ("meae", "nqse"))
        best = minimize_scalar(lambda c: 1e4 * np.mean(
            (c * one + (1.0 - c) * other - simulated.probability) ** 2), tol=1e-10)
        name = "combined" if restitution is None else f"combined, {restitution:g}"
        assert fits[name].fitted[0] == pytest.approx(best.x, abs=1e-6)


def test_few_bodies_are_fitted_nothing_to():
    assert fitted(some(FEWEST_BODIES - 1), FEWEST_BODIES - 1) == {}
    assert set(fitted(some(FEWEST_BODIES), FEWEST_BODIES)) == {
        "NQSE", "combined", "combined, 0.2", "combined, 0.5", "combined, 0.8"}
