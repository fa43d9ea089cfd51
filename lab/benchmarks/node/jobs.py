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

"""Drop simulations for the other measurements."""

from contextlib import contextmanager
from itertools import count

from tests.contract.node.harness.client import DONE, until
from tests.contract.node.harness.jobs import (
    LONG,
    cancelled,
    get,
    running_with_results,
    start,
)

SEEDS = count(1)
"""One for each simulation: equal requests would be one job."""


def end(client, job_id):
    """Cancel a job, which may have ended, and wait for its end."""
    client.call("cancel_drop_simulation", job_id=job_id)
    until(lambda: get(client, job_id).status.state >= DONE, f"the end of {job_id}")


@contextmanager
def under_way(client, part_id):
    """A simulation on all workers of the node for as long as the context lasts."""
    job_id = start(client, part_id, LONG, seed=next(SEEDS))
    running_with_results(client, job_id)
    yield job_id
    cancelled(client, job_id)  # fails where it ended too early
