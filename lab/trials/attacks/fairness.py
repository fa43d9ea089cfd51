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

"""What others wait for beside one client's trouble."""

import itertools
import os
import signal
import sys
import tempfile
import threading
import time
import zipfile
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from random import Random
from statistics import median

from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs.msg import PartMesh

from lab.bodies.slow import slivers, smooth_body
from tests.contract.node.harness.client import SERVICES
from tests.contract.node.harness.node import Running
from tests.contract.node.harness.parts import fine_box

from ..cell import MEGABYTE, WEDGE, MeshPublisher, end, flat, status, tried_node
from ..frame import Trial, judged
from .reading import MESH, VERTEX

LATER = {"known": 0.05, "small": 0.1}
"""Seconds by which a known part's and a small new mesh's median answer may come later,
beside what they take alone: machines differ and are shared.
"""

MOST_SECONDS = 0.1
"""Within which 99 of 100 answers about a known part come, on a machine that does
nothing else.
"""

DEAF_CLIENTS = 5
HEARD_SECONDS = 0.2
"""Within which 99 of 100 answers come beside them."""

END_SECONDS = 2.0
"""Within which a node ends beside them."""

MESH_FOLDERS = f"[{tempfile.gettempdir()}]"

RESTITUTION = 0.5
"""At which a known part is asked for, so that its answer is always at hand."""

CALLS = 300
PAUSE = 0.02
BEGIN_SECONDS = 0.5  # for a neighbour's trouble to arrive

FACTORS = itertools.count()


@contextmanager
def mesh_under_check(client, make):
    """Somebody publishes a mesh that takes long to check."""
    MeshPublisher(client).matched().publish(flat(make(), "slow"))
    time.sleep(0.5)  # it is on its way in
    yield


@contextmanager
def files_of_meshes(client):
    """Somebody names files in place of meshes: 16 MB of OBJ, 100 kB of 3MF that unpack
    to far more, and STL of 3 GB and OBJ of 1 GB that are nothing but holes.
    """
    publisher = MeshPublisher(client).matched()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        vertices, triangles = fine_box(350_000)
        with (folder / "large.obj").open("w") as text:
            text.writelines(f"v {x} {y} {z}\n" for x, y, z in vertices.tolist())
            text.writelines(f"f {a} {b} {c}\n" for a, b, c in (1 + triangles).tolist())
        with zipfile.ZipFile(folder / "bomb.3mf", "w", zipfile.ZIP_DEFLATED) as archive:
            objects = MESH.format(4_000_000 * VERTEX, "")
            archive.writestr(
                "3D/3dmodel.model",
                f"<model><resources>{objects}</resources><build>"
                '<item objectid="1"/></build></model>',
            )
        for file, gigabytes in (("holes.stl", 3), ("holes.obj", 1)):
            (folder / file).touch()
            os.truncate(folder / file, gigabytes * 2**30)
        for file in sorted(folder.iterdir()):
            publisher.publish(
                PartMesh(
                    part_id=file.name,
                    mesh_resource=f"file://{file}",
                    mesh_resource_unit="m",
                )
            )
        yield


def neighbour(client, name, *numbers):
    """A client of `neighbours` in a process of its own."""
    program = f"{__package__}.neighbours"
    return Running(sys.executable, "-m", program, name, client.prefix, *numbers)


@contextmanager
def beside(client, name, *numbers):
    """Such a client at its work."""
    with neighbour(client, name, *numbers) as running:
        running.says("begun")
        time.sleep(BEGIN_SECONDS)
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
    is_over = threading.Event()

    def ask():
        while not is_over.wait(1.0):
            for deaf in clients:
                deaf.call_async(deaf.srv_type.Request(part_id="known"))

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


@contextmanager
def stopped(client, neighbours, lines, name, *numbers):
    """So many clients are stopped that have printed some lines, and take nothing."""
    with ExitStack() as stack:
        for _ in range(neighbours):
            running = stack.enter_context(neighbour(client, name, *numbers))
            for _ in range(lines):
                running.process.stdout.readline()
            running.process.send_signal(signal.SIGSTOP)
        yield


