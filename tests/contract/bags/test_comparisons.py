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

"""Estimates beside simulations, and predictions beside what cameras counted, by
chi-square.
"""

import math

import numpy as np
import pytest
from scipy import stats

from ros_pose_stats import analyse_bags

from .messages import (
    COUNTED,
    PROBABILITY,
    SIMULATED,
    counts,
    numbering_of,
    result,
)
from .recorders import write_run

OFF = np.add(PROBABILITY, (0.02, -0.02, 0.01, -0.01, 0.0))
MANY = np.round(1e5 * np.array(PROBABILITY)).astype(int)
APART = range(5)
"""Every pose in a group of its own."""


@pytest.fixture
def analysed(tmp_path):
    """The analysis of a run that holds these results and counts."""

    def analyse(*messages):
        topics = (
            "pose_counts" if hasattr(message, "unclassified") else "pose_statistics"
            for message in messages
        )
        write_run(tmp_path, list(zip(topics, messages, strict=True)))
        return analyse_bags(tmp_path)

    return analyse


def simulation(seconds, count=SIMULATED, **fields):
    return result(seconds, method="simulation", count=count, **fields)


class TestEstimateAgainstSimulation:
    def test_differences_and_chi_square_by_pose_and_by_group(self, analysed):
        (part,) = analysed(result(1.0), simulation(2.0)).parts
        ((compared,),) = part.simulations
        (against,) = compared.estimates
        difference = np.array(SIMULATED) / 2000 - PROBABILITY
        assert against.rms == pytest.approx(math.sqrt(np.mean(difference**2)))
        assert (against.largest, against.largest_pose) == (
            pytest.approx(np.abs(difference).max()),
            1,
        )
        reference = stats.chisquare(SIMULATED, 2000 * np.array(PROBABILITY))
        assert against.by_pose.statistic == pytest.approx(reference.statistic)
        assert against.by_pose.p_value == pytest.approx(reference.pvalue)
        # Poses 0 and 2 are one group.
        reference = stats.chisquare(
            (1370, 470, 120, 40), 2000 * np.array((0.67, 0.25, 0.06, 0.02))
        )
        assert against.by_group.statistic == pytest.approx(reference.statistic)
        assert against.by_group.degrees_of_freedom == 3

    @pytest.mark.parametrize(
        ("errors", "is_kept"),
        [
            ({"error": 0.015}, True),
            ({"error": math.nan, "expected_error": 0.015}, True),
            ({"error": math.nan, "expected_error": 1e-4}, False),
        ],
    )
    def test_a_prediction_has_the_error_that_it_says(self, analysed, errors, is_kept):
        """Off by two points, as it says itself: 100 000 drops do not refute it."""
        (part,) = analysed(
            result(1.0, OFF, method="split", group=APART, **errors),
            simulation(2.0, MANY, group=APART),
        ).parts
        (against,) = part.simulations[0][0].estimates
        for test in (against.by_pose, against.by_group):
            assert (0.01 < test.p_value < 0.99) == is_kept

    def test_each_scene_has_its_largest_run_and_the_newest_estimates(self, analysed):
        (part,) = analysed(
            simulation(1.0),
            result(2.0),
            simulation(3.0, (100, 50, 25, 12, 4)),
            simulation(4.0, (90, 60, 25, 12, 4), restitution=0.2),
            result(5.0, method="meae"),
            result(5.5, method="split", drop_height=0.4),
            result(6.0, (0.5, 0.3, 0.12, 0.06, 0.02)),
        ).parts
        scenes = part.simulations[0]
        assert [scene.simulation.drops for scene in scenes] == [2000, 191]
        assert [
            [prediction.prediction.method for prediction in scene.estimates]
            for scene in scenes
        ] == [["combined", "meae", "split"], ["combined", "meae"]]
        assert scenes[0].estimates[0].prediction.probability[0] == 0.5


