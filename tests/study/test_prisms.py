"""The benchmark of square prisms: closed forms, published dice, and how a run behaves."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys

import numpy as np
import pytest

from ros_pose_stats.errors import RequestError
from ros_pose_stats.estimators import ESTIMATORS
from ros_pose_stats.study.prisms import DICE, prism_runs, prisms, prisms_text
from ros_pose_stats.study.prisms.dice import (
    MEASURED,
    ROLLS,
    root_mean_square,
    sampling_noise,
    standard_error,
)
from ros_pose_stats.study.prisms.prism_results import draw_prisms
from ros_pose_stats.study.prisms.prism_runs import counted, dropped_sides, estimated_sides
from tests.bodies import METHODS

KNOWN_RMS = {"csae": 0.147, "qse": 0.147, "adre": 0.081, "nqse": 0.099, "eae": 0.043,
             "meae": 0.105, "combined": 0.103}
"""Of another implementation, to three digits."""
KNOWN_SIMULATED_RMS = {0.2: 0.072, 0.5: 0.051, 0.8: 0.037}
"""Of another implementation, 2 000 drops a die."""


@pytest.fixture(scope="module")
def results():
    """Few drops for the curves, as many as the known figures had for the dice."""
    return prisms(200, 2000, seed=3)


def few(seed=5, **options):
    """A quick run: few drops, and five ratios on the curves."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prism_runs, "CURVE_RATIOS", 5)
        return prisms(20, 10, seed, **options)


@pytest.fixture(scope="module")
def small():
    return few(workers=2)


def without_time(found):
    return {key: value for key, value in found.as_dict().items() if key != "seconds"}


class TestDice:
    def test_rising_ratios_within_the_figure(self):
        ratios = [die.ratio for die in DICE]
        assert len(ratios) == 15
        assert ratios == sorted(ratios)
        assert 0.3 < ratios[0] < ratios[-1] < 3.0

    @pytest.mark.parametrize("die", DICE)
    def test_published_frequencies_are_those_of_whole_rolls(self, die):
        assert round(1.0 - die.rolls_on_sides / die.rolls, 3) == die.on_squares


class TestEstimators:
    def test_every_estimator_is_there(self, results):
        assert tuple(results.estimated) == tuple(results.dice_estimated) == tuple(ESTIMATORS)
        assert set(METHODS) <= set(results.estimated)

    def test_a_cube_has_two_thirds_on_its_sides(self):
        for name, (sides,) in estimated_sides([1.0]).items():
            assert sides == pytest.approx(2.0 / 3.0, abs=1e-9), name

    def test_centroid_solid_angle_in_closed_form(self, results):
        """A rectangle of half sides a and b, seen from d above its middle."""
        half, above = 0.5, results.ratios / 2.0
        square = 4.0 * np.arctan(half * half
                                 / (above * np.sqrt(above ** 2 + 2.0 * half ** 2)))
        expected = 1.0 - 2.0 * square / (4.0 * np.pi)
        assert results.estimated["csae"] == pytest.approx(expected, abs=1e-12)

    def test_area_in_closed_form(self, results):
        expected = 4.0 * results.ratios / (4.0 * results.ratios + 2.0)
        assert results.estimated["area"] == pytest.approx(expected, abs=1e-12)

    @pytest.mark.parametrize("name", METHODS)
    def test_a_longer_prism_is_more_often_on_its_sides(self, results, name):
        """Everywhere but where PQSE takes all that a face has: it is 0 or 1 there."""
        curve = results.estimated[name]
        assert curve.shape == results.ratios.shape
        assert ((curve >= 0.0) & (curve <= 1.0 + 1e-12)).all()
        saturated = (curve < 1e-12) | (curve > 1.0 - 1e-12)
        assert name == "pqse" or not saturated.any()
        rise = np.diff(curve)
        assert (rise >= -1e-12).all()
        assert (rise[~(saturated[1:] & saturated[:-1])] > 1e-4).all()

    def test_quasi_static_equals_the_solid_angle_since_every_face_is_stable(self, results):
        assert results.estimated["qse"] == pytest.approx(results.estimated["csae"], abs=1e-12)


