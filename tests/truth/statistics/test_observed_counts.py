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

"""What cameras counted, beside the model: what is learnt, and what is told."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from lab.bodies import shapes
from ros_pose_stats import estimate, part_from_mesh
from ros_pose_stats.core.planning.confidence import (
    learn_plate_error,
    observe_counts,
    plate_evidence,
)
from ros_pose_stats.core.statistics.chi_square import (
    distance_chance,
    goodness_of_fit,
)
from ros_pose_stats.core.statistics.model_gap import describe_use


def test_poses_of_a_group_share_counts_unless_these_are_unequal():
    """Of both sides of a plate 130 and 70 are no chance (p = 2e-5), 105 and 95 are."""
    model = estimate(part_from_mesh(*shapes.box(0.03, 0.04, 0.01)), "split")
    pairs = [(pose.index, pose.group) for pose in model.by_index.values()]
    assert [group for _, group in pairs] == [0, 0, 1, 1, 2, 2]
    equal = observe_counts(model, [105, 95, 3, 2, 1, 0])
    assert equal.warnings == model.warnings
    assert equal.by_index[0].probability == equal.by_index[1].probability
    unequal = observe_counts(model, [130, 70, 3, 2, 1, 0])
    notes = {note.code: note for note in unequal.warnings if note.acts}
    assert notes.keys() - {note.code for note in model.warnings} == {"CONFLICT"}
    assert notes["CONFLICT"].text.startswith("poses 0, 1 are the same by symmetry")
    shares = [pose.probability for pose in unequal.by_index.values()]
    assert shares[0] > 1.5 * shares[1]
    assert shares[2] == shares[3] and sum(shares) == pytest.approx(1.0)


PREDICTED = np.array([0.38, 0.20, 0.14, 0.13, 0.10, 0.05])


def predicted(error, plate_error):
    """A model of six poses that says these shares, and how sure it is."""
    model = estimate(part_from_mesh(*shapes.box(0.02, 0.03, 0.012)), "split")
    spread = PREDICTED * (1.0 - PREDICTED)
    errors = error * np.sqrt(spread / spread.mean())
    poses = [
        replace(
            pose, probability=PREDICTED[k], standard_error=errors[k], group=pose.index
        )
        for k, pose in enumerate(model.by_index.values())
    ]
    return replace(
        model, poses=tuple(poses), expected_error=error, plate_error=plate_error
    )


def test_the_chance_of_a_distance_is_uniform_where_only_chance_is_at_work():
    """5000 draws: the share below a level has a standard error of at most .7 points."""
    counts = np.random.default_rng(3).multinomial(400, PREDICTED, 5000)
    square = np.square(counts / 400 - PREDICTED).sum(axis=1)
    chance = distance_chance(square, PREDICTED, 400)
    for level in (0.01, 0.05, 0.5):
        assert np.mean(chance < level) == pytest.approx(level, abs=0.02)


def test_counts_are_worth_more_than_the_model_where_they_refute_it():
    model = predicted(0.01, 0.05)
    assert describe_use(model) == ""
    agreeing = observe_counts(model, np.round(40 * PREDICTED).astype(int))
    assert describe_use(agreeing).startswith("do not use it: the default is as good")
    refuting = observe_counts(model, np.round(400 * PREDICTED[::-1]).astype(int))
    assert describe_use(refuting).startswith("use it: ")
    table = str(refuting)
    assert "400 parts counted on the plate" in table and "counted  " in table
    assert re.search(r"expected error [\d.]+ points .* against the plate", table)


def told_by(statistics, model):
    return [note for note in statistics.warnings if note not in model.warnings]


@pytest.mark.parametrize(
    ("error", "counts", "is_told"),
    [
        (0.02, [2000, 600, 400, 0, 0, 0], True),
        (0.05, [2000, 600, 400, 0, 0, 0], True),
        (0.05, [500, 160, 120, 100, 80, 40], False),  # six points, as it errs itself
        # three points of a thousand parts, and the same of twenty thousand
        (0.005, [430, 190, 120, 110, 100, 50], False),
        (0.005, [8600, 3800, 2400, 2200, 2000, 1000], True),
        (math.nan, [2000, 600, 400, 0, 0, 0], False),  # nobody knows what it errs by
    ],
)
def test_a_cell_that_is_farther_from_the_model_than_chance_is_told(
    error, counts, is_told
):
    """No plate's error is doubted: that would be `CONFLICT`."""
    model = predicted(error, plate_error=0.3)
    assert math.isnan(model.model_gap)
    statistics = observe_counts(model, counts)
    shares = np.array(counts) / sum(counts)
    gap = np.sqrt(np.mean((PREDICTED - shares) ** 2))
    assert statistics.model_gap == pytest.approx(gap)
    notes = told_by(statistics, model)
    assert [note.code for note in notes] == ["MODEL_GAP"] * is_told
    if is_told:
        assert f"{100.0 * gap:.2g} points" in notes[0].text
        assert " most: counted " in notes[0].text
        assert "where a plate usually is" not in notes[0].text


