"""What others wait for beside one client's trouble."""

import itertools
import signal
import sys
import threading
import time
from contextlib import ExitStack, contextmanager
from functools import partial
from random import Random
from statistics import median

from rclpy.qos import DurabilityPolicy, QoSProfile

from lab.bodies.slow import slivers, smooth_body
from tests.contract.node.harness.client import SERVICES
from tests.contract.node.harness.node import Running
from tests.contract.node.harness.parts import fine_box

from ..cell import WEDGE, MeshPublisher, flat, tried_node
from ..frame import Trial, judged

LATER = {"known": 0.05, "small": 0.1}
"""Seconds by which a known part's and a small new mesh's median answer may come later,
beside what they take alone: machines differ and are shared.
"""

MOST_SECONDS = 0.05
"""Within which 99 of 100 answers about a known part come, on a machine that does
nothing else.
"""

DEAF_CLIENTS = 5
HEARD_SECONDS = 0.2
"""Within which 99 of 100 answers come beside them."""

END_SECONDS = 2.0
"""Within which a node ends beside them."""

CALLS = 300
PAUSE = 0.02

SUBSCRIBER = """
import sys, rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs.msg import PoseStatistics
rclpy.init()
node = rclpy.create_node("stopped")
latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(PoseStatistics, sys.argv[1] + "/pose_statistics",
                         lambda _: print("heard", flush=True), latched)
rclpy.spin(node)
"""
ASKER = """
import sys, time, rclpy
from ros_pose_stats_msgs.srv import EstimatePoses
rclpy.init()
node = rclpy.create_node("asker")
client = node.create_client(EstimatePoses, sys.argv[1] + "/estimate")
client.wait_for_service()
while True:
    client.call_async(EstimatePoses.Request(part_id="known"))
    print("asked", flush=True)
    time.sleep(0.02)
"""
CROWD = """
import sys, rclpy
from rclpy.qos import QoSProfile
from ros_pose_stats_msgs.srv import EstimatePoses
rclpy.init()
node, count = rclpy.create_node("crowd"), int(sys.argv[2])
many = node.create_client(EstimatePoses, sys.argv[1] + "/estimate",
                          qos_profile=QoSProfile(depth=count))
many.wait_for_service()
requests = [EstimatePoses.Request(part_id="known", restitution=0.3 + 1e-4 * k)
            for k in range(count)]
waiting = [many.call_async(request) for request in requests]
print("asked", flush=True)
rclpy.spin(node)
"""
FACTORS = itertools.count()


@contextmanager
def mesh_under_check(client, make):
    """Somebody publishes a mesh that takes long to check."""
    MeshPublisher(client).matched().publish(flat(make(), "slow"))
    time.sleep(0.5)  # it is on its way in
    yield


@contextmanager
def queued_requests(client, count):
    """Somebody else asks for so many estimates, which are answered before those who ask
    later.
    """
    with Running(sys.executable, "-c", CROWD, client.prefix, count) as crowd:
        crowd.says("asked")
        yield


@contextmanager
def deaf_clients(client):
    """Clients ask once a second for what the node cannot send: its answers would have
    to be latched.
    """
    clients = [
        client.node.create_client(
            SERVICES["estimate"],
            f"{client.prefix}/estimate",
            qos_profile=QoSProfile(
                depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL
            ),
        )
        for _ in range(DEAF_CLIENTS)
    ]
    end = threading.Event()

    def ask():
        while not end.wait(1.0):
            for deaf in clients:
                deaf.call_async(deaf.srv_type.Request(part_id="known"))

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        yield
    finally:
        end.set()
        thread.join()


@contextmanager
def stopped(program, client, count, lines):
    """Processes are stopped that have printed some lines, so that they take nothing."""
    command = (sys.executable, "-c", program, client.prefix)
    with ExitStack() as stack:
        processes = [
            stack.enter_context(Running(*command)).process for _ in range(count)
        ]
        for process in processes:
            for _ in range(lines):
                process.stdout.readline()
            process.send_signal(signal.SIGSTOP)
        yield


def stopped_clients(client):
    """Clients are stopped that ask again and again, and take no answer."""
    return stopped(ASKER, client, DEAF_CLIENTS, 20)


def stopped_subscribers(client, count):
    """Somebody subscribes to what is latched and is stopped, so that nothing is
    taken.
    """
    return stopped(SUBSCRIBER, client, count, 1)


@contextmanager
def many_outlines(client, heights, at_once):
    """Somebody asks for so many outlines of the known part, again and again."""
    step = [1e-6 * k for k in range(heights)]
    end = threading.Event()

    def ask():
        while not end.wait(0.5):
            client.call("get_statistics", part_id="known", heights=step)

    threads = [threading.Thread(target=ask) for _ in range(at_once)]
    for thread in threads:
        thread.start()
    yield
    end.set()
    for thread in threads:
        thread.join()


