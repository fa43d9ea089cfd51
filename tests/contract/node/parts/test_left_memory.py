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

"""Parts that have left memory: their meshes are read and built in lanes alone.

A callback that does so keeps others waiting, and a lock with it.
"""

import shutil

import pytest

from ..harness.bags import bags_of, message_of, raw
from ..harness.camera import counted, counting, learnt, lying, picture, seeing
from ..harness.cell import MeshPublisher, latched
from ..harness.client import until
from ..harness.goals import Goals, planned
from ..harness.jobs import finished, start
from ..harness.listed import recorded_of
from ..harness.parts import WEDGE, flat, new_id, scaled

BUILT = "a part is built"
READ = "a mesh is read"
OUTSIDE = "outside of the lanes"

WATCHED = f"""
import sys, threading
from ros_pose_stats.node.entry import main
from ros_pose_stats.node.parts.part_builder import PartBuilder
from ros_pose_stats.node.parts.part_source import PartSource
from ros_pose_stats.node.state.store import State

def watched(function, line):
    def call(*arguments):
        name = threading.current_thread().name
        # The thread that is named so starts the node, and then waits for callbacks.
        is_inside = name.endswith(" lane") or name.startswith(("jobs", "executor"))
        print(line, "" if is_inside else f"{OUTSIDE}, in {{name}}", file=sys.stderr)
        sys.stderr.flush()
        return function(*arguments)
    return call

PartBuilder.build = watched(PartBuilder.build, "{BUILT}")
PartSource.mesh = watched(PartSource.mesh, "{READ}")
State.mesh = watched(State.mesh, "{READ}")
sys.exit(main())
"""
"""A node that tells which threads build parts and read meshes."""

ROOM = 5_000
"""Bytes: of several meshes like the wedge, and of no two of them once built."""


@pytest.fixture
def cramped(node_of, client_of, tmp_path):
    """A node that has one built part in memory, and its client."""
    node = node_of(
        program=["-c", WATCHED],
        max_part_bytes=ROOM,
        plates=tmp_path / "plates.yaml",
    )
    return node.ready(), client_of()


def test_no_callback_builds_a_part_that_has_left_memory(cramped):
    node, client = cramped
    part_id = new_id()
    with client.late_joiner() as joiner:
        MeshPublisher(client).matched().publish(flat(WEDGE, part_id))
        model = joiner.wait(part_id, lambda result: result.drops)

    other = client.good("estimate", part=flat(scaled(1.1), "other")).statistics

    def displace():
        """Have another part take the memory of the first."""
        client.good("get_statistics", part_id="other", heights=[0.001])

    def estimate():
        client.good("estimate", part_id=part_id)
        client.good("estimate", part_id=part_id, target_error=0.05)

    def see():
        seeing(client).publish(picture(part_id, lying(model.poses[0])))
        learnt(client, part_id, 1)

    def count():
        camera = counting(client)
        for result, number in ((model, 71), (other, 70)):
            camera.publish(counted(result, [40, 30]))
            learnt(client, result.part_id, number)

    def fit():
        client.good("fit_plate", plate="glass", apply=True)

    def count_on_a_fitted_plate():
        counting(client).publish(counted(model, [1]))
        learnt(client, part_id, 72)

    def outline():
        client.good("get_statistics", part_id=part_id, heights=[-1.0])

    def plan():
        wanted = [model.poses[0].index]
        planned(client, part_id=part_id, wanted=wanted, dropped_per_minute=60.0)

    def simulate():
        finished(client, start(client, part_id, 100))

    def flip():
        goals = Goals(client, "simulate_flips")
        goal = goals.send(part_id=part_id, kick_height=0.01, drops=10)
        assert goal.result()[1].success
        goals.close()

    def divide():
        assert client.set(round_sides=96) == {}
        until(
            lambda: (
                client.good("get_statistics", part_id=part_id).statistics[0].round_sides
                == 96
            )
        )

    for question in (estimate, see, outline, plan, simulate, flip):
        displace()
        built_before = node.log.count(BUILT)
        question()
        # What the node has said may still be on its way.
        until(
            lambda before=built_before: node.log.count(BUILT) > before,
            f"a part to be built for {question.__name__}",
        )
    # These need no part, or have all parts shown again when the node is idle.
    for question in (count, fit, count_on_a_fitted_plate, divide):
        displace()
        question()
    node.stop()
    assert OUTSIDE not in node.log


def follow_meshes(node):
    """Whether answers and counts of a part come behind its mesh in each bag."""
    for bag in bags_of(node.log_directory):
        introduced = set()
        for topic, data in raw(bag):
            kind = topic.rpartition("/")[2]
            if kind not in ("part_mesh", "answers", "pose_counts"):
                continue
            part_id = message_of(topic, data).part_id
            if kind == "part_mesh":
                introduced.add(part_id)
            elif part_id not in introduced:
                return False
    return True


def test_no_callback_reads_the_mesh_of_a_part_of_an_earlier_run(node_of, client_of):
    """The bag has it before answers and counts, and forgetting needs none."""
    values = {
        "program": ["-c", WATCHED],
        "max_part_bytes": ROOM,
        "default_method": "csae",
    }
    node = node_of(**values).ready()
    client = client_of()
    names = ["asked", "counted", "simulated", "forgotten", "displaced"]
    for number, part_id in enumerate(names):
        part = flat(scaled(1.0 + 0.1 * number), part_id)
        client.good("estimate", part=part)
    node.stop()

    node = node_of(**values).ready()
    client.good("estimate", part_id="asked")
    camera = counting(client)
    camera.publish(counted(latched(client, "counted"), [1]))
    learnt(client, "counted", 1)
    finished(client, start(client, "simulated", 100))
    client.good("forget_part", part_id="forgotten")
    for bag in bags_of(node.log_directory):
        shutil.rmtree(bag)
    camera.publish(counted(latched(client, "counted"), [1]))
    learnt(client, "counted", 2)
    until(lambda: recorded_of(node, "pose_counts", "counted"), "a count on record")
    assert client.set(max_parts=1) == {}
    until(lambda: len(client.good("get_statistics").statistics) == 1)
    node.stop()
    assert follow_meshes(node)
    assert READ in node.log
    assert OUTSIDE not in node.log
