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

"""Messages that are not quite right, deaf clients, another node: this one serves on."""

import itertools
import math
import struct
import time
from pathlib import Path
from random import Random

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.action import PlanFeeding
from ros_pose_stats_msgs.msg import ObservedParts, PartMesh, PoseCounts
from shape_msgs.msg import Mesh
from type_description_interfaces.srv import GetTypeDescription

from ros_pose_stats import estimate, simulate

from .harness.camera import counted, lying, picture
from .harness.cell import Health, MeshPublisher, latched
from .harness.client import ask_until_answered, until, wait_for
from .harness.goals import plans
from .harness.jobs import finished, known_part, start
from .harness.listed import rows
from .harness.parts import (
    WEDGE,
    counts,
    flat,
    library_part,
    mesh,
    nested,
    new_id,
    probabilities,
)
from .harness.slow import memory

PUBLISHED = 60
ASKED = 30
AT_ONCE = 30
MEGABYTE = 2**20
MOST_GROWTH = 200 * MEGABYTE
UNHEARD_SECONDS = 0.1
"""For which the middleware waits for a client that it cannot reach."""
LONGEST_LINE = 2500
"""Characters of a refusal; it may name eight known parts."""

TOPICS = {
    PartMesh: "/tuned/pose_stats/part_mesh",
    Mesh: "/tuned/cad",
    PoseCounts: "/tuned/pose_stats/pose_counts",
    ObservedParts: "/tuned/pose_stats/observed_parts",
}
NAMES = [
    "",
    "part",
    "../evil",
    "/tmp/evil",
    "~/evil",
    "evil.mcap",
    "..",
    "a\nb",
    "\x1b[31mevil",
    "x" * 300,
    "käse",
    "$(touch evil)",
    "'; --",
    "%s%n",
]
NUMBERS = [math.nan, math.inf, -math.inf, -1.0, 0.0, 0.5, 1.0, 1e-310, 1e300]
COUNTS = [0, 1, 7, 2**31 - 1]


@pytest.fixture
def client(tuned):
    assert tuned.set(max_drops=1000, max_parts=20) == {}
    return tuned


def assert_serves(client):
    """An estimate, a simulation and a published mesh, all as the library has them."""
    part_id = new_id()
    part = library_part(WEDGE, part_id)
    answer = client.good("estimate", part=flat(WEDGE, part_id)).statistics
    assert probabilities(answer.poses) == pytest.approx(
        probabilities(estimate(part).poses)
    )
    dropped = finished(client, start(client, part_id, 300, seed=5)).statistics
    assert counts(dropped.poses) == counts(simulate(part, 300, seed=5).poses)
    MeshPublisher(client, "/tuned/cad", Mesh).matched().publish(mesh(WEDGE))
    until(lambda: latched(client, "cad").part_digest == part.digest, "the mesh")


def changed(random, data):
    """Serialised bytes with one thing wrong."""
    data, position = bytearray(data), random.randrange(len(data))
    match random.randrange(5):
        case 0:
            data[position] ^= 1 << random.randrange(8)
        case 1:
            del data[position:]
        case 2:
            data[position:position] = random.randbytes(random.randrange(1, 20))
        case 3:
            data[position & ~3 : (position & ~3) + 4] = random.choice(
                (b"\xff" * 4, bytes(4))
            )
        case 4:
            data[1] ^= 1  # the other order of bytes
    return bytes(data)


def sound_messages(client, kind):
    """Serialised messages of a kind that the node would take."""
    statistics = client.good("estimate", part=flat(WEDGE, "part")).statistics
    messages = {
        PartMesh: [
            flat(WEDGE, "part", restitution=0.3),
            nested(WEDGE, "nested"),
            flat(WEDGE),
        ],
        Mesh: [mesh(WEDGE)],
        PoseCounts: [counted(statistics, [3, 4, 5])],
        ObservedParts: [
            picture(
                "part",
                *map(lying, statistics.poses),
                confidence=[1.0] * len(statistics.poses),
            )
        ],
    }[kind]
    return [bytes(serialize_message(message)) for message in messages]


