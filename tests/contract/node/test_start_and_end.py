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

"""Starts that are refused in one line, odd ones that are not, and ends at any
moment.
"""

import itertools
import os
import signal
import sqlite3
import sys
from pathlib import Path

import pytest
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import Parameter, ParameterValue
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.action import SimulateDrops
from ros_pose_stats_msgs.msg import JobStatus, PoseCounts
from rosgraph_msgs.msg import Clock
from shape_msgs.msg import Mesh

from lab.bodies.slow import smooth_body
from tests.answers import write_stl
from tests.running import call_copy, call_here, is_gone, refusal

from .harness import ending
from .harness.bags import assert_readable_by_others, bags_of, ends, recorded
from .harness.camera import counted, counting
from .harness.cell import Health, MeshPublisher, cell_of, latched
from .harness.client import CANCELLED, RUNNING, until, wait_for
from .harness.goals import Goals, plans
from .harness.jobs import LONG, finished, known_part, running_with_results, start
from .harness.listed import rows
from .harness.parts import WEDGE, flat, mesh, new_id
from .harness.slow import builder_at_work, standing
from .harness.transports import SHARED_MEMORY


@pytest.fixture
def refused(domain, tmp_path):
    """The line of a start that must be refused."""
    return lambda *settings: refusal(
        "node",
        "--ros-args",
        "-p",
        f"log_directory:={tmp_path}",
        *[word for setting in settings for word in ("-p", setting)],
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("restitution:=2.5", ("restitution", "2.5", "below 1")),
        ("restitution:=high", ("restitution", "'high'", "double")),
        ("max_parts:=2.5", ("max_parts", "2.5", "integer")),
        ("log_directory:=7", ("log_directory", "7", "string")),
        ("log_directory:=~nobody_of_this_name/bags", ("log_directory", "nobody")),
        ("default_method:=guess", ("default_method", "'guess'", "combined")),
        ("plates:=/dev/null", ("plates", "/dev/null")),
        (f"mesh_topics:=['part=/{300 * 'x'}']", ("Invalid topic name", "length")),
        ("nonsense", ("nonsense",)),
    ],
)
def test_a_bad_parameter_is_refused_in_a_line_that_says_why(refused, arguments, words):
    line = (
        refused(arguments, "plate:=glass")
        if arguments.startswith("plates")
        else refused(arguments)
    )
    assert all(word in line for word in words), line


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ("[/a/clamp, /b/clamp]", "different part_id each"),
        ("['x=/a', 'x=/b']", "'x'"),
        ("[/a/x, 'x=/b']", "'x'"),
        ("[1, 2]", "string_array"),
        ("['part=~x']", "mesh_topics as"),
        ("['" + "x" * 201 + "=/a']", "printable"),
        ("['/" + "x" * 501 + "']", "mesh_topics"),
    ],
)
def test_mesh_topics_must_be_topics_with_a_name_each(refused, entries, words):
    line = refused(f"mesh_topics:={entries}")
    assert "mesh_topics" in line or "part_id" in line
    assert words in line, line


def test_arguments_that_are_no_ros_arguments(refused):
    assert "--fast" in refusal("node", "--fast")
    assert "rcl can read, got ['a:=1']; for instance" in refusal(
        "node", "--ros-args", "a:=1"
    )


@pytest.mark.parametrize(
    ("missing", "advice"),
    [
        ("rclpy", "source /opt/ros/jazzy/setup.bash"),
        ("ros_pose_stats_msgs", "docs/workspace.md"),
    ],
)
def test_without_ros_or_its_messages(monkeypatch, missing, advice):
    monkeypatch.setitem(sys.modules, missing, None)
    line = refusal("node", call=call_here)
    assert missing in line and advice in line and "make setup" in line


@pytest.fixture(scope="module")
def odd_cell(domain, tmp_path_factory):
    """A node with parameters of every form, on simulated time, that says what it does,
    beside a pipe; and its client.
    """
    bags = tmp_path_factory.mktemp("bags")
    run = bags / "pose_stats_20260202T024000_000000_42"
    run.mkdir()
    os.mkfifo(run / f"{run.name}_1.mcap")
    with cell_of(
        domain,
        bags,
        "odd",
        "--log-level",
        "odd.pose_stats:=debug",
        use_sim_time=True,
        restitution=0,
        max_job_seconds=5,
        drop_height=1,
        cluster_tolerance=0,
        workers=1,
        mesh_topics="[/cad/clamp, 'a=b=/cad/clamp', '~/mine', 'other=nut']",
    ) as (node, client):
        yield node, client


