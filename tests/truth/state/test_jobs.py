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

"""Jobs: their end, what gives way to them, and what the state has of them."""

import threading
import time
from unittest.mock import MagicMock, Mock

import pytest
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent, JobStatus, PoseStatistics, StablePose

from ros_pose_stats.core.records.scene import DropScene
from ros_pose_stats.node import camera_counts, state as states
from ros_pose_stats.node.jobs import JobListener, JobRequest, Jobs, State, job_reports
from ros_pose_stats.node.lanes import finished_future
from ros_pose_stats.node.parts.known_part import LatchedResult

from .parts import equipment_of, known_part, source_of


def jobs_that_wait():
    """Jobs that end as soon as an event is set, and that event."""
    may_end = threading.Event()
    jobs = Jobs(
        "run",
        JobListener(),
        print,
        lambda *_: Mock(drops=1, warnings=(), seconds=may_end.wait(60.0)),
    )
    return jobs, may_end


def test_whoever_hears_that_a_job_has_ended_finds_its_place_free():
    def submit(seed):
        return jobs.submit(
            JobRequest("clamp", b"", DropScene(), 1, seed, 0.0, 600.0),
            finished_future(Mock()),
            Mock(max_queued_jobs=0),
        )

    jobs, may_end = jobs_that_wait()
    first = submit(1)
    heard = []
    first.finished.add_done_callback(lambda _: heard.append(submit(2)))
    may_end.set()
    while not first.finished.done() or jobs.running_job is first:
        time.sleep(0.01)
    assert heard and heard[0].finished.result(60.0) is None
    jobs.close("")


def test_a_refinement_that_gave_way_begins_again_though_the_client_cancels():
    runs = []

    def compute(job, part, listener, stop):
        runs.append(job.job_id)
        if len(runs) == 1:
            foreground = submit(refinement=False)
            assert stop.is_due()
            jobs.cancel(foreground.job_id, "cancelled by a client")
        complete = not stop.is_due()
        return stop.judge(Mock(drops=100 if complete else 1, warnings=()), complete, "")

    def submit(refinement):
        return jobs.submit(
            JobRequest("clamp", b"", DropScene(), 100, 1, 0.0, 600.0, refinement),
            finished_future(Mock()),
            Mock(max_queued_jobs=1),
        )

    jobs = Jobs("run", JobListener(), print, compute)
    refinement = submit(refinement=True)
    refinement.finished.result(60.0)
    assert runs == [refinement.job_id] * 2
    assert (refinement.state, refinement.drops_done) == (State.DONE, 100)
    jobs.close("")


def test_refinements_that_wait_let_go_of_parts_that_are_gone():
    """Each part may hold on to an open file, and many may be forgotten meanwhile."""
    jobs, may_end = jobs_that_wait()
    parts = [Mock(part_id=f"part {number}", is_current=True) for number in range(4)]
    refinements = [
        jobs.submit(
            JobRequest(part.part_id, b"", DropScene(), 1, 1, 0.0, 600.0, True),
            finished_future(part),
            Mock(),
        )
        for part in parts
    ]
    while jobs.running_job is None:
        time.sleep(0.001)
    parts[2].is_current = False
    jobs.cancel_refinement("part 3", "the part has changed", None)
    cancelled = [job.state is State.CANCELLED for job in refinements]
    may_end.set()
    jobs.close("")
    assert cancelled == [False, False, True, True]


@pytest.mark.filterwarnings(
    "ignore::DeprecationWarning"
)  # of a library that reads messages
@pytest.mark.parametrize("lost", range(1, 5))
def test_the_state_has_jobs_and_counts_before_the_bag(tmp_path, lost):
    """A goal's only answer, its result, says what that lost, but for the start of the
    run.
    """
    state = states.State(tmp_path / "one.sqlite3")
    had = []

    def record(topic, data):
        had.append(
            [row[1] for row in state.rows("jobs")]
            + [row[5] for row in state.rows("counts")]
        )
        return len(had) - 1 != lost

    equipment = equipment_of(
        Mock(put=lambda act, *_: finished_future(act())), state, MagicMock(), plate=""
    )._replace(recorder=Mock(record=record, last_problem="no room"))
    result = PoseStatistics(
        cluster_tolerance=0.0025, round_sides=192, poses=[StablePose()]
    )
    part = known_part(source_of(Mock()), equipment)
    part.latched = LatchedResult(result, result, DropScene())
    part.results.number = lambda *_: result
    parts = Mock(current=lambda name: part)
    reports = job_reports.JobReports(equipment, parts)
    state.commit(
        state.put(
            job_reports.job_change(
                JobEvent(status=JobStatus(job_id="run_0000", state=JobStatus.RUNNING))
            )
        )
    )
    reports.restore()
    outcome = Mock(drops=9, expected_error=0.1, drop_height=None, warnings=())
    jobs = Jobs("run", reports, pytest.fail, lambda *_: outcome)
    job = jobs.submit(
        JobRequest("clamp", b"", DropScene(), 9, 1, 0.0, 600.0),
        finished_future(part),
        Mock(max_queued_jobs=1),
    )
    job.finished.result(60.0)
    jobs.close("")
    camera_counts.Cameras(equipment, parts, Mock())
    kind, _, take = equipment.node.create_subscription.call_args_list[2].args[:3]
    equipment.node.create_subscription().handle.take_message.return_value = None
    three = kind(part_id="clamp", index=[0], count=[3])
    take(
        serialize_message(three),
        {"publication_sequence_number": 1, "source_timestamp": 1},
    )
    warnings = reports.answer_of(job.job_id).warnings
    state.close()
    assert had == [
        [4],
        [4, 1],
        [4, 1],
        [4, 3],
        [4, 3],
        [4, 3, (3).to_bytes(8, "little")],
    ]
    assert sum(warning.code == "NOT_RECORDED" for warning in warnings) == (lost != 2)


def test_the_newest_results_of_ended_jobs_are_kept_within_256_mebibytes():
    """Of older ones the end is known."""
    rows = {
        name: (
            name,
            JobStatus.DONE,
            serialize_message(
                JobEvent(status=JobStatus(job_id=name, state=JobStatus.DONE))
            ),
            bytes(2**27),
        )
        for name in ("run_0001", "run_0002", "run_0003")
    }
    state = Mock(
        rows=lambda table: list(rows.values()),
        get=lambda table, name: rows[name],
        put=lambda change: rows.update({change.key: change.row}),
    )
    reports = job_reports.JobReports(equipment_of(state=state), None)
    reports.restore()
    assert [len(row[3]) for row in rows.values()] == [0, 2**27, 2**27]
    assert (
        list(reports.ends) == list(rows)
        and reports.answer_of("run_0001") == PoseStatistics()
    )
