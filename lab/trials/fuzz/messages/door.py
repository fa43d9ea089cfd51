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

"""What is not quite right through the middleware: taken, or refused in one line, and
served on.
"""

import os
import re
import subprocess
import sys
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.action import PlanFeeding, SimulateDrops, SimulateFlips
from ros_pose_stats_msgs.msg import ObservedParts, PartMesh, PoseCounts
from shape_msgs.msg import Mesh

from ros_pose_stats.node.answering_node import SENDERS
from tests.contract.node.harness.client import wait_for
from tests.contract.node.harness.goals import Goals
from tests.contract.node.harness.jobs import cancel_all

from ...cell import (
    MEGABYTE,
    WEDGE,
    Client,
    Health,
    MeshPublisher,
    assert_line,
    assert_serves,
    domain,
    finished,
    flat,
    new_id,
    publish_in_turn,
    quiet,
    status,
    tried_node,
)
from ...frame import Outcome, Setting, judged
from .mutations import fuzzed
from .raw_requests import SERVICES
from .seeds import HOSTILE_NAMES

TOPICS = {
    PartMesh: ("part_mesh", 3500),
    Mesh: ("cad", 2500),
    PoseCounts: ("pose_counts", 1500),
    ObservedParts: ("observed_parts", 1500),
}
"""Name and number of messages; together with the requests over ten thousand."""

REQUESTS = 450
RAW = 60
AT_ONCE = 40
MOST_GROWTH = 150 * MEGABYTE
MOST_THREADS = 12
"""Of memory, and of threads, beside those that send a service's answers: each goal that
was cancelled has one for a moment."""

SMALL = {
    "max_drops": 60,
    "drops": 20,
    "max_parts": 30,
    "workers": 1,
    "max_mesh_bytes": 20_000,
    "mesh_topics": "[/tried/cad]",
}

OWN_NAMES = re.compile(
    r"\.lock|metadata\.yaml(\.half)?|pose_stats_\d{8}T\d{6}_\d{6}_\d+(_\d+\.mcap)?"
    r"|tried\.pose_stats\.(sqlite3(-wal|-shm|\.lock)?|meshes)|[0-9a-f]{64}(\.half)?"
)
"""Files of bags and of the state, and large meshes by their digest."""

ELSEWHERE = [Path("/etc/x"), Path("/tmp/x"), Path("/x"), Path("/x.mcap")]
"""Where some names point to."""


def bytes_on_topics(setting: Setting) -> Outcome:
    """Nine thousand messages on the four topics, nine in ten of them changed at
    random.
    """
    sent_messages = 0
    refused = 0
    thin = []
    with tried_node(setting.folder, **SMALL) as (node, client):
        health = Health(client)
        publish_in_turn(client, WEDGE, [f"part_{number}" for number in range(8)], 0.0)
        memory_before = status(node, "VmHWM")
        threads = status(node, "Threads")
        for kind, (name, number) in TOPICS.items():
            messages = list(fuzzed(kind, setting.seed, setting.of(number, 300)))
            topic = "/tried/cad" if kind is Mesh else ""
            publisher = MeshPublisher(
                client, topic or f"{client.prefix}/{name}", kind
            ).matched()
            begin = quiet(health)
            for first in range(
                0, len(messages), AT_ONCE
            ):  # a few, so that most are not overrun
                publisher.publish(*messages[first : first + AT_ONCE])
                publish_in_turn(client, WEDGE, [new_id()])
            refusals = quiet(health)["refused"] - begin["refused"]
            sent_messages = sent_messages + len(messages)
            refused = refused + refusals
            if len(messages) > 300 and not len(messages) / 20 < refusals < 0.97 * len(
                messages
            ):
                thin.append(f"{refusals} of {len(messages)} refused on {name}")
        grown = status(node, "VmHWM") - memory_before
        more_threads = status(node, "Threads") - threads
        assert_serves(client)
    return judged(
        sent_messages,
        f"{refused} refused, {grown / MEGABYTE:.0f} MiB and {more_threads} "
        f"threads more {'; '.join(thin)}",
        memory_is_bounded=grown < MOST_GROWTH,
        threads_are_bounded=more_threads <= MOST_THREADS,
        some_are_taken_and_some_refused=not thin,
    )


