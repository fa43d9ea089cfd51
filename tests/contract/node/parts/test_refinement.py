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

"""Background drops after each new mesh, where `refine_drops` asks for them."""

from itertools import pairwise

import pytest

from ..harness.cell import latched
from ..harness.client import QUEUED, RUNNING, until
from ..harness.jobs import LONG, finished, get, known_part, reached, start
from ..harness.listed import UNFINISHED, jobs_of, only_job_of
from ..harness.parts import WEDGE, flat

LARGER = 2.0 * WEDGE[0], WEDGE[1]


def test_what_is_latched_gets_sharper_step_by_step(tuned):
    tuned.set(refine_drops=40_000)
    with tuned.late_joiner() as joiner:
        part_id = known_part(tuned)
        final = joiner.wait(part_id, lambda message: message.job_id and message.final)
        results = joiner.of(part_id)
    assert (final.drops, final.method) == (40_000, "hybrid")
    assert results[0].final and not results[0].job_id
    assert [result.final for result in results if result.job_id][:-1] == [False] * sum(
        not result.final for result in results
    )
    assert all(
        b.revision > a.revision and b.drops > a.drops for a, b in pairwise(results)
    )


def test_a_client_s_job_is_served_first_and_the_refinement_begins_again(tuned):
    tuned.set(refine_drops=LONG)
    part_id = known_part(tuned)
    refinement = only_job_of(tuned, part_id)
    reached(tuned, refinement, RUNNING)
    finished(tuned, start(tuned, part_id, 300, seed=1))
    assert get(tuned, refinement).status.state in UNFINISHED
    reached(tuned, refinement, RUNNING)


def test_a_change_of_the_parameter_refines_known_parts(tuned):
    parts = [known_part(tuned) for _ in range(2)]
    tuned.set(refine_drops=2000)
    for part_id in parts:
        final = until(
            lambda part_id=part_id: (
                (candidate := latched(tuned, part_id)).drops == 2000
                and candidate.final
                and candidate
            )
        )
        assert final.method == "hybrid"


def test_a_copy_of_the_mesh_is_not_refined_again(tuned):
    tuned.set(refine_drops=2000)
    part_id = known_part(tuned)
    job_id = only_job_of(tuned, part_id)
    finished(tuned, job_id)
    tuned.good("estimate", part=flat(WEDGE, part_id))
    assert jobs_of(tuned, part_id) == [job_id]


@pytest.mark.parametrize(
    "end",
    [
        lambda client, part_id: client.good("estimate", part=flat(LARGER, part_id)),
        lambda client, part_id: client.good("forget_part", part_id=part_id),
        lambda client, part_id: client.set(refine_drops=0),
        lambda client, part_id: client.set(restitution=0.3),
    ],
    ids=["a new mesh", "forgotten", "switched off", "another scene"],
)
def test_a_refinement_ends_with_what_it_was_for(tuned, end):
    tuned.set(refine_drops=LONG)
    part_id = known_part(tuned)
    job_id = only_job_of(tuned, part_id)
    end(tuned, part_id)
    until(lambda: get(tuned, job_id).status.state not in UNFINISHED)


def test_a_full_queue_refuses_clients_only(tuned):
    tuned.set(max_queued_jobs=0)
    start(tuned, known_part(tuned), LONG)
    tuned.set(refine_drops=1000)
    part_id = known_part(tuned)
    assert get(tuned, only_job_of(tuned, part_id)).status.state == QUEUED
    assert "max_queued_jobs" in tuned.refused(
        "start_drop_simulation", part_id=part_id, drops=9
    )