class TestMisfits:
    @pytest.mark.parametrize("name", KNOWN_RMS)
    def test_estimators_are_as_far_from_the_dice_as_is_known(self, results, name):
        (found,) = (each for each in results.misfits if each.method == name)
        assert found.rms == pytest.approx(KNOWN_RMS[name], abs=0.0015)

    @pytest.mark.parametrize("restitution", KNOWN_SIMULATED_RMS)
    def test_simulation_is_as_far_from_the_dice_as_is_known(self, results, restitution):
        """Within four standard deviations of the difference of two runs, and the rounding.

        The dice are the same for both, so only the drops differ: an error e of a die with
        variance v moves the root mean square of n dice by e / (n rms) of its own, 2 000
        drops here and 2 000 there. The sampling error of the dice themselves adds nothing.
        """
        points = results.dice_simulated[restitution]
        share = np.array([point.probability for point in points])
        variance = share * (1.0 - share) / 2000.0
        error = share - MEASURED
        (found,) = (each for each in results.misfits if each.restitution == restitution)
        spread = math.sqrt(2.0 * (error ** 2 * variance).sum()) / (len(DICE) * found.rms)
        assert found.rms == pytest.approx(root_mean_square(share), abs=1e-15)
        assert spread < 0.004
        assert found.rms == pytest.approx(KNOWN_SIMULATED_RMS[restitution],
                                          abs=4.0 * spread + 0.0005)

    def test_sampling_noise_of_the_table(self, results):
        assert results.sampling_noise == sampling_noise() == pytest.approx(0.014, abs=0.001)

    def test_best_first_and_complete(self, results):
        rms = [round(found.rms, 12) for found in results.misfits]
        assert rms == sorted(rms)
        assert len(rms) == len(ESTIMATORS) + 3

    def test_standard_error_by_error_propagation(self):
        """The bootstrap and the first order agree where the errors dwarf the noise."""
        predicted = np.clip(MEASURED + 0.3 * np.where(MEASURED > 0.5, -1.0, 1.0), 0.0, 1.0)
        error = predicted - MEASURED
        of_dice = MEASURED * (1.0 - MEASURED) / ROLLS
        of_drops = predicted * (1.0 - predicted) / 500
        for trials, variance in ((None, of_dice), (np.full(15, 500), of_dice + of_drops)):
            expected = math.sqrt((error ** 2 * variance).sum()) / (
                15 * root_mean_square(predicted))
            assert standard_error(predicted, trials, seed=1) == pytest.approx(expected, rel=0.06)

    def test_standard_error_is_repeatable(self):
        assert standard_error(MEASURED, seed=4) == standard_error(MEASURED, seed=4)
        assert standard_error(MEASURED, seed=4) != standard_error(MEASURED, seed=5)


class TestSimulation:
    @pytest.mark.parametrize("restitution", [0.2, 0.5, 0.8])
    def test_a_cube_has_two_thirds_on_its_sides(self, restitution):
        point = dropped_sides(1.0, restitution, 1500, 2)
        sigma = math.sqrt(2.0 / 9.0 / 1500)
        assert point.probability == pytest.approx(2.0 / 3.0, abs=4.0 * sigma)

    def test_points_cover_the_figure(self, results):
        for restitution, points in results.simulated.items():
            ratios = [point.ratio for point in points]
            assert ratios == pytest.approx(np.geomspace(0.3, 3.0, 15)), restitution
            assert {point.trials for point in points} == {200}
        assert list(results.simulated) == list(results.dice_simulated) == [0.2, 0.5, 0.8]

    def test_intervals_bracket(self, results):
        every = [*results.dice, *sum(results.simulated.values(), ()),
                 *sum(results.dice_simulated.values(), ())]
        assert len(every) == 15 * 7
        for point in every:
            assert 0.0 <= point.low <= point.probability <= point.high <= 1.0
            assert point.high - point.low > 0.0

    def test_the_interval_is_jeffreys_at_95_percent(self):
        """8 of 10: the quantiles of Beta(8.5, 2.5), found here by integrating its density."""
        point = counted(1.0, 8, 10)
        grid = np.linspace(0.0, 1.0, 400_001)
        density = grid ** 7.5 * (1.0 - grid) ** 1.5
        share = np.cumsum(density) / density.sum()
        low, high = np.interp((0.025, 0.975), share, grid)
        assert (point.low, point.high) == pytest.approx((low, high), abs=1e-5)