def test_twice_the_error_of_a_plate_is_named_and_on_a_fitted_one_alone_told():
    """Four points: nothing strange at three of a plate, much at one."""
    counts = np.array([4600, 1900, 1200, 1100, 900, 300])
    gap = float(np.sqrt(np.mean((PREDICTED - counts / counts.sum()) ** 2)))
    assert 0.03 < gap < 0.05
    for plate_error in (0.03, 0.012):
        is_strange = gap > 2.0 * plate_error
        model = predicted(0.002, plate_error)
        (note,) = told_by(observe_counts(model, counts), model)
        assert note.code == "MODEL_GAP"
        assert (
            f"where a plate usually is {100.0 * plate_error:.2g} points off"
            in note.text
        ) == is_strange
        fitted = told_by(observe_counts(model, counts, PREDICTED.tolist()), model)
        assert [note.code for note in fitted] == ["MODEL_GAP"] * is_strange


@pytest.mark.parametrize("parts", [20, 40, 80, 160, 500, 3000])
def test_the_node_sees_a_gap_at_the_counts_at_which_a_bag_does(parts):
    """By Pearson's test of the groups, with the model's error in it, at .001."""
    counts = np.round(np.array([4, 2, 1, 1, 1, 1]) * parts / 10.0).astype(int)
    counts[0] += parts - counts.sum()
    for shift in (0.0, 0.1, 0.2):
        moved = counts.copy()
        moved[0] += round(shift * parts)
        moved[1] -= min(moved[1], round(shift * parts))
        model = predicted(0.01, plate_error=0.3)
        poses = list(model.by_index.values())
        test = goodness_of_fit(
            moved,
            [pose.probability for pose in poses],
            [pose.standard_error for pose in poses],
        )
        notes = told_by(observe_counts(model, moved), model)
        assert bool(notes) == (test.p_value < 0.001)


def test_poses_that_the_camera_never_reports_are_named():
    """One of 13 % is; that those of 10 and 5 % never come up may be the plate's."""
    model = predicted(0.01, plate_error=0.05)
    words = "the camera never reports pose 3, predicted 13.00 %"
    (note,) = told_by(observe_counts(model, [1600, 820, 580, 0, 0, 0]), model)
    assert f"; {words}; the answer has learnt" in note.text
    few = told_by(observe_counts(model, [16, 8, 6, 0, 0, 0]), model)
    assert not any("never reports" in note.text for note in few)
    sure = predicted(0.001, plate_error=0.001)
    (conflict,) = told_by(observe_counts(sure, [1600, 820, 580, 0, 0, 0]), sure)
    assert conflict.code == "CONFLICT"
    assert "; the camera never reports poses 3-5, predicted 28.00 %; " in conflict.text


def test_what_a_plate_errs_by_is_learnt_from_other_parts():
    """Counts as the estimate has them say little error, turned round they say much;
    none, none.
    """
    model = estimate(part_from_mesh(*shapes.box(0.02, 0.03, 0.012)), "split")
    stated = [
        round(1000 * p)
        for _, p in sorted((pose.index, pose.probability) for pose in model.poses)
    ]
    like = plate_evidence(model, stated)
    unlike = plate_evidence(model, stated[::-1])
    assert learn_plate_error([]) == pytest.approx(0.05)
    assert learn_plate_error([like] * 5) < 0.02 < 0.1 < learn_plate_error([unlike] * 5)
    evidence = [
        count / sum(stated) for count in stated[::-1]
    ]  # what a plate says without these counts
    statistics = observe_counts(model, [1, 0, 0, 0, 0, 0], evidence)
    assert [
        statistics.poses[0].index,
        statistics.poses[0].probability,
    ] == pytest.approx([4, 0.38], abs=0.01)
    foreign = observe_counts(model, [1, 0, 0, 0, 0, 0], evidence[:5])  # of other poses
    assert (
        foreign.expected_error
        == observe_counts(model, [1, 0, 0, 0, 0, 0]).expected_error
    )
