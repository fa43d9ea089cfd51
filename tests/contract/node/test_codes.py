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

"""Every answer has a code, so that no client has to read its sentence."""

import inspect

import pytest
from ros_pose_stats_msgs import action, msg, srv
from ros_pose_stats_msgs.msg import Code

from .contract import CODES, STATES
from .harness.client import CANCELLED, DONE, until
from .harness.goals import Goals
from .harness.jobs import LONG, cancelled, finished, get, known_part, start
from .harness.listed import rows
from .harness.parts import WEDGE, flat

ANSWERS = [
    getattr(kind, part)
    for interfaces, part in ((srv, "Response"), (action, "Result"))
    for _, kind in inspect.getmembers(interfaces)
    if hasattr(kind, part)
]
SHEET = WEDGE[0] * (1.0, 1.0, 0.0), WEDGE[1]  # flat: no solid part


@pytest.mark.parametrize("kind", ANSWERS)
def test_every_answer_says_success_code_and_message(kind):
    fields = kind.get_fields_and_field_types()
    said = [fields.get(name) for name in ("success", "code", "message")]
    assert said == ["boolean", "uint16", "string"]
    assert kind().code == Code.OK


@pytest.mark.parametrize(("kind", "numbers"), [(Code, CODES), (msg.JobStatus, STATES)])
def test_numbers_are_those_of_the_contract(kind, numbers):
    assert {name: getattr(kind, name) for name in numbers} == numbers


@pytest.mark.parametrize(
    ("service", "fields", "code"),
    [
        ("estimate", {"part_id": "nobody"}, Code.UNKNOWN_PART),
        ("get_statistics", {"part_id": "nobody"}, Code.UNKNOWN_PART),
        ("forget_part", {"part_id": "nobody"}, Code.UNKNOWN_PART),
        ("start_drop_simulation", {"part_id": "nobody"}, Code.UNKNOWN_PART),
        ("estimate", {"part": flat(WEDGE), "restitution": 1.5}, Code.BAD_VALUE),
        ("estimate", {"part": flat(WEDGE), "method": "best"}, Code.BAD_VALUE),
        ("get_statistics", {"heights": [0.0]}, Code.BAD_VALUE),
        ("estimate", {"part": flat(SHEET)}, Code.BAD_MESH),
        ("get_drop_simulation", {"job_id": "none"}, Code.NOT_FOUND),
        ("cancel_drop_simulation", {"job_id": "none"}, Code.NOT_FOUND),
        ("fit_plate", {"plate": "of nobody"}, Code.NOT_FOUND),
    ],
)
def test_a_refusal_says_what_kind_it_is(cell, service, fields, code):
    assert cell.refused(service, **fields)
    assert cell.call(service, **fields).code == code


def test_a_goal_says_what_a_service_says(cell):
    goals = Goals(cell)
    _, refused = goals.send(part_id="nobody").result()
    _, short = goals.send(
        part_id=known_part(cell), drops=LONG, max_seconds=0.05
    ).result()
    _, whole = goals.send(part_id=known_part(cell), drops=100).result()
    goals.close()
    assert (refused.success, refused.code) == (False, Code.UNKNOWN_PART)
    assert (short.success, short.code) == (True, Code.TIMED_OUT), short.message
    assert (whole.success, whole.code) == (True, Code.OK)
    ended = get(cell, short.job_id)
    assert (ended.code, ended.status.code) == (Code.OK, Code.TIMED_OUT)


def test_a_job_says_how_it_ended_also_in_the_list(cell):
    running = start(cell, known_part(cell), LONG, seed=2)
    finished_job = start(cell, known_part(cell), 9)
    cancelled(cell, running)
    finished(cell, finished_job)
    codes_of_jobs = {
        job.job_id: (job.state, job.code)
        for job in cell.good("list_drop_simulations").jobs
    }
    assert codes_of_jobs[running] == (CANCELLED, Code.CANCELLED)
    assert codes_of_jobs[finished_job] == (DONE, Code.OK)
    again = cell.call("cancel_drop_simulation", job_id=running)
    assert (again.success, again.code) == (False, Code.NOT_FOUND)


def test_a_full_queue_is_busy(tuned):
    tuned.set(max_queued_jobs=1)
    part_id = known_part(tuned)
    for seed in (1, 2):
        start(tuned, part_id, LONG, seed=seed)
    until(lambda: any(row.state == msg.JobStatus.RUNNING for row in rows(tuned)))
    request = {"part_id": part_id, "drops": LONG, "seed": 3}
    assert "max_queued_jobs" in tuned.refused("start_drop_simulation", **request)
    assert tuned.call("start_drop_simulation", **request).code == Code.BUSY
