"""How clients follow, list and cancel drop simulations."""

from __future__ import annotations

from ros_pose_stats_msgs.srv import GetDropSimulation

from ros_pose_stats import simulate

from ..harness.client import CANCELLED, DONE, QUEUED, RUNNING, until
from ..harness.jobs import (
    LONG,
    cancelled,
    finished,
    get,
    known_part,
    reached,
    running_with_results,
    start,
)
from ..harness.parts import WEDGE, counts, flat, library_part


class TestGetAndList:
    def test_unknown_job(self, cell):
        answer = cell.call("get_drop_simulation", job_id="none")
        assert (answer.success, answer.state) == (False, GetDropSimulation.Response.UNKNOWN)
        assert "'none'" in answer.message

    def test_waiting_then_running_then_done(self, cell):
        part_id = known_part(cell)
        first, second = start(cell, part_id, LONG, seed=1), start(cell, part_id, 500, seed=1)
        reached(cell, first, RUNNING)
        waiting = get(cell, second)
        assert (waiting.state, waiting.drops_done, waiting.drops_total) == (QUEUED, 0, 500)
        assert waiting.statistics.part_id == "" and len(waiting.statistics.poses) == 0
        cancelled(cell, first)
        assert finished(cell, second).statistics.drops == 500

    def test_a_running_job_shows_rising_drops(self, cell):
        job_id = start(cell, known_part(cell), LONG)
        early = running_with_results(cell, job_id)
        late = until(lambda: (now := get(cell, job_id)).drops_done > early.drops_done
                     and now.statistics.drops > early.statistics.drops and now)
        assert late.state == RUNNING
        assert not late.statistics.final
        assert late.statistics.revision > early.statistics.revision
        assert late.statistics.expected_error < early.statistics.expected_error

    def test_interim_statistics_are_a_prefix(self, cell):
        part_id = known_part(cell)
        found = running_with_results(cell, start(cell, part_id, LONG, seed=6)).statistics
        expected = simulate(library_part(WEDGE), found.drops, seed=6)
        assert counts(found.poses) == counts(expected.poses)

    def test_list_has_every_job_in_the_order_of_acceptance(self, cell):
        part_id = known_part(cell)
        done = start(cell, part_id, 100, seed=1)
        finished(cell, done)
        running, waiting = start(cell, part_id, LONG), start(cell, part_id, 200)
        reached(cell, running, RUNNING)
        listed = cell.call("list_drop_simulations")
        rows = list(zip(listed.job_id, listed.part_id, listed.state, listed.drops_total,
                        strict=True))
        assert rows[-3:] == [(done, part_id, DONE, 100), (running, part_id, RUNNING, LONG),
                             (waiting, part_id, QUEUED, 200)]
        assert listed.drops_done[-3] == 100 and listed.drops_done[-1] == 0

    def test_a_nameless_part_is_listed_under_the_name_it_gets(self, cell):
        job_id = cell.good("start_drop_simulation", part=flat(WEDGE), drops=100).job_id
        name = finished(cell, job_id).statistics.part_id
        assert name == library_part(WEDGE).part_id
        listed = cell.call("list_drop_simulations")
        assert dict(zip(listed.job_id, listed.part_id, strict=True))[job_id] == name


class TestCancel:
    def test_running_keeps_the_longest_prefix(self, cell):
        part_id = known_part(cell)
        job_id = start(cell, part_id, LONG, seed=8)
        running_with_results(cell, job_id)
        answer = cancelled(cell, job_id)
        found = answer.statistics
        assert 0 < found.drops == answer.drops_done < LONG
        assert found.final
        expected = simulate(library_part(WEDGE), found.drops, seed=8)
        assert counts(found.poses) == counts(expected.poses)

    def test_queued(self, cell):
        part_id = known_part(cell)
        running, waiting = start(cell, part_id, LONG), start(cell, part_id, 100)
        answer = cancelled(cell, waiting)
        assert answer.drops_done == 0 and "cancelled" in answer.message
        assert get(cell, running).state == RUNNING

    def test_twice(self, cell):
        job_id = start(cell, known_part(cell), LONG)
        cancelled(cell, job_id)
        message = cell.refused("cancel_drop_simulation", job_id=job_id)
        assert job_id in message and "CANCELLED" in message

    def test_one_that_is_done_stays_done(self, cell):
        job_id = start(cell, known_part(cell), 100)
        finished(cell, job_id)
        assert "DONE" in cell.refused("cancel_drop_simulation", job_id=job_id)
        assert get(cell, job_id).state == DONE

    def test_unknown(self, cell):
        assert "'none'" in cell.refused("cancel_drop_simulation", job_id="none")

    def test_a_new_request_does_not_join_a_cancelled_one(self, cell):
        part_id = known_part(cell)
        first = start(cell, part_id, LONG, seed=1)
        running_with_results(cell, first)
        cell.send("cancel_drop_simulation", job_id=first)
        second = cell.send("start_drop_simulation", part_id=part_id, drops=LONG, seed=1)
        until(second.done)
        reached(cell, first, CANCELLED)
        other = second.result().job_id
        assert other == first or get(cell, other).state in (QUEUED, RUNNING)