def _latencies(client, name, calls):
    """Seconds that estimates of a known part, or of small new meshes, take one by
    one.
    """
    seconds = []
    for _ in range(calls):
        fields = (
            {"part_id": "known"}
            if name == "known"
            else {
                "part": flat(
                    ((1.0 + 1e-4 * next(FACTORS)) * WEDGE[0], WEDGE[1]), "small"
                )
            }
        )
        begin = time.monotonic()
        client.call("estimate", **fields)
        seconds.append(time.monotonic() - begin)
        time.sleep(PAUSE)
    return sorted(seconds)


def _late(latencies):
    """What 99 of 100 sorted latencies, or all but the longest, do not exceed."""
    return latencies[-1 - max(1, len(latencies) // 100)]


def _beside(setting, trouble):
    """How much later others are answered beside some trouble."""
    calls = setting.of(CALLS, 30)
    promises = {}
    words = []
    with tried_node(setting.folder) as (_, client):
        client.good("estimate", part=flat(WEDGE, "known"))
        usual_latencies = {name: _latencies(client, name, calls) for name in LATER}
        with trouble(client):
            for name, later in LATER.items():
                latencies = _latencies(client, name, calls)
                usual_time = median(usual_latencies[name])
                promises[f"a_{name}_part_is_answered"] = (
                    not setting.judges_times
                    or median(latencies) < later + 3.0 * usual_time
                )
                late, usual = map(_late, (latencies, usual_latencies[name]))
                if name == "known":
                    promises["99_of_100_come_in_time"] = (
                        not setting.judges_times or late < MOST_SECONDS + 2.0 * usual
                    )
                words.append(
                    f"{name} {1e3 * usual_time:.0f} ms alone (99 of 100 within "
                    f"{1e3 * usual:.0f}), beside {1e3 * median(latencies):.0f} "
                    f"({1e3 * late:.0f}, at most {1e3 * latencies[-1]:.0f})"
                )
    return judged(2 * calls, "; ".join(words), **promises)


def _beside_deaf_clients(setting, trouble):
    """Whether each call is answered soon beside clients that take no answers, and the
    node ends soon.
    """
    calls = setting.of(CALLS, 20)
    random = Random(setting.seed)
    seconds = []
    with tried_node(setting.folder) as (node, client):
        client.good("estimate", part=flat(WEDGE, "known"))
        with trouble(client):
            for _ in range(calls):
                time.sleep(random.uniform(0.5, 1.5))
                begin = time.monotonic()
                client.good("estimate", part_id="known")
                seconds.append(time.monotonic() - begin)
            begin = time.monotonic()
            node.send(signal.SIGTERM)
            status = node.ended()
            ending = time.monotonic() - begin
    seconds.sort()
    return judged(
        calls,
        f"each answered, half within {1e3 * median(seconds):.0f} ms, 99 of 100 within "
        f"{1e3 * _late(seconds):.0f}, at most {1e3 * seconds[-1]:.0f}; ended with "
        f"status {status} after {ending:.1f} s",
        answers_come_soon=not setting.judges_times or _late(seconds) < HEARD_SECONDS,
        it_ends_well=status == 0,
        it_ends_soon=not setting.judges_times or ending < END_SECONDS,
    )


def _attack(name, done, trouble, **options):
    return Trial(name, done, partial(_beside, trouble=partial(trouble, **options)))


ATTACKS = (
    _attack(
        "a million triangles",
        "A mesh that is only large",
        mesh_under_check,
        make=partial(fine_box, 1e6),
    ),
    _attack(
        "a smooth mesh",
        "A mesh with a hundred thousand corners on its hull",
        mesh_under_check,
        make=partial(smooth_body, 2e5),
    ),
    _attack(
        "a mesh of slivers",
        "Needles that lie across each other",
        mesh_under_check,
        make=partial(slivers, 10_000),
    ),
    _attack(
        "a thousand requests",
        "A thousand estimates asked for at once by somebody else",
        queued_requests,
        count=1000,
    ),
    Trial(
        "deaf clients",
        "Five clients of one service that ask each second for what cannot be "
        "delivered, and one that can hear",
        partial(_beside_deaf_clients, trouble=deaf_clients),
    ),
    Trial(
        "stopped clients",
        "Five clients of one service that are stopped while they ask, and one that "
        "goes on",
        partial(_beside_deaf_clients, trouble=stopped_clients),
    ),
    _attack(
        "stopped subscribers",
        "Three subscribers to results that are stopped",
        stopped_subscribers,
        count=3,
    ),
    _attack(
        "outlines at 6,000 heights",
        "Eight requests at once for outlines of a known part",
        many_outlines,
        heights=6000,
        at_once=8,
    ),
    _attack(
        "outlines at 150 heights",
        "Eight requests at once for as many as are answered",
        many_outlines,
        heights=150,
        at_once=8,
    ),
)
