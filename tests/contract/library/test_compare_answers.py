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

"""`compare` as its caller sees it: drops in common, stops, progress, warnings and
refusals.
"""

import json
import math

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import clamp_hull, random_polyhedron
from lab.bodies.variants import moved
from ros_pose_stats import (
    PoseStatsError,
    compare,
    part_from_mesh,
    resting_poses,
    shift_center,
    simulate,
)


def clamp(*factors):
    vertices, triangles = clamp_hull()
    return part_from_mesh(1e-3 * vertices * (factors or 1.0), triangles)


@pytest.fixture(scope="module")
def pair():
    return [clamp(), clamp(1.02, 1.0, 1.0)]


@pytest.fixture(scope="module")
def dice():
    """Whose difference takes many drops."""
    return [
        part_from_mesh(*shapes.box(0.016, 0.016, height)) for height in (0.016, 0.0155)
    ]


def timeless(comparison):
    values = comparison.as_dict()
    variants = [{**variant, "seconds": None} for variant in values["variants"]]
    return {**values, "seconds": None, "variants": variants}


def test_the_same_request_has_the_same_answer_whatever_the_workers(pair):
    first, second = (
        compare(pair, drops=600, seed=9, workers=workers) for workers in (1, 3)
    )
    assert timeless(first) == timeless(second)


def test_the_first_variant_is_dropped_as_by_itself_and_all_from_its_height(pair):
    larger = part_from_mesh(*moved(clamp_hull(), scale=1.5e-3))
    comparison = compare([*pair, larger], drops=500, seed=4)
    alone_ = simulate(pair[0], comparison.drops, seed=4)
    assert [pose.count for pose in comparison.statistics[0].poses] == [
        pose.count for pose in alone_.poses
    ]
    assert comparison.statistics[0].expected_error == alone_.expected_error
    assert {variant.drop_height for variant in comparison.statistics} == {
        alone_.drop_height
    }


def test_a_part_against_itself_differs_in_nothing(pair):
    (variant,) = compare([pair[0], pair[0]], drops=200, seed=2).variants
    for pose in variant.poses:
        difference = pose.share.difference
        assert (difference.value, difference.standard_error) == (0.0, 0.0)
    assert (variant.in_model, variant.on_plate) == ("none shown", "none shown")


def test_drops_in_common_know_a_small_difference_better_than_two_runs():
    part = part_from_mesh(*random_polyhedron(9, 11))
    (variant,) = compare(
        [part, shift_center(part, (1e-4, 0.0, 0.0))],
        drops=2000,
        seed=6,
        restitution=0.1,
    ).variants
    share = max(
        (pose.share for pose in variant.poses), key=lambda share: share.first.value
    )
    p = share.first.value
    separate_error = math.sqrt(2.0 * p * (1.0 - p) / 2000)
    assert share.difference.standard_error < 0.7 * separate_error


def test_it_ends_early_where_the_verdict_is_settled():
    comparison = compare([clamp(), clamp(1.0, 1.0, 1.5)], seed=1)
    assert (
        comparison.drops < 5000
        and comparison.variants[0].in_model == "difference shown"
    )


def test_a_wanted_pose_without_a_partner_is_never_accepted(pair):
    stone = part_from_mesh(*moved(random_polyhedron(8, 2), scale=0.02))
    feeder = compare([pair[0], stone], wanted=[1], drops=200, seed=1).variants[0].feeder
    assert feeder.lost == (1,) and feeder.poses.second == ()
    assert feeder.share.second.value == 0.0
    assert feeder.passes[1].value == math.inf


@pytest.mark.parametrize("factor", [0.001, 1.0 / 25.4, 0.1, 10.0, 60.0])
def test_another_scale_is_refused(factor):
    with pytest.raises(
        PoseStatsError, match=r"9 times apart, got A .*; export them in one"
    ):
        compare([clamp(), clamp(), clamp(factor, factor, factor)], drops=10, seed=1)


@pytest.mark.parametrize("factor", [1.0 / 8.0, 8.0])
def test_a_large_change_is_no_other_scale(factor):
    assert (
        compare([clamp(), clamp(factor, factor, factor)], drops=10, seed=1).drops == 10
    )


def touching(statistics):
    return [
        warning
        for warning in statistics.warnings
        if warning.code == "RELEASED_TOUCHING"
    ]


def test_a_low_release_is_said_of_those_that_it_touches():
    flat, high = (
        part_from_mesh(*shapes.box(0.008, 0.01, height)) for height in (0.006, 0.02)
    )
    comparison = compare([flat, high], drops=100, seed=4, drop_height=0.006)
    chunks = []
    simulate(flat, 100, seed=4, drop_height=0.006, on_drops=chunks.append)
    starts = np.concatenate([chunk.downs for chunk in chunks])
    for part, variant in zip((flat, high), comparison.statistics, strict=True):
        statistics = simulate(part, starts=starts, drop_height=0.006)
        assert touching(variant) == touching(statistics)
    assert touching(comparison.statistics[1])


class TestStops:
    def test_what_was_done_is_told(self, dice):
        calls = []
        comparison = compare(
            dice,
            drops=4000,
            seed=1,
            workers=1,
            on_progress=lambda drops_done, most: calls.append((drops_done, most)),
            should_stop=lambda: bool(calls) and calls[-1][0] > 3200,
        )
        assert 0 < comparison.drops < 4000 and calls[-1][1] == 16_000
        assert [drops_done for drops_done, _ in calls] == sorted(
            drops_done for drops_done, _ in calls
        )

    def test_before_the_first_drop(self, dice):
        comparison = compare(dice, wanted=[0], seed=1, should_stop=lambda: True)
        assert comparison.drops == 0 and comparison.variants[0].in_model == "none shown"
        json.dumps(
            [comparison.as_dict(), comparison.variants[0].as_dict()], allow_nan=False
        )


@pytest.mark.parametrize(
    ("count", "options", "words"),
    [
        (1, {}, "2 to 26 variants"),
        (2, {"wanted": [99]}, "wanted poses out of 0 to"),
        (2, {"plate_error": -0.1}, "a plate error from 0 to 1"),
        (2, {"plate_error": math.nan}, "a plate error from 0 to 1"),
        (2, {"drops": 0}, "drops"),
        (2, {"restitution": 1.0}, "restitution"),
    ],
)
def test_refusals(pair, count, options, words):
    with pytest.raises(PoseStatsError, match=words):
        compare(pair[:count], **options)


def test_poses_keep_the_indices_of_their_parts(pair):
    (variant,) = compare(pair, drops=20, seed=1).variants
    for part, side in zip(pair, ("first", "second"), strict=True):
        indices = [
            index for pose in variant.poses for index in getattr(pose.poses, side)
        ]
        assert sorted(indices) == [pose.index for pose in resting_poses(part).poses]