@pytest.fixture(scope="module")
def odd(odd_cell):
    return odd_cell[1]


def test_whole_numbers_lists_and_private_topics_are_taken(odd):
    values = odd.call("get_parameters", names=["restitution", "drop_height"]).values
    assert [parameter_value_to_python(value) for value in values] == [0.0, 1.0]
    for topic, names in (
        ("/cad/clamp", ("clamp", "a=b")),
        (f"{odd.prefix}/mine", ("mine",)),
        ("/odd/nut", ("other",)),
    ):
        MeshPublisher(odd, topic, Mesh).matched(len(names)).publish(mesh(WEDGE))
        for name in names:
            assert latched(odd, name).cluster_tolerance == 0.0


def test_stamps_are_those_of_the_clock_that_stands_until_somebody_publishes_it(
    odd_cell,
):
    """The node is ready, healthy and answers meanwhile, and warns once."""
    node, odd = odd_cell
    Health(odd).line("jobs")
    statistics = odd.good("estimate", part=flat(WEDGE, "wedge")).statistics
    assert (statistics.header.stamp.sec, statistics.header.stamp.nanosec) == (0, 0)
    finished(odd, start(odd, "wedge", 200))
    with odd.late_joiner() as joiner:
        joiner.wait("wedge")
    warning = "use_sim_time is true and nobody publishes /clock: stamps are 0"
    node.says(warning)
    clock = odd.node.create_publisher(Clock, "/clock", 1)
    until(lambda: clock.get_subscription_count() > 0, "the node")

    def stamp(part_id):
        clock.publish(Clock(clock=Time(sec=1234)))
        return odd.good(
            "estimate", part=flat(WEDGE, part_id)
        ).statistics.header.stamp.sec

    until(lambda: stamp(new_id()) == 1234, "the node's clock")
    assert sum(warning in line for line in node.lines) == 1


def test_debug_lines_are_about_parts_requests_and_jobs(odd_cell):
    """Each is the node's own: of rcl and rclpy there are hundreds at that level."""
    node, client = odd_cell
    part_id = new_id()
    client.good("estimate", part=flat(WEDGE, part_id))
    client.refused("get_statistics", part_id="nobody")
    finished(client, start(client, part_id, 200))
    for words in (
        f"request for '{part_id}': a mesh of ",
        f"{part_id}: revision 1 latched, by ",
        "/odd/pose_stats/estimate: answered after ",
        " ms: expected the part_id of a known part",
        f": RUNNING: drops of '{part_id}'",
    ):
        until(lambda words=words: any(words in line for line in node.lines), words)
    debug_lines = [line for line in node.lines if line.startswith("[DEBUG]")]
    assert debug_lines
    assert all(" [odd.pose_stats]: " in line for line in debug_lines)


def test_what_rclpy_itself_cannot_take_ends_nothing(node_of, client_of):
    """A negative time, a value of no type, and goals whose client cannot hear."""
    node = node_of(use_sim_time=True).ready()
    client = client_of()
    part_id = known_part(client)
    action = SimulateDrops.Impl.SendGoalService
    deaf = client.node.create_client(
        action,
        f"{client.prefix}/simulate_drops/_action/send_goal",
        qos_profile=QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL),
    )
    goal = action.Request(goal=SimulateDrops.Goal(part_id=part_id, drops=10))
    until(
        lambda: deaf.call_async(goal) and client.call("list_drop_simulations").jobs,
        "a job",
    )
    clock = client.node.create_publisher(Clock, "/clock", 1)
    negative = Clock(clock=Time(sec=-5))
    goes_on = "the node goes on: ValueError: "
    until(
        lambda: (
            clock.publish(negative) or f"{goes_on}Seconds value must not" in node.log
        )
    )
    client.send("set_parameters", parameters=[Parameter(value=ParameterValue(type=77))])
    node.says(f"{goes_on}77 is not a valid")
    assert client.good("estimate", part_id=part_id).statistics.header.stamp.sec == 0
    node.send(signal.SIGTERM)
    assert node.ended() == 0