class TestCameraCounts:
    def test_against_estimate_and_simulation(self, analysed):
        (part,) = analysed(result(1.0), simulation(2.0), counts(3.0, COUNTED)).parts
        (compared,) = part.counts
        assert compared.problem == "" and compared.share == pytest.approx(
            np.array(COUNTED) / 400
        )
        estimated, dropped = compared.predictions
        reference = stats.chisquare(COUNTED, 400 * np.array(PROBABILITY))
        assert estimated.by_pose.statistic == pytest.approx(reference.statistic)
        # A simulation has an error of its own: a table of two rows.
        reference = stats.chi2_contingency([COUNTED, SIMULATED], correction=False)
        assert dropped.by_pose.statistic == pytest.approx(reference.statistic)
        assert dropped.by_pose.p_value == pytest.approx(reference.pvalue)

    def test_counts_do_not_judge_what_has_learnt_from_them(self, analysed):
        learnt = result(
            4.0, np.array(COUNTED) / 400, method="observed", counted_parts=400
        )
        (part,) = analysed(
            result(1.0), simulation(2.0), counts(3.0, COUNTED), learnt
        ).parts
        (compared,) = part.counts
        assert [
            prediction.prediction.method for prediction in compared.predictions
        ] == [
            "combined",
            "simulation",
        ]
        assert compared.history.leading.method == "simulation"

    def test_a_prediction_that_holds_gives_uniform_p(self, analysed):
        # 200 plates: the share below 1/2 has the binomial error 3.5 %; four of it.
        draws = np.random.default_rng(7).multinomial(500, PROBABILITY, size=200)
        (part,) = analysed(
            result(1.0),
            *(
                counts(2.0 + k, draw, plate=f"plate {k}")
                for k, draw in enumerate(draws)
            ),
        ).parts
        values = np.array(
            [comparison.predictions[0].by_pose.p_value for comparison in part.counts]
        )
        assert len(values) == 200
        assert np.mean(values < 0.5) == pytest.approx(0.5, abs=4 * 0.035)
        assert np.mean(values < 0.05) <= 0.05 + 4 * math.sqrt(0.05 * 0.95 / 200)

    def test_a_prediction_that_does_not_hold_is_refuted(self, analysed):
        # Expected statistic 4 + 1000 (0.1² / 0.55 + 0.1² / 0.25) = 62.
        draw = np.random.default_rng(8).multinomial(
            1000, (0.45, 0.35, 0.12, 0.06, 0.02)
        )
        (part,) = analysed(result(1.0), counts(2.0, draw)).parts
        (against,) = part.counts[0].predictions
        assert against.by_pose.p_value < 1e-4 and against.largest_pose in (0, 1)

    def test_a_pose_that_cannot_be_is_pooled_and_said(self, analysed):
        (part,) = analysed(
            result(1.0, (0.6, 0.25, 0.15, 0.0, 0.0)), counts(2.0, (60, 25, 12, 3, 0))
        ).parts
        (against,) = part.counts[0].predictions
        assert against.unforeseen == 3
        # 60, 25 and, together, 15: nothing is divided by 0.
        assert against.by_pose.statistic == pytest.approx(0.0)
        assert (against.by_pose.bins, against.by_pose.pooled) == (3, 2)

    def test_a_camera_that_cannot_tell_a_group_apart_is_judged_by_group(self, analysed):
        """All of group 0 as pose 0: wrong by pose, right by group."""
        (part,) = analysed(result(1.0), counts(2.0, (670, 250, 0, 60, 20))).parts
        (against,) = part.counts[0].predictions
        assert against.by_pose.p_value < 1e-6 and against.by_group.p_value > 0.9
        assert any("by group alone" in remark for remark in part.counts[0].remarks)

    def test_plates_and_drop_heights_are_kept_apart_and_remarked(self, analysed):
        (part,) = analysed(
            simulation(1.0, plate="steel"),
            counts(2.0, COUNTED, drop_height=-1.0),
            counts(3.0, COUNTED, plate="rubber"),
            counts(4.0, COUNTED, drop_height=0.2),
        ).parts
        remarks = {
            (comparison.counts.plate, comparison.counts.drop_height): " ".join(
                comparison.remarks
            )
            for comparison in part.counts
        }
        assert len(remarks) == 3
        assert "rubber" in remarks["rubber", 0.4] and "200 mm" in remarks["steel", 0.2]
        (compared,) = (
            text
            for (plate, height), text in remarks.items()
            if plate == "steel" and height != 0.2
        )
        assert "plate" not in compared and "mm" not in compared

    def test_the_numbering_chooses_among_results(self, analysed):
        (part,) = analysed(
            result(1.0),
            result(2.0, round_sides=0),
            counts(3.0, COUNTED, numbering=numbering_of(sides=0)),
            counts(4.0, (1, 2, 3, 4, 5)),
            counts(5.0, COUNTED),
        ).parts
        by_numbering = {
            comparison.counts.numbering: comparison for comparison in part.counts
        }
        assert by_numbering.keys() == {(0.005, 0), (0.005, 192)}
        for numbering, comparison in by_numbering.items():
            assert (comparison.problem, comparison.history.numbering) == ("", numbering)
        assert by_numbering[0.005, 192].count.tolist() == [231, 100, 55, 20, 9]

    def test_without_a_numbering_the_result_of_that_time_decides(self, analysed):
        """Of two that a parameter has changed in between."""
        (part,) = analysed(
            result(1.0),
            counts(2.0, (7, 0, 0, 0, 0), numbering=0),
            result(3.0, round_sides=0),
            counts(4.0, (5, 0, 0, 0, 0), numbering=0),
            counts(5.0, (1, 0, 0, 0, 0)),
        ).parts
        assert {
            comparison.counts.numbering: (comparison.problem, int(comparison.count[0]))
            for comparison in part.counts
        } == {(0.005, 192): ("", 8), (0.005, 0): ("", 5)}

    @pytest.mark.parametrize("number", [0, numbering_of()])
    def test_counts_before_their_result_are_of_it(self, analysed, number):
        (part,) = analysed(
            counts(1.0, COUNTED, numbering=number), counts(2.0, COUNTED), result(3.0)
        ).parts
        (compared,) = part.counts
        assert compared.problem == ""
        assert compared.count.tolist() == [2 * count for count in COUNTED]


class TestNotCompared:
    @pytest.mark.parametrize(
        ("fields", "words"),
        [
            ({"numbering": 7}, ("under numbering 7", "no result of the part")),
            ({"index": (0, 17)}, ("pose 17",)),
        ],
    )
    def test_counts_of_other_poses(self, analysed, fields, words):
        (part,) = analysed(result(1.0), counts(2.0, (5, 6), **fields)).parts
        (compared,) = part.counts
        assert compared.predictions == ()
        assert all(word in compared.problem for word in words)

    @pytest.mark.parametrize(
        ("fields", "words"),
        [({"part_id": "bolt"}, "no result"), ({}, "2 parts are called clamp")],
    )
    def test_counts_of_no_part_or_of_either_are_strays(self, analysed, fields, words):
        others = [result(1.5, part_digest="b" * 64)] if not fields else []
        analysis = analysed(
            result(1.0), *others, counts(2.0, COUNTED, **{"numbering": 7, **fields})
        )
        assert all(part.counts == () for part in analysis.parts)
        (stray,) = analysis.strays
        assert words in stray.problem