def requests_and_goals(setting: Setting) -> Outcome:
    """Four thousand requests and goals changed at random, and bytes that are none at
    all.
    """
    became: Counter[str] = Counter()
    with (
        tried_node(setting.folder, **SMALL) as (node, client),
        Client(domain(), client.prefix) as goals_client,
    ):
        publish_in_turn(client, WEDGE, [f"part_{number}" for number in range(8)], 0.0)
        threads = status(node, "Threads")
        for name in SERVICES:
            _ask(client, name, setting, became)
        for kind, name in (
            (SimulateDrops, "simulate_drops"),
            (SimulateFlips, "simulate_flips"),
            (PlanFeeding, "plan_feeding"),
        ):
            goals = Goals(goals_client, name)
            for goal in _readable(
                kind.Goal, setting.seed, setting.of(REQUESTS // 6, 20), became
            ):
                fields = kind.Goal.get_fields_and_field_types()
                _, result = goals.send(
                    **{name: getattr(goal, name) for name in fields}
                ).result()
                _judge(result, became)
            goals.close()
        cancel_all(client)
        raw = _strange_bytes(client, setting)
        cancel_all(client)
        new_threads = status(node, "Threads") - threads
        assert_serves(client)
    return judged(
        became.total() + raw,
        f"{became['taken']} taken, {became['refused']} refused, "
        f"{became['dropped']} that are none, {raw} of arbitrary bytes, {new_threads} "
        "threads more",
        some_are_taken=became["taken"] > 0,
        some_are_refused=became["refused"] > 0,
        threads_are_bounded=new_threads <= MOST_THREADS + SENDERS * len(SERVICES),
    )


def _ask(client, name, setting, became):
    """Requests of one service, some at once; what cannot be read as one is not sent."""
    kind = client.service(name).srv_type.Request
    if not kind.get_fields_and_field_types().keys() - {
        "structure_needs_at_least_one_member"
    }:
        return
    requests = _readable(kind, setting.seed, setting.of(REQUESTS, 60), became)
    for first in range(0, len(requests), AT_ONCE):
        for future in [
            client.service(name).call_async(request)
            for request in requests[first : first + AT_ONCE]
        ]:
            _judge(wait_for(future), became)


def _readable(kind, seed, number, became):
    """Changed messages as far as the bindings make something of them; the others are
    dropped.
    """
    requests = []
    with _no_words():
        for data in fuzzed(kind, seed, number):
            try:
                requests.append(deserialize_message(data, kind))
            except Exception:  # the bindings raise what they like
                became["dropped"] += 1
    return requests


@contextmanager
def _no_words():
    """The middleware prints what it cannot read."""
    standard_error = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(standard_error, 2)
        os.close(standard_error)
        os.close(nowhere)


def _judge(answer, became):
    """An answer says success, or why not in one line."""
    assert answer.success or answer.message
    assert_line(answer.message)
    became["taken" if answer.success else "refused"] += 1


def _strange_bytes(client, setting):
    """As only a broken client sends them: the middleware drops most; how many were
    sent.
    """
    jobs_before = len(client.call("list_drop_simulations").jobs)
    number = setting.of(RAW, 5)
    command = [
        sys.executable,
        "-m",
        f"{__package__}.raw_requests",
        client.prefix,
        str(number),
        str(setting.seed),
    ]
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ,
    ) as stranger:
        report = stranger.stdout.readline()
        assert report == f"sent {number * len(SERVICES)}\n", report
        for name, field in (("estimate", "part_id"), ("get_drop_simulation", "job_id")):
            # They stand in line behind those.
            assert "nobody" in client.call(name, **{field: "nobody"}).message
        stranger.stdin.close()
        assert stranger.wait() == 0
    assert len(client.call("list_drop_simulations").jobs) >= jobs_before
    return number * len(SERVICES)


def hostile_names(setting: Setting) -> Outcome:
    """Names of parts, jobs, methods, plates and frames that would leave the log
    directory.
    """
    bags = setting.folder / "deep" / "er" / "bags"
    work = setting.folder / "work"
    environment = {
        "TMPDIR": str(setting.folder / "tmp"),
        "HOME": str(setting.folder / "home"),
        "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME")
        or str(Path.home() / ".cache"),
    }  # where the kernels are
    for name in ("tmp", "home", "work"):
        (setting.folder / name).mkdir()

    def listing():
        inside = {
            path for path in setting.folder.rglob("*") if not path.is_relative_to(bags)
        }
        return inside | {path for path in ELSEWHERE if path.exists()}

    with tried_node(
        bags, max_parts=20, max_drops=1000, environment=environment, folder=work
    ) as (_, client):
        files_before = listing()
        publisher = MeshPublisher(client).matched()
        camera = MeshPublisher(
            client, f"{client.prefix}/pose_counts", PoseCounts
        ).matched()
        for name in HOSTILE_NAMES:
            _use(
                client, publisher, camera, name.replace("\0", "\x01")
            )  # rclpy cuts at zero
        publish_in_turn(client, WEDGE, [new_id()])
        written = listing() - files_before
        strange = [
            path.name for path in bags.rglob("*") if not OWN_NAMES.fullmatch(path.name)
        ]
        assert_serves(client)
    return judged(
        len(HOSTILE_NAMES),
        f"written elsewhere: {sorted(map(str, written))}, strange: {strange}",
        nothing_is_written_elsewhere=not written,
        files_have_their_own_names=not strange,
    )


def _use(client, publisher, camera, name):
    """A name by every way in."""
    part = flat(WEDGE, name)
    part.header.frame_id = name
    answer = client.call("estimate", part=part)
    started = client.call("start_drop_simulation", part=part, drops=5)
    for response in (
        answer,
        started,
        client.call("estimate", part_id=name, method=name),
    ):
        assert_line(response.message)
    for service in ("get_drop_simulation", "cancel_drop_simulation"):
        assert not client.call(service, job_id=name).success
    camera.publish(PoseCounts(part_id=name, plate=name))
    publisher.publish(part)
    if answer.success and started.success:
        finished(client, started.job_id)
        client.good("forget_part", part_id=answer.statistics.part_id)
