"""Meshes that take the node long, and the process in which it builds them."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import trimesh

from ros_pose_stats.ros.parts import building_process

from .client import until


def ellipsoid(triangles, length=0.04):
    """A smooth body: every vertex is a corner of the hull, which takes time.

    A hundred thousand triangles take three seconds.
    """
    rings = max(4, round((triangles / 4) ** 0.5))
    ball = trimesh.creation.uv_sphere(count=[rings, rings])
    return ball.vertices * [0.5 * length, 0.4 * length, 0.3 * length], ball.faces


def _children(pid):
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    return [int(child) for task in tasks for child in task.read_text().split()]


def builders(pid):
    """Processes of a process that build its parts."""
    name = building_process.__name__.encode()
    return [child for child in _children(pid)
            if name in Path(f"/proc/{child}/cmdline").read_bytes()]


def builder_at_work(pid):
    """The process that builds, once it is there."""
    (found,) = until(lambda: builders(pid), "a building process")
    return found


def is_gone(pid):
    """Whether a process has ended, though its parent may not have heard of it."""
    try:
        return ") Z" in Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return True


def kill(pid):
    """End a process as the operating system does when memory is short."""
    os.kill(pid, signal.SIGKILL)
