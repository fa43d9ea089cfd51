"""Estimates beside simulations, and predictions beside camera counts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

import ros_pose_stats
from ros_pose_stats import analyse_bags
from tests.recording.analysis.bags import COUNTED, SIMULATED, write_run
from tests.recording.analysis.messages import PROBABILITY, counts, result

OFF = (0.02, -0.02, 0.01, -0.01, 0.0)


def analysed(folder, *messages):
    """The analysis of a run that holds these results and counts."""
    topics = ("pose_counts" if hasattr(one, "unclassified") else "pose_statistics"
              for one in messages)
    write_run(folder, list(zip(topics, messages, strict=True)))
    return analyse_bags(folder)


def simulation(seconds, count=SIMULATED, **fields):
    return result(seconds, method="simulation", count=count, **fields)


class TestEstimateAgainstSimulation:
    @pytest.fixture
    def comparison(self, tmp_path):
        (part,) = analysed(tmp_path, result(1.0), simulation(2.0)).parts
        (history,) = part.simulations
        (found,) = history
        (comparison,) = found.estimates
        return comparison

    def test_differences(self, comparison):
        apart = np.array(SIMULATED) / 2000 - PROBABILITY
        assert comparison.rms == pytest.approx(math.sqrt(np.mean(apart ** 2)))
        assert comparison.largest == pytest.approx(np.abs(apart).max())
        assert comparison.largest_pose == 1

    def test_chi_square_by_pose_and_by_group(self, comparison):
        known = stats.chisquare(SIMULATED, 2000 * np.array(PROBABILITY))
        assert comparison.by_pose.statistic == pytest.approx(known.statistic)
        assert comparison.by_pose.p_value == pytest.approx(known.pvalue)
        # Poses 0 and 2 are one group.
        known = stats.chisquare((1370, 470, 120, 40), 2000 * np.array((0.67, 0.25, 0.06, 0.02)))
        assert comparison.by_group.statistic == pytest.approx(known.statistic)
        assert comparison.by_group.degrees_of_freedom == 3

    @pytest.mark.parametrize("method", ["split", "hybrid"])
    def test_a_prediction_has_the_scatter_that_it_tells(self, tmp_path, method):
        """Off by two points, as it says itself: 100 000 drops do not refute it."""
        off = np.add(PROBABILITY, OFF)
        many = np.round(1e5 * np.array(PROBABILITY)).astype(int)
        (part,) = analysed(tmp_path, result(1.0, off, method=method, group=range(5), error=0.015),
                           simulation(2.0, many, group=range(5))).parts
        (found,) = part.simulations[0][0].estimates
        assert 0.1 < found.by_pose.p_value < 0.99 and 0.1 < found.by_group.p_value < 0.99

    @pytest.mark.parametrize(("expected", "held"), [(0.015, True), (1e-4, False)])
    def test_where_poses_have_no_error_that_of_all_of_them_counts(self, tmp_path, expected, held):
        off = np.add(PROBABILITY, OFF)
        (part,) = analysed(
            tmp_path,
            result(1.0, off, group=range(5), error=math.nan, expected_error=expected),
            simulation(2.0, np.round(1e5 * np.array(PROBABILITY)).astype(int),
                       group=range(5))).parts
        (found,) = part.simulations[0][0].estimates
        assert (found.by_pose.p_value > 0.01) == held

    def test_each_scene_by_its_largest_run(self, tmp_path):
        (part,) = analysed(
            tmp_path, simulation(1.0), result(2.0), simulation(3.0, (100, 50, 25, 12, 4)),
            simulation(4.0, (90, 60, 25, 12, 4), restitution=0.2), result(5.0, method="meae"),
            result(6.0, (0.5, 0.3, 0.12, 0.06, 0.02))).parts
        found = part.simulations[0]
        assert [one.simulation.drops for one in found] == [2000, 191]
        assert [[each.prediction.method for each in one.estimates] for one in found] == [
            ["combined", "meae"]] * 2
        # Of an estimate the newest stands.
        assert found[0].estimates[0].prediction.probability[0] == 0.5

    def test_no_simulation_no_comparison(self, tmp_path):
        (part,) = analysed(tmp_path, result(1.0)).parts
        assert part.simulations == ((),)


class TestCameraCounts:
    def test_against_estimate_and_simulation(self, tmp_path):
        (part,) = analysed(tmp_path, result(1.0), simulation(2.0), counts(3.0, COUNTED)).parts
        (found,) = part.counts
        assert found.problem == ""
        estimate, counted = found.predictions
        assert estimate.by_pose.pooled == 0
        known = stats.chisquare(COUNTED, 400 * np.array(PROBABILITY))
        assert estimate.by_pose.statistic == pytest.approx(known.statistic)
        # A simulation has an error of its own.
        known = stats.chi2_contingency([COUNTED, SIMULATED], correction=False)
        assert counted.by_pose.statistic == pytest.approx(known.statistic)
        assert counted.by_pose.p_value == pytest.approx(known.pvalue)
        assert found.share == pytest.approx(np.array(COUNTED) / 400)

    def test_counts_do_not_judge_what_has_learnt_from_them(self, tmp_path):
        learnt = result(4.0, np.array(COUNTED) / 400, method="observed", observed=400)
        (part,) = analysed(tmp_path, result(1.0), simulation(2.0), counts(3.0, COUNTED),
                           learnt).parts
        (found,) = part.counts
        assert [one.prediction.method for one in found.predictions] == ["combined", "simulation"]
        ((of_drops,),) = part.simulations
        assert [one.prediction.method for one in of_drops.estimates] == ["combined"]
        assert found.history.leading.method == "simulation"

    def test_a_prediction_that_holds_gives_uniform_p(self, tmp_path):
        # 200 parts' worth of counts: the share below 1/2 has the binomial error 3.5 %.
        draws = np.random.default_rng(7).multinomial(500, PROBABILITY, size=200)
        found = analysed(tmp_path, result(1.0), *(
            counts(2.0 + k, draw, plate=f"plate {k}") for k, draw in enumerate(draws)))
        values = np.array([one.predictions[0].by_pose.p_value for one in found.parts[0].counts])
        assert len(values) == 200
        assert np.mean(values < 0.5) == pytest.approx(0.5, abs=4 * 0.035)
        assert np.mean(values < 0.05) <= 0.05 + 4 * math.sqrt(0.05 * 0.95 / 200)

    def test_a_prediction_that_does_not_hold_is_found(self, tmp_path):
        wrong = counts(2.0, np.random.default_rng(8).multinomial(1000, (0.45, 0.35, 0.12, 0.06,
                                                                        0.02)))
        (part,) = analysed(tmp_path, result(1.0), wrong).parts
        (against,) = part.counts[0].predictions
        # Expected statistic 4 + 1000 (0.1² / 0.55 + 0.1² / 0.25) = 62.
        assert against.by_pose.p_value < 1e-4
        assert against.largest_pose in (0, 1)

    def test_a_pose_that_cannot_be(self, tmp_path):
        probability = (0.6, 0.25, 0.15, 0.0, 0.0)
        (part,) = analysed(tmp_path, result(1.0, probability),
                           counts(2.0, (60, 25, 12, 3, 0))).parts
        (against,) = part.counts[0].predictions
        assert against.unforeseen == 3
        # 60, 25 and, together, 15: nothing is divided by 0.
        assert against.by_pose.statistic == pytest.approx(0.0)
        assert (against.by_pose.bins, against.by_pose.pooled) == (3, 2)

    def test_too_few(self, tmp_path):
        (part,) = analysed(tmp_path, result(1.0), counts(2.0, (3, 1, 0, 0, 0))).parts
        assert part.counts[0].predictions[0].by_pose.too_few

    def test_a_camera_that_cannot_tell_a_group_apart(self, tmp_path):
        # All of group 0 as pose 0: wrong by pose, right by group.
        (part,) = analysed(tmp_path, result(1.0), counts(2.0, (670, 250, 0, 60, 20))).parts
        (against,) = part.counts[0].predictions
        assert against.by_pose.p_value < 1e-6
        assert against.by_group.p_value > 0.9
        assert any("by group alone" in remark for remark in part.counts[0].remarks)

    def test_plates_are_kept_apart(self, tmp_path):
        (part,) = analysed(tmp_path, result(1.0, plate="steel"), counts(2.0, COUNTED),
                           counts(3.0, COUNTED, plate="rubber")).parts
        steel, rubber = part.counts
        assert [one.counts.plate for one in (steel, rubber)] == ["steel", "rubber"]
        assert not any("plate" in one for one in steel.remarks)
        assert any("rubber" in one for one in rubber.remarks)

    def test_another_drop_height_is_remarked(self, tmp_path):
        (part,) = analysed(tmp_path, simulation(1.0), counts(2.0, COUNTED, drop_height=0.2),
                           counts(3.0, COUNTED, drop_height=-1.0)).parts
        told = [any("200 mm" in each for each in one.remarks) for one in part.counts]
        assert told == [True, False]

    def test_the_numbering_chooses_among_results(self, tmp_path):
        (part,) = analysed(
            tmp_path, result(1.0), result(2.0, round_sides=0), counts(3.0, COUNTED, round_sides=0),
            counts(4.0, (1, 2, 3, 4, 5)), counts(5.0, COUNTED, cluster_tolerance=0.1 * 0.05)).parts
        found = {one.counts.numbering: one for one in part.counts}
        assert found.keys() == {(0.005, 0), (0.005, 192)}
        for numbering, one in found.items():
            assert (one.problem, one.history.numbering) == ("", numbering)
        assert found[0.005, 192].count.tolist() == [231, 100, 55, 20, 9]
        assert found[0.005, 0].count.tolist() == list(COUNTED)

    def test_without_a_digest_the_name_decides(self, tmp_path):
        (part,) = analysed(tmp_path, result(1.0), counts(2.0, COUNTED, part_digest="")).parts
        assert part.counts[0].problem == ""


class TestNotCompared:
    def test_another_tolerance(self, tmp_path):
        (part,) = analysed(tmp_path, result(1.0),
                           counts(2.0, COUNTED, cluster_tolerance=0.01)).parts
        (found,) = part.counts
        assert "0.01" in found.problem and "0.005" in found.problem
        assert found.predictions == ()

    def test_other_round_sides(self, tmp_path):
        (part,) = analysed(tmp_path, result(1.0), result(2.0, cluster_tolerance=0.0),
                           counts(3.0, COUNTED, round_sides=0)).parts
        (found,) = part.counts
        assert found.problem == (
            "counted at cluster_tolerance 0.005 and round_sides 0, results are at "
            "cluster_tolerance 0.005 and round_sides 192; cluster_tolerance 0 and round_sides "
            "192: the same index is not the same pose")
        assert found.history is None and found.predictions == ()

    def test_a_tolerance_that_neither_knows(self, tmp_path):
        unknown = {"cluster_tolerance": math.nan}
        (part,) = analysed(tmp_path, result(1.0, **unknown), result(2.0, **unknown),
                           counts(3.0, COUNTED, **unknown)).parts
        (history,) = part.record.histories
        assert len(history.time) == 2
        assert "cluster_tolerance unknown" in part.counts[0].problem

    def test_a_pose_that_the_part_does_not_have(self, tmp_path):
        (part,) = analysed(tmp_path, result(1.0), counts(2.0, (5, 6), index=(0, 17))).parts
        assert "pose 17" in part.counts[0].problem

    def test_another_digest(self, tmp_path):
        found = analysed(tmp_path, result(1.0), counts(2.0, COUNTED, part_digest="c" * 64))
        assert found.parts[0].counts == ()
        (stray,) = found.strays
        assert "no result" in stray.problem

    def test_a_name_that_two_parts_have(self, tmp_path):
        found = analysed(tmp_path, result(1.0), result(1.5, part_digest="c" * 64),
                         counts(2.0, COUNTED, part_digest=""))
        (stray,) = found.strays
        assert "2 parts are called clamp" in stray.problem

    def test_unequal_arrays(self, tmp_path):
        broken = counts(2.0, (5, 6))
        broken.index.append(3)
        found = analysed(tmp_path, result(1.0), broken)
        assert found.contents.counts == ()
        assert "1 camera count left out" in found.contents.notes[0]


def test_the_library_on_a_real_part(tmp_path):
    """A bag of this package's own estimate and simulation gives them back."""
    from ros_pose_stats import shapes

    part = ros_pose_stats.part_from_mesh(*shapes.box(0.02, 0.03, 0.04), part_id="box")
    estimated = ros_pose_stats.estimate(part)
    dropped = ros_pose_stats.simulate(part, drops=300, seed=1, workers=1)
    messages = []
    for seconds, one in enumerate((estimated, dropped)):
        by_index = sorted(one.poses, key=lambda pose: pose.index)
        messages.append(result(
            float(seconds), [pose.probability for pose in by_index], one.method,
            count=[pose.count for pose in by_index] if one.drops else None,
            group=[pose.group for pose in by_index], part_id="box", part_digest=part.digest))
    found = analysed(tmp_path, *messages).parts[0]
    (history,) = found.record.histories
    for told, known in zip(history.predictions, (estimated, dropped), strict=True):
        by_index = sorted(known.poses, key=lambda pose: pose.index)
        assert told.probability == pytest.approx([pose.probability for pose in by_index])
    assert history.leading.expected_error == pytest.approx(dropped.expected_error)
