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

"""Meshes that take the node long, and the process in which it builds them."""

import os
import signal
from contextlib import ExitStack, contextmanager

import numpy as np
import trimesh

from tests.running import about, children

from .client import until
from .parts import fine_box, flat, new_id


def ellipsoid(triangles, length=0.04):
    """A smooth body: every vertex is a corner of the hull, which takes time.

    A hundred thousand triangles take three seconds.
    """
    rings = max(4, round((triangles / 4) ** 0.5))
    ball = trimesh.creation.uv_sphere(count=[rings, rings])
    return ball.vertices * [0.5 * length, 0.4 * length, 0.3 * length], ball.faces


def slivers(triangles, length=0.04, seed=0):
    """Needles across each other: tetrahedra a million times longer than they are thick.

    Whether they reach into each other is looked for as long as it may be.
    """
    chance = np.random.default_rng(seed)
    count = triangles // 4
    ends = chance.uniform(-0.5, 0.5, (2, count, 3)) * length
    offsets = chance.normal(size=(2, count, 3)) * 1e-6 * length
    corners = np.stack(
        [ends[0], ends[1], ends[0] + offsets[0], ends[0] + offsets[1]], 1
    )
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1])
    corners[volume < 0.0, 2:] = corners[volume < 0.0, 3:1:-1]
    rows = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    starts = 4 * np.arange(count)[:, None, None]
    return corners.reshape(-1, 3), (rows + starts).reshape(-1, 3).astype(np.uint32)


def memory(pid, line):
    """A line of a process's status, in bytes."""
    return 1024 * int(about(pid, "status").partition(f"{line}:")[2].split()[0])


def _ticks(pid):
    """Time that a process has computed, in hundredths of a second."""
    numbers = about(pid, "stat").rpartition(")")[2].split()
    return int(numbers[11]) + int(numbers[12]) if numbers else 0


def builder_at_work(pid):
    """The child of a node that builds, once it does: one may rest after earlier
    work.
    """
    at_first = {}

    def found():
        return next(
            (
                child
                for child in children(pid)
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
        (builder,) = map(stack.enter_context, map(standing, children(pid)))
        yield builder


def kill(pid):
    """End a process as the operating system does when memory is short."""
    os.kill(pid, signal.SIGKILL)
