"""Signals, clocks, floods of counts, and disks that fill."""

from __future__ import annotations

import signal
import time

from ros_pose_stats_msgs.msg import PoseCounts

from tests.ros.harness.bags import recorded
from tests.ros.harness.cell import Health, MeshPublisher
from tests.ros.harness.client import until
from tests.ros.harness.parts import WEDGE, flat

from .cell import attacked, disk


def end_while_estimating(domain, folder, surface, **values):
    """SIGTERM while a long estimate runs; seconds until the end, the answer, the log."""
    with attacked(domain, folder, **values) as (node, client):
        waiting = client.send("estimate", part=flat(surface, "long"))
        time.sleep(1.5)
        assert not waiting.done(), "the estimate was too quick for this attack"
        begin = time.monotonic()
        node.send(signal.SIGTERM)
        status = node.ended()
        seconds = time.monotonic() - begin
        time.sleep(0.5)
        answer = waiting.result() if waiting.done() else None
        return status, seconds, answer, node.log


def flood_counts(domain, folder, counts, rate, **values):
    """Publish camera counts; how many were recorded, and how many diagnostics call lost."""
    with attacked(domain, folder, **values) as (_, client):
        statistics = client.good("estimate", part=flat(WEDGE, "counted")).statistics
        health = Health(client)
        publisher = MeshPublisher(client, f"{client.prefix}/pose_counts", PoseCounts).matched()
        begin = time.monotonic()
        for number in range(counts):
            publisher.publish(PoseCounts(
                part_id="counted", part_digest=statistics.part_digest,
                cluster_tolerance=statistics.cluster_tolerance, index=[0], count=[number]))
            time.sleep(max(0.0, begin + number / rate - time.monotonic()))
        time.sleep(3.0)
        _, values_told = health.line("recording")
    return len(recorded(folder, "pose_counts")), values_told


def fill_disk(domain, folder, surface, seconds, rate, **values):
    """Publish meshes of one part, each of a new size.

    Returns
    -------
    most, end : int
        Bytes of the bags at most, and once nothing more came.
    sent : int
    deleted : int
        Files of the running bag that went to make room.
    """
    vertices, triangles = surface
    most = number = 0
    with attacked(domain, folder, **values) as (_, client):
        publisher = MeshPublisher(client).matched()
        begin = time.monotonic()
        while time.monotonic() < begin + seconds:
            publisher.publish(flat((vertices * (1.0 + 1e-3 * number), triangles), "grows"))
            number += 1
            time.sleep(max(0.0, begin + number / rate - time.monotonic()))
            if number % 10 == 0:
                most = max(most, disk(folder))
        until(lambda: client.call("get_statistics", part_id="grows").success, "the part")
        time.sleep(3.0)
        end = disk(folder)
        _, told = Health(client).line("recording")
    return max(most, end), end, number, int(told["files deleted for max_log_bytes"])


def simulated_time(domain, folder):
    """A node on /clock that nobody publishes: whether it is ready, well and answers."""
    with attacked(domain, folder, use_sim_time=True) as (_, client):
        Health(client).line("jobs")
        return client.good("estimate", part=flat(WEDGE, "timeless")).statistics.header.stamp