def test_published_bytes_with_something_wrong(node, client):
    random = Random(1)
    health = Health(client)
    refused_before = int(health.line("parts")[1]["refused"])
    size = memory(node.process.pid, "VmHWM")
    publisher_of_parts = MeshPublisher(client).matched()
    for kind, topic in TOPICS.items():
        publisher = MeshPublisher(client, topic, kind).matched()
        sound = sound_messages(client, kind)
        for _ in range(
            PUBLISHED // AT_ONCE
        ):  # not so many at a time that most are overrun
            publisher.publish(
                *(changed(random, random.choice(sound)) for _ in range(AT_ONCE))
            )
            part_id = new_id()
            publisher_of_parts.publish(flat(WEDGE, part_id))
            latched(client, part_id)
    health.eventually(
        "parts",
        lambda _, values: (
            values["meshes waiting"] == "0"
            and int(values["refused"]) > refused_before + len(TOPICS) * PUBLISHED // 5
        ),
    )
    assert memory(node.process.pid, "VmHWM") - size < MOST_GROWTH
    assert_serves(client)


def claim(text, *numbers, order="<", zeros=MEGABYTE):
    """The start of a message, with room behind it."""
    return (
        (b"\0\1\0\0" if order == "<" else bytes(4))
        + struct.pack(order + text, *numbers)
        + bytes(zeros)
    )