def test_a_file_of_plates_is_a_small_file(refused, tmp_path):
    """No pipe that nobody writes to, no device without an end, no aliases of
    aliases.
    """
    file = tmp_path / "plates.yaml"
    os.mkfifo(file)
    assert "a pipe" in refused(f"plates:={file}", "plate:=glass")
    assert "a device" in refused("plates:=/dev/zero", "plate:=glass")
    file.unlink()
    lines = [
        f"{name}: &{name} [{', '.join(9 * ['*' + previous])}]"
        for previous, name in itertools.pairwise("abcdefghi")
    ]
    for text, words in (
        ("\n".join(["a: &a [x]", *lines]), "values"),
        ("plates:\n" + "".join(f"  p{k}: x\n" for k in range(300)), "256 plates"),
        ("#" * 300_000, "262144 bytes"),
    ):
        file.write_text(text)
        assert words in refused(f"plates:={file}", "plate:=glass")


ENDING = "expected a running node, got one that is ending; start it again"


def catches(process, number):
    """Whether a process handles a signal itself."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    caught = int(status.partition("SigCgt:")[2].split()[0], 16)
    return bool(caught >> (number - 1) & 1)


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)]
)
def test_before_it_is_ready(node_of, number):
    node = node_of()
    until(lambda: catches(node.process, signal.SIGTERM), "the handlers")
    node.stop(number)


STUCK = """
import ctypes, sys, time
from rclpy.node import Node
from ros_pose_stats.node.parts.registry import PartRegistry

def never_ends(*arguments):
    while True:
        time.sleep(0.0)

def locks_the_interpreter(*arguments):
    ctypes.PyDLL(None).sleep(1000)

{}
from ros_pose_stats.node.entry import main
sys.exit(main())
"""


@pytest.mark.parametrize(
    ("stuck", "status"),
    [
        ("PartRegistry.forget = never_ends", 0),
        ("Node.destroy_node = locks_the_interpreter", -signal.SIGALRM),
    ],
)
def test_what_never_ends_keeps_nothing_from_ending(
    node_of, client_of, tmp_path, stuck, status
):
    """What was acknowledged is in the state, and the bag is whole."""
    node = node_of(program=["-c", STUCK.format(stuck)]).ready()
    client = client_of()
    client.good("estimate", part=flat(WEDGE, "kept"))
    job_id = start(client, "kept", LONG)
    running_with_results(client, job_id)
    for _ in range(0 if status else 2):
        client.send("forget_part", part_id="kept")
    client.good("estimate", part_id="kept")
    node.send(signal.SIGTERM)
    assert node.ended() == status
    with sqlite3.connect(tmp_path / "bags" / "pose_stats.sqlite3") as state:
        assert state.execute("SELECT part_id FROM parts").fetchall() == [("kept",)]
        assert state.execute("SELECT job_id, state FROM jobs").fetchall() == [
            (job_id, CANCELLED)
        ]
    assert_readable_by_others(*bags_of(tmp_path / "bags"))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda file: None, "newer"),
        (lambda file: os.mkfifo(file.with_name("pipe")), "pipe"),
    ],
)
def test_a_state_file_that_is_not_to_be_touched_is_refused(
    refused, tmp_path, make, words
):
    with sqlite3.connect(tmp_path / "newer") as link:
        link.execute("CREATE TABLE parts (part_id)")
        link.execute("PRAGMA user_version=99")
    make(tmp_path / "newer")
    line = refused(f"state_file:={tmp_path / words}")
    assert words in line and "state" in line


PATIENT = """
import sys
from ros_pose_stats.node import node
from tests.contract.node.harness.ending import main

