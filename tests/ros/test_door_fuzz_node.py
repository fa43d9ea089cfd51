"""Messages that are not quite right, through the middleware: the node serves on."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from random import Random

import pytest
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.msg import PartMesh, PoseCounts
from shape_msgs.msg import Mesh

from ros_pose_stats import estimate, simulate
from tests.fuzz.messages.message_seeds import HOSTILE_NAMES, Seeds
from tests.fuzz.messages.messages import fuzzed
from tests.volume import few_quick

from .harness.cell import Health, MeshPublisher, cell_of, latched
from .harness.client import until, wait_for
from .harness.door import assert_line
from .harness.goals import Goals
from .harness.jobs import cancel_all, finished, start
from .harness.parts import WEDGE, counts, flat, library_part, mesh, new_id, probabilities
from .harness.readers import on_topic, raw_of
from .harness.sandbox import Sandbox
from .parts.test_flood import MEGABYTE, memory

SEED = 11
MESSAGES, REQUESTS, RAW, GOALS, AT_ONCE = 300, 60, 60, 12, 40
MOST_GROWTH = 150 * MEGABYTE
MOST_THREADS = 12
"""More than before; each goal that was cancelled has one for a moment."""

BAG_NAMES = re.compile(
    r"\.lock|metadata\.yaml(\.half)?|pose_stats_\d{8}T\d{6}_\d{6}_\d+(_\d\.mcap)?")


@pytest.fixture(scope="module")
def started(domain, tmp_path_factory):
    sandbox = Sandbox(tmp_path_factory.mktemp("sandbox"))
    with cell_of(domain, sandbox.bags, "fuzz", mesh_topics="[/fuzz/cad]", max_parts=20,
                 max_drops=1000, environment=sandbox.environment, folder=sandbox.work) as (
            node, client):
        yield node, client, sandbox


@pytest.fixture
def node(started):
    yield started[0]
    started[0].assert_sound()


@pytest.fixture
def client(started):
    yield started[1]
    cancel_all(started[1])


@pytest.fixture
def sandbox(started):
    return started[2]


TOPICS = {PartMesh: "/fuzz/pose_stats/part_mesh", Mesh: "/fuzz/cad",
          PoseCounts: "/fuzz/pose_stats/pose_counts"}
ASKED = ("estimate", "start_drop_simulation", "forget_part", "get_drop_simulation",
         "cancel_drop_simulation", "get_statistics")


def threads(node):
    return memory(node.process.pid, "Threads") // 1024


def assert_serves(client):
    """An estimate, a simulation and a published mesh, all as the library has them."""
    part_id = new_id()
    part = library_part(WEDGE, part_id)
    answer = client.good("estimate", part=flat(WEDGE, part_id)).statistics
    assert probabilities(answer.poses) == probabilities(estimate(part).poses)
    found = finished(client, start(client, part_id, 300, seed=5)).statistics
    assert counts(found.poses) == counts(simulate(part, 300, seed=5).poses)
    MeshPublisher(client, "/fuzz/cad", Mesh).matched().publish(mesh(WEDGE))
    until(lambda: latched(client, "cad").part_digest == part.digest, "the mesh")


def publish(client, publisher, messages):
    """A few at a time, so that most are not overrun."""
    known = MeshPublisher(client).matched()
    for first in range(0, len(messages), AT_ONCE):
        publisher.publish(*messages[first:first + AT_ONCE])
        part_id = new_id()
        known.publish(flat(WEDGE, part_id))
        latched(client, part_id)


@pytest.mark.long
@pytest.mark.parametrize("kind", few_quick(TOPICS, 1))
def test_published_bytes(node, client, kind):
    topic = TOPICS[kind]
    health = Health(client)
    assert_serves(client)
    before, size, number = (int(health.line("parts")[1]["refused"]),
                            memory(node.process.pid, "VmHWM"), threads(node))
    publisher = MeshPublisher(client, topic, kind).matched()
    publish(client, publisher, list(fuzzed(kind, SEED, MESSAGES)))
    line, values = health.line("parts", lambda _, values: values["meshes waiting"] == "0")
    assert int(values["refused"]) > before + MESSAGES // 10
    assert line.message.startswith("refused: ")
    assert memory(node.process.pid, "VmHWM") - size < MOST_GROWTH
    assert threads(node) <= number + MOST_THREADS
    assert_serves(client)


def test_bytes_that_are_no_count_are_not_recorded(node, client):
    camera = MeshPublisher(client, "/fuzz/pose_stats/pose_counts", PoseCounts).matched()
    part_id = new_id()
    camera.publish(b"\0\1\0\0" + b"\xee" * 40, PoseCounts(part_id=part_id))
    node.says(f"~/pose_counts: recorded, but no part '{part_id}'")
    assert "~/pose_counts: count refused: expected a serialised PoseCounts" in node.log
    recorded = raw_of(node.log_directory, on_topic("pose_counts"))
    assert any(part_id.encode() in data for data in recorded)
    assert not any(b"\xee" * 40 in data for data in recorded)


def sendable(message):
    """The fields of a request."""
    return {name: getattr(message, name) for name in message.get_fields_and_field_types()}


@pytest.mark.parametrize("name", few_quick(ASKED, 2))
def test_requests(node, client, name):
    seeds = Seeds(Random(SEED))
    kind = client.service(name).srv_type.Request
    requests = [seeds.make(kind) for _ in range(REQUESTS)]
    answers = [wait_for(client.send(name, **sendable(request))) for request in requests]
    assert all(answer.success or answer.message for answer in answers)
    assert not all(answer.success for answer in answers)
    for answer in answers:
        assert_line(answer.message)
    cancel_all(client)
    assert_serves(client)


def test_bytes_that_are_no_requests(node, client):
    """As only a broken or hostile client sends them: the middleware drops most of them."""
    before = client.call("list_drop_simulations")
    number = threads(node)
    command = [sys.executable, "-m", "tests.fuzz.messages.raw_requests", client.prefix,
               str(RAW), "1"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env={
            **os.environ, "ROS_PYTHON_CHECK_FIELDS": "0"}) as stranger:
        assert stranger.stdout.readline() == f"sent {7 * RAW}\n"
        for name in ASKED:  # they stand in line behind those
            known = "job_id" if name.startswith(("get_drop", "cancel")) else "part_id"
            assert "nobody" in client.call(name, **{known: "nobody"}).message
        cancel_all(client)
        stranger.stdin.close()
        assert stranger.wait() == 0
    assert len(client.call("list_drop_simulations").job_id) >= len(before.job_id)
    assert threads(node) <= number + MOST_THREADS
    assert_serves(client)


def test_goals(node, client):
    seeds, goals = Seeds(Random(SEED)), Goals(client)
    sent = [goals.send(**sendable(seeds.simulation(srv.StartDropSimulation.Request)))
            for _ in range(GOALS)]
    results = [goal.result()[1] for goal in sent]
    assert len({result.success for result in results}) == 2
    for result in results:
        assert_line(result.message)
    assert_serves(client)


@pytest.mark.long
def test_nothing_is_written_outside_the_log_directory(node, client, sandbox):
    """Whatever names come: as parts, jobs, methods, plates and frames, by every way in."""
    before = sandbox.listing()
    publisher = MeshPublisher(client).matched()
    camera = MeshPublisher(client, "/fuzz/pose_stats/pose_counts", PoseCounts).matched()
    for name in HOSTILE_NAMES:
        name = name.replace("\0", "\x01")  # behind a zero byte rclpy sends nothing
        part = flat(WEDGE, name)
        part.header.frame_id = name
        answer = client.call("estimate", part=part)
        started = client.call("start_drop_simulation", part=part, drops=5)
        client.call("estimate", part_id=name, method=name)
        for service in ("get_drop_simulation", "cancel_drop_simulation"):
            assert not client.call(service, job_id=name).success
        camera.publish(PoseCounts(part_id=name, plate=name, part_digest=name))
        publisher.publish(part)
        if answer.success and started.success:
            finished(client, started.job_id)
            client.good("forget_part", part_id=answer.statistics.part_id)
    publish(client, publisher, list(fuzzed(PartMesh, SEED + 1, AT_ONCE)))
    assert sandbox.listing() == before
    assert all(map(BAG_NAMES.fullmatch, sandbox.names_in_bags()))
    assert_serves(client)
