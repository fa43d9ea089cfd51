"""A node that is started again and again, on bags that somebody has copied, renamed or cut."""

from __future__ import annotations

import shutil
import time
from typing import NamedTuple

from ros_pose_stats.recording.run_names import runs
from tests.ros.harness.cell import MeshPublisher, latched
from tests.ros.harness.client import until
from tests.ros.harness.parts import flat

from .bodies import TRIANGLE_BYTES, fine_box
from .cell import attacked, disk, forget_peak, resident

RESTORED = 600.0
"""Seconds within which all parts must be there again."""


class Start(NamedTuple):
    """What one start took.

    Attributes
    ----------
    seconds : float
        Until the parts were all there.
    disk : int
        Bytes of all bags once the node had ended.
    peak : int
        Resident bytes at most.
    parts : list of str
    """

    seconds: float
    disk: int
    peak: int
    parts: list[str]


def part_ids(client):
    """Names of the parts that have a result."""
    return sorted(one.part_id for one in client.call("get_statistics").statistics)


def publish_parts(client, parts, size, first=0):
    """Publish large parts one after the other, each once the one before is known."""
    publisher = MeshPublisher(client).matched()
    vertices, triangles = fine_box(size / TRIANGLE_BYTES)
    for number in range(first, first + parts):
        name = f"part_{number:03d}"
        publisher.publish(flat((vertices * (1.0 + 0.01 * number), triangles), name))
        latched(client, name)


def restart(domain, folder, times, expected, **values):
    """Start and end a node; a `Start` for each time."""
    starts = []
    for _ in range(times):
        begin = time.monotonic()
        with attacked(domain, folder, **values) as (node, client):
            forget_peak(node)
            until(lambda client=client: len(part_ids(client)) >= expected, "the parts")
            seconds, peak, names = (time.monotonic() - begin, resident(node, "VmHWM"),
                                    part_ids(client))
        starts.append(Start(seconds, disk(folder), peak, names))
    return starts


def grow(domain, folder, parts, size, times, **values):
    """Restart a node that knows large parts, with nothing new; the first life and the starts.

    Returns
    -------
    meshes : int
        Bytes of the meshes that were sent.
    disk : int
        Bytes of the bags after the first life.
    starts : list of Start
    """
    with attacked(domain, folder, **values) as (_, client):
        publish_parts(client, parts, size)
        known = len(part_ids(client))
    vertices, triangles = fine_box(size / TRIANGLE_BYTES)
    meshes = parts * (vertices.nbytes + triangles.nbytes)
    before = disk(folder)
    return meshes, before, restart(domain, folder, times, known, **values)


def copy_oldest(folder):
    """Copy the oldest run under a name that makes it the newest but one."""
    oldest, *_, newest = runs(folder)
    copy = newest.with_name(newest.name[:-1] + ("0" if newest.name[-1] != "0" else "1"))
    shutil.copytree(oldest, copy)
    return copy
