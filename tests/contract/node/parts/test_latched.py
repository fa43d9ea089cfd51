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

"""What late joiners get on ~/pose_statistics, and what may take its place."""

import time
from itertools import pairwise

import numpy as np
import pytest
import trimesh

from ros_pose_stats import estimate

from ..harness.cell import MeshPublisher, latched
from ..harness.client import until
from ..harness.jobs import (
    LONG,
    cancelled,
    finished,
    get,
    known_part,
    running_with_results,
    start,
)
from ..harness.parts import WEDGE, flat, library_part, whole
from .test_estimate import assert_like_library

OTHERS = {
    "other method": {"method": "csae"},
    "restitution": {"restitution": 0.2},
    "drop height": {"drop_height": 3.0},
}


def test_late_joiners_get_the_result_of_every_part(cell):
    parts = [known_part(cell) for _ in range(5)]
    job_statistics = finished(cell, start(cell, parts[0], 3000)).statistics
    with cell.late_joiner() as joiner:
        for part_id in parts:
            assert whole(joiner.wait(part_id)) == whole(latched(cell, part_id))
            assert len(joiner.of(part_id)) == 1
        first = joiner.wait(parts[0])
    assert (first.method, first.final, first.job_id) == (
        "simulation",
        True,
        job_statistics.job_id,
    )
    assert first.poses == job_statistics.poses
    assert {latched(cell, part_id).method for part_id in parts[1:]} == {"hybrid"}


def test_a_larger_error_never_replaces_a_smaller_one(cell):
    part_id = known_part(cell)
    assert finished(cell, start(cell, part_id, 3, seed=1)).statistics.drops == 3
    assert latched(cell, part_id).method == "hybrid"
    finished(cell, start(cell, part_id, 4000, seed=1))
    best = latched(cell, part_id)
    assert (best.method, best.drops) == ("simulation", 4000)
    assert finished(cell, start(cell, part_id, 1000, seed=2)).statistics.drops == 1000
    for method in ("area", ""):
        assert not cell.good(
            "estimate", part_id=part_id, method=method
        ).statistics.job_id
    cell.good("estimate", part=flat(WEDGE, part_id))
    assert whole(latched(cell, part_id)) == whole(best)
    finished(cell, start(cell, part_id, 8000, seed=2))
    assert latched(cell, part_id).drops == 8000


def test_an_estimate_gives_way_to_its_check_whatever_its_error(cell):
    """Drops beside the estimate of a leaning stump tell a larger error."""
    angle = np.arange(3) * 2.0 * np.pi / 3.0
    part_id = known_part(cell)
    foot = 0.02 * np.stack([np.cos(angle), 0.8 * np.sin(angle), 0.0 * angle], axis=1)
    top = foot * (0.8, 0.9, 1.0) + np.array((0.004, 0.0, 0.06))
    hull = trimesh.convex.convex_hull(np.concatenate([foot, top]))
    surface = hull.vertices, hull.faces
    expected = estimate(library_part(surface, part_id))
    with cell.late_joiner() as joiner:
        joiner.wait(part_id)
        MeshPublisher(cell).matched().publish(flat(surface, part_id))
        joiner.wait(
            part_id,
            lambda statistics: (
                statistics.part_digest == expected.part_digest and statistics.drops
            ),
        )
        *_, estimated, checked = joiner.of(part_id)
    assert (
        estimated.method == "split"
        and estimated.expected_error < checked.expected_error
    )
    assert_like_library(checked, expected)
    for _ in range(2):
        assert whole(cell.good("estimate", part_id=part_id).statistics) == whole(
            checked
        )


def test_a_cancelled_simulation_counts_with_what_it_has(cell):
    part_id = known_part(cell)
    job_id = start(cell, part_id, LONG, seed=1)
    until(lambda: get(cell, job_id).status.drops_done > 5000)
    drops = cancelled(cell, job_id).statistics.drops
    latched_statistics = latched(cell, part_id)
    assert (
        latched_statistics.drops,
        latched_statistics.final,
        latched_statistics.job_id,
    ) == (drops, True, job_id)


@pytest.mark.parametrize("fields", OTHERS.values(), ids=OTHERS)
def test_answers_to_other_questions_are_not_latched(cell, fields):
    part_id = known_part(cell)
    earlier = latched(cell, part_id)
    assert not cell.good("estimate", part_id=part_id, **fields).statistics.job_id
    if "method" not in fields:
        assert (
            finished(cell, start(cell, part_id, 3000, **fields)).statistics.drops
            == 3000
        )
    assert whole(latched(cell, part_id)) == whole(earlier)


def test_the_scene_of_the_part_is_its_own_and_may_be_spelled_out(cell):
    scene = {"restitution": 0.3, "drop_height": 2.0}
    for part_id, fields in (
        (known_part(cell, **scene), {}),
        (known_part(cell, **scene), scene),
        (known_part(cell), {"restitution": 0.5}),
    ):
        latched_before = latched(cell, part_id)
        finished(cell, start(cell, part_id, 3000, **fields))
        latched_statistics = latched(cell, part_id)
        assert (latched_statistics.drops, latched_statistics.restitution) == (
            3000,
            latched_before.restitution,
        )


def test_an_estimate_by_the_method_that_is_wanted_now_takes_the_place_of_another(tuned):
    part_id = known_part(tuned)
    dropped = known_part(tuned)
    finished(tuned, start(tuned, dropped, 4000))
    tuned.set(default_method="area")  # its error is larger
    until(lambda: latched(tuned, part_id).method == "area")
    assert latched(tuned, dropped).drops == 4000


def test_while_a_simulation_goes_on_numbers_rise_and_errors_fall(cell):
    """At most once a second, and at the end."""
    part_id = known_part(cell)
    with cell.late_joiner() as joiner:
        joiner.wait(part_id)
        begun = time.monotonic()
        job_id = start(cell, part_id, LONG)
        until(lambda: len(joiner.of(part_id)) > 2)
        cancelled(cell, job_id)
        joiner.wait(part_id, lambda message: message.final and message.job_id)
        first, *results_ = joiner.of(part_id)
    assert first.final and not first.job_id
    assert [message.final for message in results_] == [False] * (len(results_) - 1) + [
        True
    ]
    assert all(b.revision > a.revision for a, b in pairwise([first, *results_]))
    assert all(b.expected_error <= a.expected_error for a, b in pairwise(results_[:-1]))
    assert (
        len(results_) <= time.monotonic() - begun + 2.0
    )  # with the first one and the end


def test_every_other_result_has_another_number(cell):
    part_id = known_part(cell)
    job_id = start(cell, part_id, LONG)
    drops_of = {(first := latched(cell, part_id)).revision: first.drops}

    def look():
        statistics = running_with_results(cell, job_id).statistics
        assert (
            drops_of.setdefault(statistics.revision, statistics.drops)
            == statistics.drops
        )
        return len(drops_of) > 3

    until(look)
