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

"""DDS domains in which nobody else's nodes are."""

from contextlib import contextmanager
from pathlib import Path

from domain_coordinator import domain_id

from tests.running import about

NUMBERS = range(1, 101)


def domains_in_use():
    """Domains that processes have in their environment.

    A node may live on after the run that had reserved its domain was killed.
    """
    names = (entry.name for entry in Path("/proc").glob("[0-9]*"))
    return {
        variable.removeprefix("ROS_DOMAIN_ID=")
        for name in names
        for variable in about(name, "environ").split("\0")
        if variable.startswith("ROS_DOMAIN_ID=")
    }


@contextmanager
def own_domain():
    """Reserve a domain; its number."""
    taken = domains_in_use()
    free = (number for number in NUMBERS if str(number) not in taken)
    with domain_id(free.__next__) as number:
        yield number
