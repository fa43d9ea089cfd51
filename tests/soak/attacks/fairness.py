"""What others wait for while one client's mesh is being checked."""

from __future__ import annotations

import itertools
import threading
import time
from contextlib import contextmanager

from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs import srv

from tests.ros.harness.cell import MeshPublisher
from tests.ros.harness.client import until
from tests.ros.harness.parts import WEDGE, flat

from .cell import Stopwatch, attacked

VERTICES, TRIANGLES = WEDGE
FACTORS = itertools.count()


def small_part():
    """Fields of a call that brings a small mesh which is new each time."""
    factor = 1.0 + 1e-4 * next(FACTORS)
    return {"part": flat((factor * VERTICES, TRIANGLES), "small")}


def known_part():
    """Fields of a call that asks for a known part."""
    return {"part_id": "known"}


@contextmanager
def mesh_under_check(client, surface):
    """Somebody publishes a mesh that takes long to check."""
    publisher = MeshPublisher(client).matched()
    publisher.publish(flat(surface, "slow"))
    time.sleep(0.5)  # it is on its way in
    yield


@contextmanager
def queued_requests(client, surface, count=1000):
    """Somebody else asks for a thousand estimates at once."""
    other = client.node.create_client(
        srv.EstimatePoses, f"{client.prefix}/estimate", qos_profile=QoSProfile(depth=count))
    until(other.service_is_ready, "the service")
    waiting = [other.call_async(srv.EstimatePoses.Request(
        part_id="known", restitution=0.3 + 1e-4 * number)) for number in range(count)]
    yield
    for one in waiting:
        one.cancel()


@contextmanager
def deaf_client(client, surface, rate=20.0):
    """Somebody asks for what the node cannot send: its answers would have to be latched."""
    deaf = client.node.create_client(
        srv.GetStatistics, f"{client.prefix}/get_statistics", qos_profile=QoSProfile(
            depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    over = threading.Event()

    def ask():
        while not over.wait(1.0 / rate):
            deaf.call_async(srv.GetStatistics.Request())

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def latencies(domain, folder, trouble, surface, seconds, **values):
    """Times of calls alone, and beside trouble.

    Returns
    -------
    dict
        "known" and "small": lists of seconds, each alone and beside.
    """
    with attacked(domain, folder, **values) as (_, client):
        client.good("estimate", part=flat(WEDGE, "known"))
        found = {}
        for name, make in (("known", known_part), ("small", small_part)):
            with Stopwatch(client, make) as alone:
                time.sleep(min(seconds, 2.0))
            found[name] = [alone.seconds]
        with trouble(client, surface):
            for name, make in (("known", known_part), ("small", small_part)):
                with Stopwatch(client, make) as beside:
                    time.sleep(seconds)
                found[name].append(beside.seconds)
        return found