def _latencies(client, name, calls):
    """Seconds that estimates of a known part, or of small new meshes, take one by
    one.
    """
    seconds = []
    for _ in range(calls):
        fields = (
            {"part_id": "known", "restitution": RESTITUTION}
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


def _beside(setting, trouble, values):
    """How much later others are answered beside some trouble."""
    calls = setting.of(CALLS, 30)
    promises = {}
    words = []
    with tried_node(setting.folder, **values) as (node, client):
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
                        not setting.judges_times or late < MOST_SECONDS
                    )
                words.append(
                    f"{name} {1e3 * usual_time:.0f} ms alone (99 of 100 within "
                    f"{1e3 * usual:.0f}), beside {1e3 * median(latencies):.0f} "
                    f"({1e3 * late:.0f}, at most {1e3 * latencies[-1]:.0f})"
                )
        words.append(f"at most {status(node, 'VmHWM') / MEGABYTE:.0f} MiB")
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
            ending = end(node)
    seconds.sort()
    return judged(
        calls,
        f"each answered, half within {1e3 * median(seconds):.0f} ms, 99 of 100 within "
        f"{1e3 * _late(seconds):.0f}, at most {1e3 * seconds[-1]:.0f}; ended after "
        f"{ending:.1f} s",
        answers_come_soon=not setting.judges_times or _late(seconds) < HEARD_SECONDS,
        it_ends_soon=not setting.judges_times or ending < END_SECONDS,
    )


def _attack(name, done, trouble, before="", **values):
    """Others beside some trouble, at a node with values of its own."""
    work = partial(_beside, trouble=trouble, values=values)
    return Trial(name, done, work, before)


def _beside_neighbour(title, done, name, *numbers, before=""):
    """Others beside somebody at that work."""

    def trouble(client):
        return beside(client, name, *numbers)

    return _attack(title, done, trouble, before)


ATTACKS = (
    _beside_neighbour(
        "a million triangles",
        "Meshes that are only large, one every six seconds",
        "publish_meshes",
        1_000_000,
    ),
    _attack(
        "a smooth mesh",
        "A mesh with a hundred thousand corners on its hull",
        partial(mesh_under_check, make=partial(smooth_body, 2e5)),
    ),
    _attack(
        "a mesh of slivers",
        "Needles that lie across each other",
        partial(mesh_under_check, make=partial(slivers, 10_000)),
    ),
    _attack(
        "meshes in files",
        "Names of files in place of meshes, which are large or stand for much",
        files_of_meshes,
        "read in the callback: everybody waited for 3.3 s of 16 MB OBJ, 11.7 s of "
        "213 kB 3MF, 11 s and 3.1 GB of 3 GB STL, 24 s of 1 GB OBJ",
        mesh_folders=MESH_FOLDERS,
    ),
    _beside_neighbour(
        "a thousand requests",
        "A thousand estimates at other restitutions asked for at once by somebody else",
        "ask_for_many",
        1000,
        before="99 of 100 within 202 ms",
    ),
    Trial(
        "deaf clients",
        "Five clients of one service that ask each second for what cannot be "
        "delivered, and one that can hear",
        partial(_beside_deaf_clients, trouble=deaf_clients),
        "two were enough: another heard nothing for 18 s; ended after 2.4 to 4.1 s",
    ),
    Trial(
        "stopped clients",
        "Five clients of one service that are stopped while they ask, and one that "
        "goes on",
        partial(
            _beside_deaf_clients,
            trouble=lambda client: stopped(client, DEAF_CLIENTS, 20, "ask", 50),
        ),
    ),
    _attack(
        "stopped subscribers",
        "Three subscribers to results that are stopped",
        lambda client: stopped(client, 3, 2, "subscribe"),
    ),
    _beside_neighbour(
        "outlines at 6,000 heights",
        "Eight requests a second for outlines of a known part",
        "ask_for_outlines",
        6000,
        8,
    ),
    _beside_neighbour(
        "outlines at 300 heights",
        "Sixteen requests a second for as many as are answered",
        "ask_for_outlines",
        300,
        16,
        before="99 of 100 within 200 ms, at most 1,317",
    ),
    _beside_neighbour(
        "a camera",
        "Seven hundred counts a second of the part",
        "count",
        700,
        before="99 of 100 within 149 ms",
    ),
    _beside_neighbour(
        "changing parameters",
        "Another restitution twenty times a second",
        "set_parameters",
        20,
        before="99 of 100 within 331 ms",
    ),
    _beside_neighbour("flips", "Goals of flips, one after the other", "flip"),
    _beside_neighbour(
        "a full queue",
        "Twenty drop simulations a second, most of which find the queue full",
        "fill_queue",
        20,
    ),
)
