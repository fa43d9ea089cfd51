"""Drop simulations through the services."""

from __future__ import annotations

import pytest

from ros_pose_stats import simulate

from ..harness.client import FAILED, RUNNING
from ..harness.jobs import LONG, finished, get, known_part, reached, start
from ..harness.parts import WEDGE, counts, flat, library_part, new_id


class TestStart:
    def test_counts_are_those_of_the_library_with_the_same_seed(self, cell):
        part_id = known_part(cell)
        answer = finished(cell, start(cell, part_id, 3000, seed=7))
        expected = simulate(library_part(WEDGE), 3000, seed=7)
        assert counts(answer.statistics.poses) == counts(expected.poses)
        assert answer.statistics.expected_error == expected.expected_error
        assert (answer.drops_done, answer.drops_total) == (3000, 3000)

    def test_result_says_what_was_asked_for(self, cell):
        part_id = known_part(cell)
        job_id = start(cell, part_id, 200, seed=9, restitution=0.25, drop_height=0.75)
        found = finished(cell, job_id).statistics
        assert (found.part_id, found.method, found.job_id) == (part_id, "simulation", job_id)
        assert (found.restitution, found.drop_height) == (0.25, 0.75)
        assert (found.drops, found.seed, found.final) == (200, 9, True)
        assert found.drops - found.unsettled == sum(pose.count for pose in found.poses)

    def test_poses_have_the_numbers_that_an_estimate_gives_them(self, cell):
        part_id = known_part(cell)
        estimated = cell.good("estimate", part_id=part_id).statistics
        simulated = finished(cell, start(cell, part_id, 200)).statistics
        def downs(poses):
            return {pose.index: pose.down for pose in poses}
        assert downs(simulated.poses) == downs(estimated.poses)

    def test_a_part_may_be_carried_and_is_remembered(self, cell):
        part_id = new_id()
        job_id = cell.good("start_drop_simulation", part=flat(WEDGE, part_id), drops=150,
                           seed=3).job_id
        assert finished(cell, job_id).statistics.part_id == part_id
        assert cell.good("get_statistics", part_id=part_id).statistics

    def test_seed_zero_is_drawn_and_reported(self, cell):
        part_id = known_part(cell)
        first, second = (finished(cell, start(cell, part_id, 300)).statistics for _ in range(2))
        assert 0 != first.seed != second.seed != 0
        again = finished(cell, start(cell, part_id, 300, seed=first.seed)).statistics
        assert counts(again.poses) == counts(first.poses)

    def test_the_largest_seed(self, cell):
        seed = 2**64 - 1
        found = finished(cell, start(cell, known_part(cell), 100, seed=seed)).statistics
        assert found.seed == seed

    def test_no_number_of_drops_stands_for_the_nodes(self, cell):
        answer = get(cell, start(cell, known_part(cell), 0))
        assert answer.drops_total == 10_000

    def test_target_error_ends_early(self, cell):
        part_id = known_part(cell)
        job_id = start(cell, part_id, 100_000, seed=4, target_error=0.02)
        found = finished(cell, job_id).statistics
        expected = simulate(library_part(WEDGE), 100_000, seed=4, target_error=0.02)
        assert found.expected_error <= 0.02
        assert found.drops == expected.drops < 100_000
        assert counts(found.poses) == counts(expected.poses)

    def test_the_end_of_the_time_is_said(self, cell):
        job_id = start(cell, known_part(cell), LONG, max_seconds=0.3)
        found = finished(cell, job_id).statistics
        assert 0 < found.drops < LONG
        assert any(warning.startswith("TIME_LIMIT: ") for warning in found.warnings)

    def test_ids_are_unique(self, cell):
        part_id = known_part(cell)
        assert len({start(cell, part_id, 100, seed=seed) for seed in range(1, 9)}) == 8


