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

"""The process in which a node builds meshes that take long."""

import os
import signal
from contextlib import ExitStack, contextmanager

from tests.running import about, children

from .client import until
from .parts import fine_box, flat, new_id


def memory(pid, line):
    """A line of a process's status, in bytes."""
    return 1024 * int(about(pid, "status").partition(f"{line}:")[2].split()[0])


NICENESS = 10
"""Of a process that builds, above that of its node; one that indexes a bag comes after
it.
"""


def _numbers(pid):
    """Numbers of a process as Linux has them, from the third on; none if it has
    ended.
    """
    return about(pid, "stat").rpartition(")")[2].split()


def _ticks(pid):
    """Time that a process has computed, in hundredths of a second."""
    numbers = _numbers(pid)
    return int(numbers[11]) + int(numbers[12]) if numbers else 0


def _builders(pid):
    """Children of a node that build, or would."""
    priority = os.getpriority(os.PRIO_PROCESS, pid) + NICENESS
    return [
        child
        for child in children(pid)
        if (numbers := _numbers(child)) and int(numbers[16]) == priority
    ]


def builder_at_work(pid):
    """The child of a node that builds, once it does: one may rest after earlier
    work.
    """
    at_first = {}

    def found():
        return next(
            (
                child
                for child in _builders(pid)
                if _ticks(child) > at_first.setdefault(child, _ticks(child))
            ),
            None,
        )

    return until(found, "a process that builds")


@contextmanager
def standing(pid):
    """Have a process stand still, so that nothing depends on how fast it is."""
    os.kill(pid, signal.SIGSTOP)
    try:
        yield pid
    finally:
        os.kill(pid, signal.SIGCONT)


@contextmanager
def standing_builder(client, pid):
    """Have the process that builds large parts stand still before it gets one.

    So a mesh may be called slow that takes moments.
    """
    client.good("estimate", part=flat(fine_box(6000), new_id()))  # which starts it
    with ExitStack() as stack:
        builders = _builders(pid)
        assert builders
        for builder in builders:
            stack.enter_context(standing(builder))
        yield


def kill(pid):
    """End a process as the operating system does when memory is short."""
    os.kill(pid, signal.SIGKILL)
