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

"""Parts that have left memory: what needs them has them built where meshes are built.

A callback that builds one keeps others waiting, and a lock with it.
"""

import pytest

from ..harness.camera import counted, counting, learnt, lying, picture, seeing
from ..harness.cell import MeshPublisher
from ..harness.client import until
from ..harness.goals import Goals, planned
from ..harness.jobs import finished, start
from ..harness.parts import WEDGE, flat, new_id, scaled

BUILT = "a part is built"
OUTSIDE = f"{BUILT} outside of the lanes"

WATCHED = f"""
import sys, threading
from ros_pose_stats.node.entry import main
from ros_pose_stats.node.parts.part_builder import PartBuilder

build = PartBuilder.build

def build_watched(builder, request):
    name = threading.current_thread().name
    is_inside = name.endswith(" lane") or name.startswith("jobs")
    print("{BUILT}" if is_inside else "{OUTSIDE}, in " + name, file=sys.stderr)
    sys.stderr.flush()
    return build(builder, request)

PartBuilder.build = build_watched
sys.exit(main())
"""
"""A node that tells which threads build."""

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
