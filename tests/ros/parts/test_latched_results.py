"""What late joiners get on ~/pose_statistics, and what may take its place."""

from __future__ import annotations

from itertools import pairwise

import pytest

from ..harness.client import until
from ..harness.jobs import LONG, cancelled, finished, get, known_part, running_with_results, start
from ..harness.parts import WEDGE, flat, new_id, whole


def latched(client, part_id):
    """The current result, as get_statistics gives it."""
    return client.good("get_statistics", part_id=part_id).statistics[0]


class TestLateJoiners:
    def test_get_the_estimate_of_every_part(self, cell):
        parts = [known_part(cell) for _ in range(5)]
        with cell.late_joiner() as joiner:
            for part_id in parts:
                message = joiner.wait(part_id)
                assert message.method == "split"
                assert whole(message) == whole(latched(cell, part_id))
                assert len(joiner.of(part_id)) == 1

    def test_get_a_simulation_once_it_is_done(self, cell):
        part_id = known_part(cell)
        answer = finished(cell, start(cell, part_id, 5000))
        with cell.late_joiner() as joiner:
            message = joiner.wait(part_id)
            assert whole(message) == whole(latched(cell, part_id))
            assert (message.method, message.final) == ("simulation", True)
            assert message.job_id == answer.statistics.job_id
            assert message.poses == answer.statistics.poses

    def test_get_nothing_of_a_forgotten_part(self, cell):
        gone, kept = known_part(cell), known_part(cell)
        cell.good("forget_part", part_id=gone)
        with cell.late_joiner() as joiner:
            joiner.wait(kept)
            joiner.wait(known_part(cell))
            assert gone not in joiner.parts()

    def test_a_forgotten_part_that_comes_again_is_latched_again(self, cell):
        part_id = known_part(cell)
        cell.good("forget_part", part_id=part_id)
        cell.good("estimate", part=flat(WEDGE, part_id))
        with cell.late_joiner() as joiner:
            joiner.wait(part_id)


class TestWorseNeverReplacesBetter:
    @pytest.mark.long
    def test_a_small_simulation_after_a_big_one(self, cell):
        part_id = known_part(cell)
        finished(cell, start(cell, part_id, 10_000, seed=1))
        before = latched(cell, part_id)
        small = finished(cell, start(cell, part_id, 500, seed=2)).statistics
        assert small.drops == 500  # the caller has it
        assert whole(latched(cell, part_id)) == whole(before)

    def test_an_estimate_after_a_simulation(self, cell):
        part_id = known_part(cell)
        finished(cell, start(cell, part_id, 10_000, seed=1))
        before = latched(cell, part_id)
        for method in ("area", ""):
            assert cell.good("estimate", part_id=part_id, method=method).statistics.drops == 0
        cell.good("estimate", part=flat(WEDGE, part_id))
        assert whole(latched(cell, part_id)) == whole(before)

    @pytest.mark.long
    def test_a_bigger_simulation_replaces(self, cell):
        part_id = known_part(cell)
        finished(cell, start(cell, part_id, 2000, seed=1))
        finished(cell, start(cell, part_id, 8000, seed=2))
        assert latched(cell, part_id).drops == 8000

    def test_a_handful_of_drops_does_not_replace_an_estimate(self, cell):
        part_id = known_part(cell)
        finished(cell, start(cell, part_id, 3, seed=1))
        assert latched(cell, part_id).method == "split"

    def test_a_cancelled_simulation_counts_with_what_it_has(self, cell):
        part_id = known_part(cell)
        job_id = start(cell, part_id, LONG, seed=1)
        until(lambda: get(cell, job_id).drops_done > 5000)
        drops = cancelled(cell, job_id).statistics.drops
        shown = latched(cell, part_id)
        assert (shown.drops, shown.final) == (drops, True)


