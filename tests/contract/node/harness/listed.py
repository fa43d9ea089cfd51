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
