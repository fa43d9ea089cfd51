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

"""`sensitivity` and `suggest` as their callers see them: checks, stops and refusals."""

import math
from functools import partial

import numpy as np
import pytest

from lab.bodies import shapes
from ros_pose_stats import (
    estimate,
    part_from_mesh,
    resting_poses,
    sensitivity,
    simulate,
    suggest,
)
from tests.running import refusal_of

CUBE = part_from_mesh(*shapes.box(20e-3, 20e-3, 20e-3))


@pytest.fixture(scope="module")
def heavy():
    """A box that lies heavier on one end, and the poses on its two x faces."""
    part = part_from_mesh(
        *shapes.box(20e-3, 22e-3, 24e-3), center_of_mass=(0.0, 0.0, 3e-3)
    )
    return part, [
        pose.index for pose in resting_poses(part).poses if abs(pose.down[0]) > 0.99
    ]


def plain(analysis):
    """Slopes and counted changes."""
    return [
        (effect.number, effect.slope, effect.check and effect.check.value)
        for effect in analysis.effects
    ]


def test_the_same_request_has_the_same_answer_whatever_the_workers(heavy):
    part, wanted_poses = heavy
    first, two = (
        sensitivity(part, wanted_poses, drops=500, seed=3, workers=workers)
        for workers in (1, 2)
    )
    assert plain(first) == plain(two)
    assert 0 < sum(effect.check is not None for effect in first.effects) <= 6


@pytest.mark.parametrize("restitution", [0.5, 0.995])
def test_the_part_as_it_is_has_the_default_answer(heavy, restitution):
    """Also where drops hardly end, and it has a warning of its own."""
    part, wanted_poses = heavy
    default = estimate(part, restitution=restitution)
    analysis = sensitivity(part, wanted_poses, checks=0, restitution=restitution)
    poses = default.by_index
    assert analysis.method == default.method
    assert analysis.share == pytest.approx(
        sum(poses[pose].probability for pose in wanted_poses)
    )
    assert analysis.warnings == default.warnings
    assert (restitution == 0.5) != any(
        warning.code == "TARGET_MISSED" for warning in analysis.warnings
    )


def test_equal_requests_have_equal_drops(heavy):
    part, wanted_poses = heavy
    first, second, seeded = (
        sensitivity(part, wanted_poses, drops=100, **seed)
        for seed in ({}, {}, {"seed": 1})
    )
    assert plain(first) == plain(second) == plain(seeded)
    assert suggest(CUBE, list(range(6)), 1e-3, drops=10).seed == seeded.seed


def test_another_answer_of_the_part_may_be_had(heavy):
    part, wanted_poses = heavy
    dropped = simulate(part, 300, seed=2)
    analysis = sensitivity(part, wanted_poses, answer=dropped, checks=0)
    count = sum(dropped.by_index[pose].count for pose in wanted_poses)
    assert analysis.method == "simulation"
    assert analysis.share == pytest.approx(count / 300)


def test_an_answer_of_other_poses_is_refused(heavy):
    part, wanted_poses = heavy
    for other in (estimate(CUBE), estimate(part, cluster_tolerance=0.0)):
        words = refusal_of(sensitivity, part, wanted_poses, answer=other)
        assert "statistics of the part" in words


def test_all_checks_are_from_the_same_starts(heavy):
    part, wanted_poses = heavy
    single, several = (
        {
            effect.number: check
            for effect, check in sensitivity(
                part, wanted_poses, checks=checks, drops=100, seed=3
            ).checked
        }
        for checks in (1, 3)
    )
    ((number, check),) = single.items()
    assert several[number].value == check.value
    assert all(check.trials == 100 for check in several.values())
    # Intervals of several hold together, so that each is wider.
    assert several[number].low < check.low and several[number].high > check.high


def test_drops_end_where_the_gains_are_known(heavy):
    part, wanted_poses = heavy
    analysis = sensitivity(part, wanted_poses, checks=1, seed=3)
    ((_, check),) = analysis.checked
    assert check.high - check.low <= 0.025
    assert 1000 <= analysis.drops < 10_000


@pytest.mark.parametrize(
    ("drops", "ending"),
    [
        (100, "100 drops show none; more drops may"),
        (20_000, "show none, to 1.25 points"),
    ],
)
def test_more_drops_are_advised_only_where_they_would_be_made(drops, ending):
    box = part_from_mesh(*shapes.box(20e-3, 30e-3, 40e-3))
    analysis = sensitivity(box, [2, 3], step=3e-4, checks=1, drops=drops)
    words = analysis.describe_gain()
    assert words.startswith("no gain is sure: of the best step by estimate, ")
    assert words.endswith(ending)