class TestIdenticalRequests:
    def test_in_flight_get_the_same_job(self, cell):
        part_id = known_part(cell)
        running = start(cell, part_id, LONG, seed=1)
        assert start(cell, part_id, LONG, seed=1) == running
        waiting = start(cell, part_id, LONG, seed=2)
        assert waiting != running
        assert start(cell, part_id, LONG, seed=2) == waiting

    def test_with_a_drawn_seed_too(self, cell):
        part_id = known_part(cell)
        assert start(cell, part_id, LONG) == start(cell, part_id, LONG)

    @pytest.mark.parametrize("other", [
        {"seed": 2}, {"drops": LONG - 1}, {"restitution": 0.4}, {"drop_height": 0.9},
        {"target_error": 1e-6}, {"max_seconds": 500.0}])
    def test_anything_else_is_another_job(self, cell, other):
        part_id = known_part(cell)
        asked = {"drops": LONG, "seed": 1}
        first = start(cell, part_id, **asked)
        assert start(cell, part_id, **{**asked, **other}) != first

    def test_the_nodes_own_values_spelled_out_are_the_same_request(self, cell):
        part_id = known_part(cell)
        first = start(cell, part_id, LONG, seed=1)
        assert start(cell, part_id, LONG, seed=1, restitution=0.5, max_seconds=600.0) == first

    def test_of_a_nameless_carried_part_get_the_same_job(self, cell):
        def ask():
            return cell.good("start_drop_simulation", part=flat(WEDGE), drops=LONG,
                             seed=5).job_id
        assert ask() == ask()

    def test_that_have_ended_are_done_again(self, cell):
        part_id = known_part(cell)
        first = start(cell, part_id, 100, seed=1)
        finished(cell, first)
        assert start(cell, part_id, 100, seed=1) != first


class TestRefusals:
    @pytest.mark.parametrize(("asked", "said"), [
        ({"drops": 10_000_001}, ("10000000", "10000001", "max_drops")),
        ({"drops": 2**64 - 1}, ("10000000", "max_drops")),
        ({"target_error": -0.1}, ("-0.1", "below 1")),
        ({"target_error": 1.0}, ("1.0", "below 1")),
        ({"target_error": float("nan")}, ("nan", "below 1")),
        ({"max_seconds": -1.0}, ("-1", "600")),
        ({"max_seconds": 601.0}, ("601", "600", "max_job_seconds")),
        ({"max_seconds": float("nan")}, ("nan", "600")),
        ({"max_seconds": float("inf")}, ("inf", "600")),
        ({"restitution": 1.0}, ("1.0", "below 1")),
        ({"restitution": float("nan")}, ("nan", "below 1")),
        ({"drop_height": 0.0}, ("0.0", "above 0 m")),
        ({"drop_height": float("inf")}, ("inf", "above 0 m")),
        ({"drop_height": float("nan")}, ("nan", "above 0 m")),
    ])
    def test_numbers_out_of_range(self, cell, asked, said):
        message = cell.refused("start_drop_simulation", part_id=known_part(cell), **asked)
        assert all(word in message for word in said), message

    def test_unknown_part(self, cell):
        assert "'nobody'" in cell.refused("start_drop_simulation", part_id="nobody")

    def test_no_part_at_all(self, cell):
        assert "part_id" in cell.refused("start_drop_simulation", drops=10)

    def test_a_bad_mesh_is_refused_or_fails_with_the_reason(self, cell):
        vertices, triangles = WEDGE
        message = cell.call("start_drop_simulation", drops=100,
                            part=flat((vertices, triangles + 5), new_id()))
        if message.success:
            message = reached(cell, message.job_id, FAILED)
        assert "vertex" in message.message or "vertices" in message.message

    def test_a_full_queue(self, cell):
        part_id = known_part(cell)
        running = start(cell, part_id, LONG, seed=1)
        reached(cell, running, RUNNING)
        for seed in range(2, 18):
            start(cell, part_id, LONG, seed=seed)
        message = cell.refused("start_drop_simulation", part_id=part_id, drops=LONG, seed=99)
        assert "16" in message and "max_queued_jobs" in message
        assert start(cell, part_id, LONG, seed=1) == running  # asked for again, not queued
