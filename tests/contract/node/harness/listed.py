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

"""Jobs as the node lists them, and what its bag has of a part."""

import re
from typing import NamedTuple

from .bags import message_of, on_topic, raw_of
from .client import QUEUED, RUNNING, until

UNFINISHED = QUEUED, RUNNING


class Row(NamedTuple):
    """A job in the list."""

    job_id: str
    part_id: str
    state: int
    done: int
    total: int


def rows(client):
    """All jobs, in the order of their acceptance."""
    return [
        Row(job.job_id, job.part_id, job.state, job.drops_done, job.drops_total)
        for job in client.good("list_drop_simulations").jobs
    ]


def jobs_of(client, part_id):
    """Ids of the jobs of a part."""
    return [row.job_id for row in rows(client) if row.part_id == part_id]


def only_job_of(client, part_id):
    """The job of a part that the node has started by itself."""
    (job_id,) = until(lambda: jobs_of(client, part_id), f"a job of {part_id}")
    return job_id


def job_named(message):
    """The job that an answer says will refine it."""
    return re.search(r"job (\S+)\.$", message)[1]


def recorded_of(node, topic, part_id):
    """What the bag of a node has of a part on a topic."""
    name = on_topic(topic)
    sign = part_id.encode()
    messages = (
        message_of(name, data)
        for data in raw_of(node.log_directory, name)
        if sign in data
    )
    return [
        message
        for message in messages
        if getattr(message, "status", message).part_id == part_id
    ]