def test_claims_of_gigabytes_cost_no_memory(node, client):
    """Nor does a mesh of which the deserialiser would make 25 times as much."""
    huge = 2**32 - 1
    claims = {
        Mesh: [
            claim("I", huge),
            claim("II", 0, huge),
            claim("I", 7 * 2**18, zeros=9 * MEGABYTE),
            claim("I", huge, order=">", zeros=MEGABYTE // 4),
            claim("II", 0, 32 * MEGABYTE // 24, order=">", zeros=32 * MEGABYTE),
        ],
        PartMesh: [
            claim("IIIBxxxIBxxxI", 0, 0, 1, 0, 1, 0, huge),
            claim("III", 0, 0, huge),
        ],
        PoseCounts: [claim("III", 0, 0, huge, zeros=MEGABYTE // 2)],
        ObservedParts: [
            claim("IIIIQI", 0, 0, 0, 0, 0, huge, zeros=MEGABYTE // 2),
            claim("IIIIQI", 0, 0, 0, 0, 0, huge, order=">", zeros=MEGABYTE // 4),
        ],
    }
    health = Health(client)
    refused_before = int(health.line("parts")[1]["refused"])
    size = memory(node.process.pid, "VmHWM")
    for kind, messages in claims.items():
        MeshPublisher(client, TOPICS[kind], kind).matched().publish(*messages)
    claim_count = len(
        {(kind, len(message)) for kind in claims for message in claims[kind]}
    )
    health.eventually(
        "parts",
        lambda _, values: int(values["refused"]) >= refused_before + claim_count,
    )
    assert memory(node.process.pid, "VmHWM") - size < MOST_GROWTH


@pytest.mark.parametrize("stamp", [(2**31 - 1, 2**32 - 1), (-(2**31), 0)])
def test_a_mesh_may_have_a_stamp_that_no_clock_shows(client, stamp):
    message = flat(WEDGE, new_id())
    message.header.stamp.sec, message.header.stamp.nanosec = stamp
    MeshPublisher(client).matched().publish(message)
    latched(client, message.part_id)


def asked(kind, random):
    """A request in which every field is odd."""
    fields = {}
    for name, type_ in kind.get_fields_and_field_types().items():
        if type_ == "string":
            fields[name] = random.choice(NAMES)
        elif type_ == "double":
            fields[name] = random.choice(NUMBERS)
        elif type_ in ("uint64", "uint32"):
            fields[name] = random.choice(COUNTS)
        elif type_.endswith("PartMesh") and random.random() < 0.5:
            fields[name] = flat(
                WEDGE,
                random.choice(NAMES),
                unit=random.choice(NUMBERS),
                restitution=random.choice(NUMBERS),
            )
        elif type_ == "sequence<double>":
            fields[name] = [random.choice(NUMBERS)] * random.randrange(3)
    return fields


def assert_line(answer):
    assert answer.success or answer.message
    assert answer.message.isprintable() and len(answer.message) <= LONGEST_LINE
    assert "internal failure" not in answer.message


@pytest.mark.parametrize(
    "name",
    [
        "estimate",
        "start_drop_simulation",
        "forget_part",
        "get_drop_simulation",
        "cancel_drop_simulation",
        "fit_plate",
        "get_statistics",
    ],
)
def test_odd_requests(client, name):
    random = Random(1)
    kind = client.service(name).srv_type.Request
    answers = [wait_for(client.send(name, **asked(kind, random))) for _ in range(ASKED)]
    for answer in answers:
        assert_line(answer)
    assert not all(answer.success for answer in answers)


def test_odd_plans(client):
    random = Random(1)
    goals = [
        plans(client).send(**asked(PlanFeeding.Goal, random)) for _ in range(ASKED)
    ]
    for goal in goals:
        _, result = goal.result()
        assert_line(result)


def test_no_name_leads_out_of_the_log_directory(node, client):
    """By parts, jobs, methods, plates and frames, whichever way they come in."""
    publishers = [
        MeshPublisher(client, TOPICS[kind], kind).matched()
        for kind in (PartMesh, PoseCounts)
    ]
    for name in NAMES:
        part = flat(WEDGE, name)
        part.header.frame_id = name
        for message, publisher in zip(
            (part, PoseCounts(part_id=name, plate=name)), publishers, strict=True
        ):
            publisher.publish(message)
        answer = client.call("start_drop_simulation", part=part, drops=5)
        client.call("estimate", part_id=name, method=name)
        client.call("fit_plate", plate=name)
        for service in ("get_drop_simulation", "cancel_drop_simulation"):
            assert not client.call(service, job_id=name).success
        if answer.success:
            finished(client, answer.job_id)
    last = new_id()  # taken in its turn: none of these comes up in the next test
    publishers[0].publish(flat(WEDGE, last))
    latched(client, last)
    home = node.log_directory.parent
    evil = [
        path
        for path in itertools.chain(
            home.rglob("*"), Path.cwd().glob("*"), Path("/tmp").glob("evil*")
        )
        if "evil" in path.name
    ]
    assert evil == [] and {path.name for path in home.iterdir()} <= {
        "bags",
        ".ros",
        ".config",
    }


def test_two_nodes_have_parts_and_jobs_of_their_own(cell, tuned):
    part_id = new_id()
    for scale, client in ((1.0, cell), (2.0, tuned)):
        client.good("estimate", part=flat((scale * WEDGE[0], WEDGE[1]), part_id))
    first, second = (
        client.good("get_statistics", part_id=part_id).statistics[0]
        for client in (cell, tuned)
    )
    assert first.part_digest != second.part_digest
    jobs = [start(client, part_id, 500, seed=1) for client in (cell, tuned)]
    assert len(set(jobs)) == 2
    for client, job_id, foreign_job, statistics in zip(
        (cell, tuned), jobs, reversed(jobs), (first, second), strict=True
    ):
        assert finished(client, job_id).status.drops_done == 500
        assert foreign_job not in [row.job_id for row in rows(client)]
        with client.late_joiner() as joiner:
            assert joiner.wait(part_id).part_digest == statistics.part_digest


def test_a_service_of_rclpy_s_own_may_have_clients_that_cannot_hear(cell):
    hearing, deaf = (
        cell.node.create_client(
            GetTypeDescription,
            f"{cell.prefix}/get_type_description",
            qos_profile=QoSProfile(depth=10, durability=durability),
        )
        for durability in (DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL)
    )
    unknown = GetTypeDescription.Request(
        type_name="a/msg/B", type_hash="RIHS01_" + 64 * "0"
    )
    for _ in range(10):
        unanswered = deaf.call_async(unknown)
        assert not ask_until_answered(hearing, unknown).successful
    cell.good("estimate", part_id=known_part(cell))
    assert not unanswered.done()
    cell.run(lambda: [cell.node.destroy_client(client) for client in (hearing, deaf)])


def test_clients_that_cannot_hear_are_named_and_hold_up_nobody(cell, shared_node):
    """Their quality of service shuts out all answers, each after a while."""
    part_id = known_part(cell)
    request = srv.EstimatePoses.Request(part_id=part_id)
    deaf_clients = [
        cell.node.create_client(
            srv.EstimatePoses,
            f"{cell.prefix}/estimate",
            qos_profile=QoSProfile(
                depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL
            ),
        )
        for _ in range(5)
    ]

    def ask():
        return [deaf.call_async(request) for deaf in deaf_clients]

    lost_answer = "]: /pose_stats/estimate: an answer could not be delivered"
    until(
        lambda: (
            ask()
            and cell.good("estimate", part_id=part_id)
            and lost_answer in shared_node.log
        )
    )
    begin = time.monotonic()
    unanswered = [future for _ in range(20) for future in ask()]
    cell.good("estimate", part_id=part_id)
    cell.call("list_drop_simulations")
    seconds = time.monotonic() - begin
    assert seconds < 0.5 * UNHEARD_SECONDS * len(unanswered)
    assert not any(future.done() for future in unanswered)
    cell.run(lambda: [cell.node.destroy_client(deaf) for deaf in deaf_clients])
