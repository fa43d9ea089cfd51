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

"""Drop simulations as a client follows them."""

from .client import CANCELLED, DONE, QUEUED, RUNNING, until
from .parts import WEDGE, flat, new_id

LONG = 5_000_000
"""Drops that take minutes: whoever asks for them cancels them."""


def known_part(client, surface=WEDGE, **fields):
    """Make a part known; its name."""
    part_id = new_id()
    client.good("estimate", part=flat(surface, part_id, **fields))
    return part_id


def start(client, part_id, drops, **fields):
    """Start a drop simulation; its id."""
    return client.good(
        "start_drop_simulation", part_id=part_id, drops=drops, **fields
    ).job_id


def get(client, job_id):
    return client.good("get_drop_simulation", job_id=job_id)


def reached(client, job_id, state):
    """Wait for a state, or for the end; what Get says then."""
    job = until(
        lambda: (answer := get(client, job_id)).status.state >= state and answer,
        f"state {state} of {job_id}",
    )
    assert job.status.state == state, (job.status, job.message)
    return job


def finished(client, job_id):
    return reached(client, job_id, DONE)


def running_with_results(client, job_id):
    """Wait until a job has some drops to show."""
    return until(
        lambda: (
            (answer := get(client, job_id)).status.state != QUEUED
            and answer.statistics.drops > 0
            and answer
        ),
        f"drops of {job_id}",
    )


def cancelled(client, job_id):
    """Cancel, and wait for the end."""
    client.good("cancel_drop_simulation", job_id=job_id)
    return reached(client, job_id, CANCELLED)


def cancel_all(client):
    """Empty the queue."""
    listed = client.call("list_drop_simulations")
    unfinished = [job.job_id for job in listed.jobs if job.state in (QUEUED, RUNNING)]
    for job_id in reversed(unfinished):
        client.call("cancel_drop_simulation", job_id=job_id)
    for job_id in unfinished:
        until(
            lambda job_id=job_id: (
                client.call("get_drop_simulation", job_id=job_id).status.state
                not in (QUEUED, RUNNING)
            )
        )
