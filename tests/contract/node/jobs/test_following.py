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

"""How clients follow, list and cancel drop simulations."""

import pytest
from ros_pose_stats_msgs.msg import JobStatus

from ros_pose_stats import simulate

from ..harness.client import CANCELLED, DONE, QUEUED, RUNNING, until, wait_for
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
from ..harness.listed import UNFINISHED, Row, recorded_of, rows
from ..harness.parts import WEDGE, counts, library_part


@pytest.mark.parametrize("service", ["get_drop_simulation", "cancel_drop_simulation"])
def test_unknown_jobs_are_refused(cell, service):
    assert "'none'" in cell.refused(service, job_id="none")
    answer = cell.call("get_drop_simulation", job_id="none")
    assert answer.status.state == JobStatus.UNKNOWN


def test_first_come_first_served(cell, shared_node):
    """The bag says when each was accepted, began and ended."""
    part_id = known_part(cell)
    jobs = [start(cell, part_id, 100 + seed, seed=seed) for seed in range(1, 9)]
    for job_id in jobs:
        finished(cell, job_id)
    states = JobStatus.QUEUED, JobStatus.RUNNING, JobStatus.DONE

    def all_events():
        events_by_job = recorded_of(shared_node, "job_events", part_id)
        return events_by_job if len(events_by_job) == len(states) * len(jobs) else None

    events = until(all_events, "all events")
    for state in states:
        assert [
            event.status.job_id for event in events if event.status.state == state
        ] == jobs
    last = next(
        event
        for event in events
        if (event.status.state, event.status.job_id) == (JobStatus.DONE, jobs[-1])
    )
    status = last.status
    assert (status.drops_total, status.drops_done, last.seed, last.refinement) == (
        108,
        108,
        8,
        False,
    )
    assert last.part_digest == library_part(WEDGE).digest


def test_waiting_then_running_then_done_and_listed_in_the_order_of_acceptance(cell):
    part_id = known_part(cell)
    finished_job = start(cell, part_id, 100, seed=1)
    finished(cell, finished_job)
    first = start(cell, part_id, LONG, seed=1)
    second = start(cell, part_id, 500, seed=1)
    reached(cell, first, RUNNING)
    waiting = get(cell, second)
    status = waiting.status
    assert (status.state, status.drops_done, status.drops_total) == (QUEUED, 0, 500)
    assert waiting.statistics.part_id == "" and len(waiting.statistics.poses) == 0
    listed = [
        row._replace(done=0) if row.state == RUNNING else row for row in rows(cell)[-3:]
    ]
    assert listed == [
        Row(finished_job, part_id, DONE, 100, 100),
        Row(first, part_id, RUNNING, 0, LONG),
        Row(second, part_id, QUEUED, 0, 500),
    ]
    cancelled(cell, first)
    assert finished(cell, second).statistics.drops == 500


def test_a_running_job_shows_a_prefix_that_grows(cell):
    job_id = start(cell, known_part(cell), LONG, seed=6)
    early = running_with_results(cell, job_id)
    late = until(
        lambda: (
            (later := get(cell, job_id)).status.drops_done > early.status.drops_done
            and later.statistics.drops > 4 * early.statistics.drops
            and later
        )
    )
    assert late.status.state == RUNNING and not late.statistics.final
    assert late.statistics.revision > early.statistics.revision
    assert late.statistics.expected_error < early.statistics.expected_error
    expected = simulate(library_part(WEDGE), early.statistics.drops, seed=6)
    assert counts(early.statistics.poses) == counts(expected.poses)


class TestCancel:
    def test_running_keeps_the_longest_prefix(self, cell):
        job_id = start(cell, known_part(cell), LONG, seed=8)
        running_with_results(cell, job_id)
        answer = cancelled(cell, job_id)
        statistics = answer.statistics
        assert (
            0 < statistics.drops == answer.status.drops_done < LONG and statistics.final
        )
        expected = simulate(library_part(WEDGE), statistics.drops, seed=8)
        assert counts(statistics.poses) == counts(expected.poses)
        message = cell.refused("cancel_drop_simulation", job_id=job_id)
        assert job_id in message and "CANCELLED" in message

    def test_a_new_request_does_not_join_a_cancelled_one(self, cell):
        part_id = known_part(cell)
        first = start(cell, part_id, LONG, seed=1)
        running_with_results(cell, first)
        cell.send("cancel_drop_simulation", job_id=first)
        answer = wait_for(
            cell.send("start_drop_simulation", part_id=part_id, drops=LONG, seed=1)
        ).job_id
        reached(cell, first, CANCELLED)
        assert answer == first or get(cell, answer).status.state in UNFINISHED