def test_what_gains_is_listed_by_drops(heavy):
    part, wanted_poses = heavy
    analysis = sensitivity(part, wanted_poses, drops=3000, seed=3)
    values = [check.value for _, check in analysis.checked]
    assert values == sorted(values, reverse=True)
    assert 0 < len(analysis.gains) < len(analysis.checked)
    assert all(check.low > 0.0 for _, check in analysis.gains)
    # Of all steps together: one that gains nothing passes in no answer of a hundred.
    assert all(check.p_value <= 0.01 for _, check in analysis.gains)


def test_as_many_changes_are_checked_as_asked_for(heavy):
    part, wanted_poses = heavy
    for checks in (0, 2):
        analysis = sensitivity(part, wanted_poses, checks=checks, drops=50, seed=1)
        assert sum(effect.check is not None for effect in analysis.effects) == checks
    changes = [abs(effect.change) for effect in analysis.effects]
    assert changes == pytest.approx(sorted(changes, reverse=True), abs=1e-9)  # some tie


def test_a_stop_leaves_the_estimates(heavy):
    part, wanted_poses = heavy
    reports = []
    analysis = sensitivity(
        part,
        wanted_poses,
        seed=1,
        on_progress=reports.append,
        should_stop=lambda: bool(reports) and reports[-1] > 0.0,
    )
    assert all(0.0 <= share <= 1.0 for share in reports) and reports == sorted(reports)
    assert analysis.wanted == tuple(wanted_poses)


def test_nothing_is_suggested_where_nothing_can_be_gained():
    suggestion = suggest(CUBE, list(range(6)), 1e-3, drops=10, seed=1)
    assert suggestion.steps == () and suggestion.gain.value == 0.0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"wanted": [9]}, "wanted poses out of 0 to 5"),
        ({"wanted": []}, "at least one"),
        ({"wanted": [0], "step": 0.0}, "a step above 0"),
        ({"wanted": [0], "step": 1.0}, "half the part's radius"),
        ({"wanted": [0], "drops": 0}, "1 to 1000000000 drops"),
        ({"wanted": {}}, "none for poses 0-5"),
        ({"wanted": {(0, 1, 2): 0.5, 3: 0.5}}, "none for poses 4, 5"),
        ({"wanted": {range(6): 1.0, 3: 0.0}}, "two for pose 3"),
        ({"wanted": {6: 1.0}}, "wanted poses out of 0 to 5"),
        ({"wanted": {(): 1.0}}, "at least one"),
        ({"wanted": {range(6): -1.0}}, "wanted shares from 0, got -1.0"),
        ({"wanted": {range(6): math.nan}}, "wanted shares from 0, got nan"),
        ({"wanted": {range(6): "all"}}, "a number for a wanted share"),
        ({"wanted": {(0, 1, 2): 0.5, (3, 4, 5): 0.4}}, "a sum of 0.9"),
        ({"wanted": dict.fromkeys(range(6), 0)}, "a sum of 0"),
    ],
)
@pytest.mark.parametrize("ask", [sensitivity, partial(suggest, within=1e-3)])
def test_refusals(ask, options, words):
    if "step" in options and isinstance(ask, partial):
        pytest.skip("a suggestion has a bound")
    assert words in refusal_of(ask, CUBE, **options)


def test_shares_may_be_in_per_cent_and_rounded(heavy):
    part, _ = heavy
    poses = [pose.index for pose in resting_poses(part).poses]
    thirds = {(0, 1): 33.3, (2, 3): 33.3, tuple(poses[4:]): 33.3}
    fractions = {(0, 1): 1 / 3, (2, 3): 1 / 3, tuple(poses[4:]): 1 / 3}
    rounded, exact = (
        sensitivity(part, wanted, checks=0) for wanted in (thirds, fractions)
    )
    assert rounded.share == pytest.approx(exact.share, abs=1e-12)
    probability = {pose.index: pose.probability for pose in estimate(part).poses}
    shares = [sum(probability[pose] for pose in poses) for poses in thirds]
    assert exact.share == pytest.approx(
        1.0 - 0.5 * np.abs(np.array(shares) - 1 / 3).sum()
    )


def test_all_of_a_few_poses_is_the_same_as_their_sum(heavy):
    part, wanted_poses = heavy
    others = [
        pose.index
        for pose in resting_poses(part).poses
        if pose.index not in wanted_poses
    ]
    by_sum = sensitivity(part, wanted_poses, drops=200, seed=3)
    by_shares = sensitivity(
        part, {tuple(wanted_poses): 1.0, tuple(others): 0.0}, drops=200, seed=3
    )
    assert plain(by_shares) == plain(by_sum)
    assert by_shares.describe_goal() == by_sum.describe_goal()


@pytest.mark.parametrize("within", [0.0, -1e-3, 1.0, float("nan")])
def test_a_bound_that_is_none_is_refused(within):
    assert "a bound above 0" in refusal_of(suggest, CUBE, [0], within)
