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

"""Drop simulations through `~/start_drop_simulation`: what is asked for is what is
done.
"""

import math

import pytest

from ros_pose_stats import simulate

from ..harness.client import RUNNING
from ..harness.jobs import LONG, finished, known_part, reached, start
from ..harness.parts import WEDGE, counts, library_part


class TestResults:
    def test_counts_are_those_of_the_library_with_the_same_seed(self, cell):
        part_id = known_part(cell)
        answer = finished(cell, start(cell, part_id, 3000, seed=7))
        expected = simulate(library_part(WEDGE), 3000, seed=7)
        assert counts(answer.statistics.poses) == counts(expected.poses)
        assert answer.statistics.expected_error == pytest.approx(
            expected.expected_error
        )
        status = answer.status
        assert (status.drops_done, status.drops_total, answer.message) == (
            3000,
            3000,
            "",
        )

    def test_they_say_what_was_asked_for(self, cell):
        part_id = known_part(cell)
        job_id = start(
            cell, part_id, 200, seed=2**64 - 1, restitution=0.25, drop_height=0.75
        )
        statistics = finished(cell, job_id).statistics
        assert (statistics.part_id, statistics.method, statistics.job_id) == (
            part_id,
            "simulation",
            job_id,
        )
        assert (statistics.restitution, statistics.drop_height) == (0.25, 0.75)
        assert (statistics.drops, statistics.seed, statistics.final) == (
            200,
            2**64 - 1,
            True,
        )
        assert statistics.drops - statistics.unsettled == sum(
            pose.count for pose in statistics.poses
        )
        estimated = cell.good("estimate", part_id=part_id).statistics
        assert {pose.index: pose.down for pose in statistics.poses} == {
            pose.index: pose.down for pose in estimated.poses
        }

    def test_seed_zero_is_drawn_and_reported(self, cell):
        part_id = known_part(cell)
        first, second = (
            finished(cell, start(cell, part_id, 300)).statistics for _ in range(2)
        )
        assert 0 != first.seed != second.seed != 0
        repeated = finished(cell, start(cell, part_id, 300, seed=first.seed)).statistics
        assert counts(repeated.poses) == counts(first.poses)

    def test_a_target_error_ends_early(self, cell):
        job_id = start(cell, known_part(cell), 100_000, seed=4, target_error=0.02)
        statistics = finished(cell, job_id).statistics
        expected = simulate(library_part(WEDGE), 100_000, seed=4, target_error=0.02)
        assert (
            statistics.drops == expected.drops < 100_000
            and statistics.expected_error <= 0.02
        )
        assert counts(statistics.poses) == counts(expected.poses)

    def test_so_does_the_time_which_is_said(self, cell):
        job_id = start(cell, known_part(cell), LONG, seed=5, max_seconds=0.3)
        statistics = finished(cell, job_id).statistics
        assert 0 < statistics.drops < LONG
        assert any(warning.code == "TIME_LIMIT" for warning in statistics.warnings)
        assert counts(statistics.poses) == counts(
            simulate(library_part(WEDGE), statistics.drops, seed=5).poses
        )


class TestIdenticalRequests:
    def test_in_flight_get_the_same_job_and_later_another(self, cell):
        part_id = known_part(cell)
        finished_job = start(cell, part_id, 100, seed=1)
        finished(cell, finished_job)
        assert start(cell, part_id, 100, seed=1) != finished_job
        running = start(cell, part_id, LONG, seed=1)
        waiting = start(cell, part_id, LONG, seed=2)
        random_job = start(cell, part_id, LONG)
        assert len({finished_job, running, waiting, random_job}) == 4
        assert start(cell, part_id, LONG, seed=1) == running
        assert start(cell, part_id, LONG, seed=2) == waiting
        assert start(cell, part_id, LONG) == random_job

    @pytest.mark.parametrize(
        "change",
        [
            {"seed": 2},
            {"drops": LONG - 1},
            {"restitution": 0.4},
            {"drop_height": 0.9},
            {"target_error": 1e-6},
            {"max_seconds": 500.0},
        ],
    )
    def test_anything_else_is_another_job(self, cell, change):
        part_id = known_part(cell)
        fields = {"drops": LONG, "seed": 1}
        assert start(cell, part_id, **fields) != start(
            cell, part_id, **{**fields, **change}
        )

    def test_the_node_s_own_values_spelled_out_are_the_same_request(self, cell):
        part_id = known_part(cell)
        first = start(cell, part_id, LONG, seed=1)
        assert (
            start(cell, part_id, LONG, seed=1, restitution=0.5, max_seconds=600.0)
            == first
        )


class TestRefusals:
    @pytest.mark.parametrize(
        ("fields", "words"),
        [
            ({"drops": 10_000_001}, ("10000000", "10000001", "max_drops")),
            ({"drops": 2**64 - 1}, ("10000000", "max_drops")),
            *[
                ({"target_error": value}, (str(value), "below 1"))
                for value in (-0.1, 1.0, math.nan)
            ],
            ({"max_seconds": -1.0}, ("-1", "600")),
            ({"max_seconds": 601.0}, ("601", "600", "max_job_seconds")),
            ({"max_seconds": math.nan}, ("nan", "600")),
            ({"restitution": 1.0}, ("1.0", "below 1")),
            ({"drop_height": math.inf}, ("inf", "above 0 m")),
        ],
    )
    def test_numbers_out_of_range(self, cell, fields, words):
        message = cell.refused(
            "start_drop_simulation", part_id=known_part(cell), **fields
        )
        assert all(word in message for word in words), message

    def test_a_full_queue(self, cell):
        """What is in flight may be asked for again all the same."""
        part_id = known_part(cell)
        running = start(cell, part_id, LONG, seed=1)
        reached(cell, running, RUNNING)
        for seed in range(2, 18):
            start(cell, part_id, LONG, seed=seed)
        message = cell.refused(
            "start_drop_simulation", part_id=part_id, drops=LONG, seed=99
        )
        assert "16" in message and "max_queued_jobs" in message
        assert start(cell, part_id, LONG, seed=1) == running