node.KILL_SECONDS = 240.0
node.END_SECONDS = node.LAST_SECONDS = 120.0
node.QUIET_SECONDS = 1.0
sys.exit(main())
"""
"""A node that sees its clients off, however busy the machine is."""


@pytest.fixture(scope="module")
def ended(domain, tmp_path_factory):
    """A node that was ended with its hands full; its folder, and what it told its
    clients.
    """
    folder = tmp_path_factory.mktemp("bags")
    outcomes = {}
    program = ("-c", PATIENT, "node")
    with cell_of(
        domain,
        folder,
        "leaving",
        refine_drops=LONG,
        program=program,
        environment=SHARED_MEMORY,
    ) as (node, client):
        part_id = known_part(client)
        until(lambda: RUNNING in [row.state for row in rows(client)], "a refinement")
        outcomes["running"] = start(client, part_id, LONG, seed=5)
        outcomes["queued"] = start(client, part_id, LONG, seed=6)
        running_with_results(client, outcomes["running"])
        goals = Goals(client)
        goal = goals.send(part_id=part_id, drops=LONG, seed=7)
        model = client.good("get_statistics", part_id=part_id).statistics[0]
        open_ended = bytes(serialize_message(PoseCounts(part_id="abc"))).replace(
            b"abc\0", b"abcd"
        )
        counting(client).publish(
            open_ended, *(counted(model, [number]) for number in range(300))
        ).acknowledged()
        plan = plans(client)
        slow = client.send("estimate", part=flat(smooth_body(12_000), "long"))
        with standing(builder_at_work(node.process.pid)) as builder:
            outcomes["many"] = [
                client.send("estimate", part_id=part_id, restitution=0.3 + 1e-4 * k)
                for k in range(200)
            ]
            feeding = plan.send(
                part_id=part_id,
                wanted=[0],
                dropped_per_minute=40.0,
                cycle_seconds=0.5,
                kick_height=0.012,
            )
        node.stop(signal.SIGTERM)
        outcomes["waited"] = wait_for(slow), feeding.result()[1]
        outcomes["many"] = [wait_for(future) for future in outcomes["many"]]
        outcomes["goal"] = goal.result()[1]
        until(lambda: is_gone(builder), "the end of the builder")
        goals.close()
        outcomes["remains"] = ending.read_remains(node.log.removesuffix("(end)"))
    return folder, outcomes


def test_jobs_are_cancelled_once_and_what_was_done_is_kept(ended):
    folder, outcomes = ended
    endings = ends(folder)
    assert {
        outcomes["running"],
        outcomes["queued"],
        outcomes["goal"].job_id,
    } <= endings.keys()
    assert len(endings) == 4  # with the refinement
    for events in endings.values():
        assert [event.status.state for event in events] == [JobStatus.CANCELLED]
        assert events[0].message == "the node ended"
    last = [
        answer
        for answer in recorded(folder, "answers")
        if answer.job_id == outcomes["running"] and answer.final
    ][-1]
    assert last.drops == endings[outcomes["running"]][0].status.drops_done > 0


def assert_ends_with_its_process(remains):
    """A participant is never taken down, but its memory is removed."""
    assert remains["threads"] > 0 < remains["locks"]
    assert remains["memory"] == []


def test_its_participant_ends_with_the_process(ended):
    assert_ends_with_its_process(ended[1]["remains"])


PUBLISH = "publish", "{wedge}", "--unit", "m"


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (("node", "--ros-args", "-p", "default_method:=guess"), 2),
        ((*PUBLISH, "--seconds", 0, "--node", "nobody"), 2),
        ((*PUBLISH, "--node", "/pose_stats"), 0),
        (("show", "--node", "/pose_stats"), 0),
        (("show", "no such part", "--node", "/pose_stats"), 2),
    ],
)
def test_participants_of_commands_end_with_their_processes(
    cell, tmp_path, monkeypatch, words, status
):
    wedge = write_stl(tmp_path / "wedge.stl", WEDGE)
    words = [str(word).format(wedge=wedge) for word in words]
    if "--ros-args" not in words:
        words.append("--ros-args")
    for name, value in SHARED_MEMORY.items():
        monkeypatch.setenv(name, value)
    outcome = call_copy(
        f"{ending.__name__}:main", *words, "-r", f"__ns:={ending.LEAVING}"
    )
    assert outcome.returncode == status, outcome
    remains = ending.read_remains(outcome.stderr)
    assert_ends_with_its_process(remains)
    assert remains["nodes"] == []


def test_whoever_waits_is_told(ended):
    _, outcomes = ended
    assert not outcomes["goal"].success and "the node ended" in outcomes["goal"].message
    slow, _ = outcomes["waited"]
    assert not slow.success and slow.message == ENDING
    refused = {
        answer.message
        for answer in (*outcomes["waited"], *outcomes["many"])
        if not answer.success
    }
    assert refused == {ENDING}


def test_all_counts_that_had_come_and_no_half_built_part_are_recorded(ended):
    """ROS reads a text without its closing zero byte; other readers of CDR do not."""
    folder, _ = ended
    first, *counts = recorded(folder, "pose_counts")
    assert [count.count[0] for count in counts] == list(range(300)) and not first.count
    assert len(recorded(folder, "part_mesh")) == 1
    assert_readable_by_others(*bags_of(folder))
