"""What others wait for beside one client's trouble."""

from __future__ import annotations

import itertools
import threading
import time
from contextlib import contextmanager
from functools import partial
from statistics import median

from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs import srv

from tests.contract.node.harness.client import until
from tests.contract.node.harness.parts import fine_box

from ..bodies import slivers, smooth_body
from ..cell import WEDGE, MeshPublisher, flat, tried_node
from ..frame import Trial, judged

LATER = {"known": 0.05, "small": 0.1}
"""Seconds by which a known part's and a small new mesh's median answer may come later, beside
what they take alone: machines differ and are shared."""

CALLS, PAUSE = 100, 0.02
FACTORS = itertools.count()


@contextmanager
def mesh_under_check(client, make):
    """Somebody publishes a mesh that takes long to check."""
    MeshPublisher(client).matched().publish(flat(make(), "slow"))
    time.sleep(0.5)  # it is on its way in
    yield


@contextmanager
def queued_requests(client, count):
    """Somebody else asks for so many estimates at once."""
    other = client.node.create_client(
        srv.EstimatePoses, f"{client.prefix}/estimate", qos_profile=QoSProfile(depth=count))
    until(other.service_is_ready, "the service")
    waiting = [other.call_async(srv.EstimatePoses.Request(
        part_id="known", restitution=0.3 + 1e-4 * number)) for number in range(count)]
    yield
    for one in waiting:
        one.cancel()


@contextmanager
def deaf_client(client, rate):
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


def _latencies(client, name, calls):
    """Seconds that estimates of a known part, or of small new meshes, take one by one."""
    seconds = []
    for _ in range(calls):
        fields = {"part_id": "known"} if name == "known" else {"part": flat(
            ((1.0 + 1e-4 * next(FACTORS)) * WEDGE[0], WEDGE[1]), "small")}
        begin = time.monotonic()
        client.call("estimate", **fields)
        seconds.append(time.monotonic() - begin)
        time.sleep(PAUSE)
    return sorted(seconds)


def _beside(setting, trouble):
    """How much later others are answered beside some trouble."""
    calls, kept, words = setting.of(CALLS, 30), {}, []
    with tried_node(setting.folder) as (_, client):
        client.good("estimate", part=flat(WEDGE, "known"))
        alone = {name: _latencies(client, name, calls) for name in LATER}
        with trouble(client):
            for name, later in LATER.items():
                beside, before = _latencies(client, name, calls), median(alone[name])
                kept[f"a_{name}_part_is_answered"] = median(beside) < later + 3.0 * before
                words.append(f"{name} {1e3 * before:.0f} ms alone, beside "
                             f"{1e3 * median(beside):.0f} (at most {1e3 * beside[-1]:.0f})")
    return judged(2 * calls, "; ".join(words), **kept)


def _attack(name, done, trouble, **how):
    return Trial(name, done, partial(_beside, trouble=partial(trouble, **how)))


ATTACKS = (
    _attack("a million triangles", "A mesh that is only large", mesh_under_check,
            make=partial(fine_box, 1e6)),
    _attack("a smooth mesh", "A mesh with a hundred thousand corners on its hull",
            mesh_under_check, make=partial(smooth_body, 2e5)),
    _attack("a mesh of slivers", "Needles that lie across each other", mesh_under_check,
            make=partial(slivers, 10_000)),
    _attack("a thousand requests", "A thousand estimates asked for at once by somebody else",
            queued_requests, count=1000),
    _attack("a client that cannot hear", "Twenty requests a second whose answers cannot be "
            "delivered", deaf_client, rate=20.0))