class TestOtherQuestions:
    @pytest.mark.parametrize("scene", [{"restitution": 0.2}, {"drop_height": 3.0}])
    def test_answers_for_another_scene_are_not_latched(self, cell, scene):
        part_id = known_part(cell)
        before = latched(cell, part_id)
        answer = cell.good("estimate", part_id=part_id, **scene).statistics
        simulated = finished(cell, start(cell, part_id, 10_000, **scene)).statistics
        assert answer.drops == 0 and simulated.drops == 10_000
        assert whole(latched(cell, part_id)) == whole(before)

    def test_an_answer_by_another_method_is_not_latched(self, cell):
        part_id = known_part(cell)
        before = latched(cell, part_id)
        assert cell.good("estimate", part_id=part_id, method="csae").statistics.method == "csae"
        assert whole(latched(cell, part_id)) == whole(before)

    @pytest.mark.long
    def test_a_part_with_its_own_scene_is_latched_for_that(self, cell):
        part_id = known_part(cell, restitution=0.3, drop_height=2.0)
        assert latched(cell, part_id).restitution == 0.3
        finished(cell, start(cell, part_id, 5000))
        shown = latched(cell, part_id)
        assert (shown.drops, shown.restitution, shown.drop_height) == (5000, 0.3, 2.0)

    @pytest.mark.long
    def test_the_scene_spelled_out_is_the_same_scene(self, cell):
        part_id = known_part(cell)
        finished(cell, start(cell, part_id, 5000, restitution=0.5))
        assert latched(cell, part_id).drops == 5000


class TestRevisions:
    def test_rise_and_errors_fall_while_a_simulation_goes_on(self, cell):
        part_id = known_part(cell)
        with cell.late_joiner() as joiner:
            joiner.wait(part_id)
            job_id = start(cell, part_id, LONG, max_seconds=3.5)
            finished(cell, job_id)
            joiner.wait(part_id, lambda message: message.final and message.drops)
            told = joiner.of(part_id)
        assert [message.final for message in told[1:]] == [False] * (len(told) - 2) + [True]
        assert 3 <= len(told) <= 6  # at most once a second, and at the end
        assert all(b.revision > a.revision for a, b in pairwise(told))
        assert all(b.expected_error <= a.expected_error for a, b in pairwise(told[1:]))

    def test_every_other_result_has_another_number(self, cell):
        part_id = known_part(cell)
        job_id = start(cell, part_id, LONG)
        drops_of = {latched(cell, part_id).revision: 0}
        while len(drops_of) < 4:
            found = running_with_results(cell, job_id).statistics
            assert drops_of.setdefault(found.revision, found.drops) == found.drops


class TestNewMesh:
    def test_under_a_known_name_takes_the_place_of_the_old(self, cell):
        part_id = known_part(cell)
        finished(cell, start(cell, part_id, 5000))
        before = latched(cell, part_id)
        vertices, triangles = WEDGE
        cell.good("estimate", part=flat((1.5 * vertices, triangles), part_id))
        shown = latched(cell, part_id)
        assert shown.part_digest != before.part_digest
        assert (shown.method, shown.drops) == ("split", 0)
        assert shown.revision > before.revision

    @pytest.mark.long
    def test_the_old_one_again_has_its_best_result_again(self, cell):
        part_id = known_part(cell)
        finished(cell, start(cell, part_id, 5000))
        before = latched(cell, part_id)
        vertices, triangles = WEDGE
        between = cell.good("estimate", part=flat((1.5 * vertices, triangles), part_id))
        cell.good("estimate", part=flat(WEDGE, part_id))
        shown = latched(cell, part_id)
        assert (shown.part_digest, shown.drops) == (before.part_digest, 5000)
        assert shown.revision > between.statistics.revision

    def test_a_job_on_the_old_mesh_is_not_latched_for_the_new(self, cell):
        part_id = known_part(cell)
        job_id = start(cell, part_id, LONG, seed=3)
        running_with_results(cell, job_id)
        vertices, triangles = WEDGE
        cell.good("estimate", part=flat((1.5 * vertices, triangles), part_id))
        answer = cancelled(cell, job_id).statistics
        shown = latched(cell, part_id)
        assert answer.drops > 0 and answer.part_digest != shown.part_digest
        assert shown.method == "split"

    def test_the_same_name_and_mesh_is_the_same_part(self, cell):
        part_id = new_id()
        first = cell.good("estimate", part=flat(WEDGE, part_id)).statistics
        second = cell.good("estimate", part=flat(WEDGE, part_id)).statistics
        assert whole(first) == whole(second)