class TestARun:
    @pytest.mark.long
    def test_the_same_seed_gives_the_same_results_and_progress_rises_to_its_total(self, small):
        told = []
        again = few(workers=1, on_progress=lambda done, total: told.append((done, total)))
        assert without_time(again) == without_time(small)
        assert [done for done, _ in told] == sorted({done for done, _ in told})
        assert {total for _, total in told} == {45 * 20 + 45 * 10}
        assert told[-1][0] == told[-1][1]

    def test_another_seed_gives_others(self, small):
        other = few(seed=6, should_stop=lambda: False)
        assert other.simulated.keys() == small.simulated.keys()
        assert other.simulated != small.simulated
        assert other.dice == small.dice

    def test_every_simulation_has_drops_of_its_own(self):
        """Equal starting directions would tie the errors of neighbouring points."""
        seeds = [one.seed for stream in (prism_runs.OF_CURVE, prism_runs.OF_DICE)
                 for one in prism_runs._plan([0.5, 1.0, 2.0], 10, 1, stream)]
        assert len(set(seeds)) == len(seeds) == 18

    def test_json_round_trip_without_nan(self, results):
        text = json.dumps(results.as_dict(), allow_nan=False)
        again = json.loads(text)
        assert again == results.as_dict()
        assert [entry["restitution"] for entry in again["simulated"]] == [0.2, 0.5, 0.8]
        assert again["level"] == 0.95
        assert again["release_radii"] == 20.0
        assert again["stopped"] is False
        assert 0.0 < again["seconds"] < 600.0

    def test_frozen(self, results):
        with pytest.raises(dataclasses.FrozenInstanceError):
            results.seed = 2

    def test_stopped_at_once_it_still_has_the_estimators(self):
        found = few(should_stop=lambda: True)
        assert found.stopped
        assert not any(found.simulated.values())
        assert {each.method for each in found.misfits} == set(ESTIMATORS)
        json.dumps(found.as_dict(), allow_nan=False)
        assert "stopped before its end" in prisms_text(found)
        assert draw_prisms(found).axes

    def test_stopped_halfway_it_keeps_what_was_finished(self, small):
        told = []
        found = few(on_progress=lambda done, _: told.append(done),
                    should_stop=lambda: len(told) >= 50)
        assert found.stopped
        assert found.simulated == small.simulated
        kept = [len(points) for points in found.dice_simulated.values()]
        assert kept == [5, 0, 0]
        assert found.dice_simulated[0.2] == small.dice_simulated[0.2][:5]
        (row,) = (line for line in prisms_text(found).splitlines() if line.split()[:1] == ["2.65"])
        assert row.split().count("-") == 1 + 3  # of the interval, and of what is missing

    def test_a_simulation_cut_short_is_left_out(self):
        asked = iter((False,))
        point = dropped_sides(1.0, 0.5, 10_000_000, 1, should_stop=lambda: next(asked, True))
        assert point is None

    @pytest.mark.parametrize("options", [{"drops": 0}, {"dice_drops": 0}, {"seed": -1},
                                         {"drops": 1.5}, {"workers": 0}])
    def test_what_cannot_be_is_refused_before_anything_runs(self, options):
        with pytest.raises(RequestError):
            prisms(**options, on_progress=lambda *_: pytest.fail("it ran"))


class TestText:
    def test_methods_stand_in_the_order_of_their_distance(self, results):
        lines = prisms_text(results).splitlines()
        places = [next(number for number, line in enumerate(lines)
                       if line.startswith(f"{found.title} "))
                  for found in results.misfits]
        assert places == sorted(places)
        assert max(map(len, lines)) <= 100

    def test_numbers_are_those_of_the_results(self, results):
        text = prisms_text(results)
        best = results.misfits[0]
        assert f"{100.0 * best.rms:.2f}" in text
        assert f"{100.0 * best.standard_error:.2f}" in text
        assert f"sampling noise of the dice         {100.0 * results.sampling_noise:.2f}" in text
        row = next(line for line in text.splitlines() if line.split()[:2] == ["2.65", "503"])
        values = [float(cell) for cell in row.replace(" - ", " ").split()]
        shown = [results.dice[-1].probability, results.dice[-1].low, results.dice[-1].high,
                 *(points[-1].probability for points in results.dice_simulated.values()),
                 results.dice_estimated["combined"][-1], results.dice_estimated["eae"][-1]]
        assert values[2:] == pytest.approx([100.0 * each for each in shown], abs=0.0051)


class TestFigure:
    def test_every_estimator_and_every_point_is_drawn(self, results):
        panels = draw_prisms(results).axes
        names = {line.get_label() for axes in panels for line in axes.lines}
        assert {"PQSE", "CSAE = QSE", "area", "ADRE", "NQSE", "EAE",
                "MEAE", "combined"} <= names
        assert [len(axes.containers) for axes in panels] == [4, 4]

    def test_a_run_without_a_figure_does_not_load_matplotlib(self):
        code = ("import sys\n"
                "from ros_pose_stats.study.prisms import prisms, prisms_text\n"
                "sys.exit('matplotlib' in sys.modules)")
        assert subprocess.run([sys.executable, "-c", code]).returncode == 0
