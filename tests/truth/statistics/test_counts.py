# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Tests of counts: chi-square and paired differences, against scipy, by hand, and on
draws.
"""

import math

import numpy as np
import pytest
from scipy import stats

from lab.bodies import shapes
from ros_pose_stats import PoseStatsError, part_from_mesh
from ros_pose_stats.core.plates import count_part
from ros_pose_stats.core.statistics.chi_square import goodness_of_fit, homogeneity
from ros_pose_stats.tools.design.paired_drops import (
    adjust_together,
    chance_of_split,
    paired_difference,
)


@pytest.mark.parametrize(
    "counts",
    [{0: 1.5}, {0: math.nan}, {0: 2**70}, {0: -1}, {0.5: 3}, {True: 4}, {6: 1}],
)
def test_counts_that_are_none(counts):
    with pytest.raises(PoseStatsError, match=r"whole counts from 0 on|poses 0 to 5"):
        count_part(part_from_mesh(*shapes.box(1.0, 2.0, 3.0)), counts)


class TestGoodnessOfFit:
    @pytest.mark.parametrize("seed", range(3))
    def test_as_scipy(self, seed):
        rng = np.random.default_rng(seed)
        counts = rng.multinomial(900, rng.dirichlet(np.full(6, 8.0)))
        expected = rng.dirichlet(np.full(6, 200.0))
        chi_square = goodness_of_fit(counts, expected)
        reference = stats.chisquare(counts, 900 * expected)
        assert chi_square.statistic == pytest.approx(reference.statistic, rel=1e-12)
        assert chi_square.p_value == pytest.approx(reference.pvalue, rel=1e-9)
        assert (chi_square.degrees_of_freedom, chi_square.bins, chi_square.pooled) == (
            5,
            6,
            0,
        )

    def test_rare_bins_are_pooled_by_hand(self):
        # Expected 94, 3, 2, 1: the last three make one bin of 6; likewise one that is
        # expected 0.
        chi_square = goodness_of_fit([90, 4, 4, 2], [0.94, 0.03, 0.02, 0.01])
        assert chi_square.statistic == pytest.approx(16 / 94 + 16 / 6)
        assert (chi_square.degrees_of_freedom, chi_square.bins, chi_square.pooled) == (
            1,
            2,
            3,
        )
        chi_square = goodness_of_fit([58, 40, 2], [0.6, 0.4, 0.0])
        assert chi_square.statistic == pytest.approx(4 / 60 + 4 / 40)

    @pytest.mark.parametrize("counts", [[0, 0], [3, 2], [1000, 3]])
    def test_too_few(self, counts):
        chi_square = goodness_of_fit(
            counts, [1.0, 0.0] if counts[0] == 1000 else [0.5, 0.5]
        )
        assert (
            chi_square.has_too_few_counts
            and math.isnan(chi_square.statistic)
            and math.isnan(chi_square.p_value)
        )

    def test_p_is_uniform_where_the_prediction_holds_and_small_where_it_does_not(self):
        """Of 2000 trials the share below a level has the error sqrt(a (1 - a) / 2000).

        Four of them, and 0.01 for counts being whole numbers. Five points from one pose
        to another: of 1000 parts 91 % of trials have p < 0.05.
        """
        p = np.array([0.4, 0.3, 0.2, 0.07, 0.02, 0.006, 0.004])
        draws = np.random.default_rng(3).multinomial(400, p, size=2000)
        values = np.array([goodness_of_fit(draw, p).p_value for draw in draws])
        for level in (0.01, 0.05, 0.25, 0.5, 0.75, 0.95):
            bound = 4.0 * math.sqrt(level * (1.0 - level) / 2000) + 0.01
            assert np.mean(values < level) == pytest.approx(level, abs=bound)
        draws = np.random.default_rng(4).multinomial(1000, (0.45, 0.35, 0.2), size=500)
        low = [goodness_of_fit(draw, (0.5, 0.3, 0.2)).p_value < 0.05 for draw in draws]
        assert np.mean(low) > 0.86

    @pytest.mark.parametrize("unit", [(0, 1, 2, 3, 4, 5), (0, 1, 1, 2, 2, 2)])
    def test_a_prediction_with_an_error_of_its_own(self, unit):
        """Truths as far from it as it says, poses of a unit alike, and very many drops
        of each.

        A share of 2000 near 1/2 has the standard error 0.011, one of 0.05 0.005; four
        of each are allowed. Taken as exact, the prediction is refused in 99 %.
        """
        rng = np.random.default_rng(3)
        unit = np.array(unit)
        size = np.bincount(unit)
        worth = 150.0
        whole = rng.dirichlet(np.full(size.size, 9.0))
        expected = (whole / size)[unit]
        errors = (np.sqrt(whole * (1.0 - whole) / (worth + 1.0)) / size)[unit]
        true = (rng.dirichlet(worth * whole, 2000) / size)[:, unit]
        counts = rng.multinomial(100_000, true)
        p = np.array(
            [
                goodness_of_fit(sample, expected, errors, unit).p_value
                for sample in counts
            ]
        )
        assert np.mean(p < 0.5) == pytest.approx(0.5, abs=0.045)
        assert np.mean(p < 0.05) == pytest.approx(0.05, abs=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_two_samples_as_scipy_whichever_is_first(seed):
    rng = np.random.default_rng(seed)
    p = rng.dirichlet(np.full(6, 8.0))
    rows = rng.multinomial(500, p), rng.multinomial(9000, rng.dirichlet(300 * p))
    reference = stats.chi2_contingency(rows, correction=False)
    for chi_square in (homogeneity(*rows), homogeneity(*rows[::-1])):
        assert chi_square.statistic == pytest.approx(reference.statistic, rel=1e-10)
        assert chi_square.p_value == pytest.approx(reference.pvalue, rel=1e-7)
        assert chi_square.degrees_of_freedom == reference.dof
    # 100 of 1100: a column of 44 is expected 4 times in the small sample.
    assert homogeneity([56, 38, 6], [560, 402, 38]).pooled == 2


class TestPairs:
    """Outcomes of trials in which both, the first or the second happens so often."""

    @staticmethod
    def pairs(seed, trials, both_hit, first_only, second_only):
        kind = np.random.default_rng(seed).choice(
            4,
            size=trials,
            p=(
                both_hit,
                first_only,
                second_only,
                1.0 - both_hit - first_only - second_only,
            ),
        )
        return (kind == 0) | (kind == 1), (kind == 0) | (kind == 2)

    @pytest.mark.parametrize(("gained", "lost"), [(0, 0), (3, 9), (120, 77)])
    def test_the_chance_is_that_of_a_fair_coin(self, gained, lost):
        expected = (
            stats.binomtest(gained, gained + lost).pvalue if gained + lost else 1.0
        )
        assert chance_of_split(gained, lost) == pytest.approx(expected, rel=1e-12)

    def test_what_both_have_in_common_cancels(self):
        first, second = self.pairs(2, 4000, 0.5, 0.005, 0.005)
        difference = paired_difference(first, second)
        single = second.astype(float) - first.astype(float)
        assert difference.value == pytest.approx(single.mean(), abs=1e-15)
        assert difference.standard_error == pytest.approx(
            single.std() / math.sqrt(4000), rel=1e-12
        )
        assert difference.standard_error < 0.2 * math.sqrt(2.0 * 0.25 / 4000)

    @pytest.mark.parametrize(
        ("trials", "kinds"), [(60, (0.2, 0.1, 0.15)), (400, (0.3, 0.01, 0.02))]
    )
    def test_intervals_hold_nine_in_ten(self, trials, kinds):
        """But for four standard errors; of few discordant pairs they are a little
        wide.
        """
        truth = kinds[2] - kinds[1]
        runs = 1000
        differences = [
            paired_difference(*self.pairs(seed, trials, *kinds)) for seed in range(runs)
        ]
        coverage = np.mean(
            [difference.low <= truth <= difference.high for difference in differences]
        )
        assert 0.9 - 4.0 * math.sqrt(0.09 / runs) <= coverage <= 0.98

    def test_many_tests_together(self):
        """Holm's steps: 4 x 0.005, 3 x 0.01, 2 x 0.03, then no smaller than the one
        before.
        """
        assert adjust_together([0.01, 0.04, 0.03, 0.005]) == pytest.approx(
            [0.03, 0.06, 0.06, 0.02]
        )
        chances = np.random.default_rng(3).uniform(size=(4000, 6))
        wrong = np.mean([adjust_together(row).min() <= 0.05 for row in chances])
        assert wrong <= 0.05 + 4.0 * math.sqrt(0.05 * 0.95 / 4000)
