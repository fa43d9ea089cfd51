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

"""Who listens hears of a part that the node does not know any more; who comes later
does not.
"""

import math
import re
import signal
import sys

import pytest
from ros_pose_stats_msgs.msg import JobStatus, Note

from ros_pose_stats import estimate, simulate

from ..harness.cell import latched, publishers_of_parts
from ..harness.client import RUNNING, is_farewell, until
from ..harness.jobs import LONG, cancelled, finished, known_part, reached, start
from ..harness.listed import recorded_of
from ..harness.node import Running
from ..harness.parts import (
    WEDGE,
    counts,
    flat,
    library_part,
    new_id,
    probabilities,
    scaled,
)

LISTENER = """
import sys, rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs.msg import PoseStatistics
rclpy.init(domain_id=int(sys.argv[1]))
node = rclpy.create_node("listener")
node.create_subscription(PoseStatistics, sys.argv[2], lambda message: print(
    message.part_id, flush=True), QoSProfile(
        depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL))
rclpy.spin(node)
"""


def test_a_subscriber_hears_it_once_and_last(cell, shared_node):
    part_id = known_part(cell)
    with cell.late_joiner() as listener:
        first_result = listener.wait(part_id)
        cell.good("forget_part", part_id=part_id)
        last = listener.wait(part_id, is_farewell)
        assert (last.part_digest, last.header.frame_id, last.radius, last.final) == (
            first_result.part_digest,
            first_result.header.frame_id,
            first_result.radius,
            True,
        )
        assert not last.poses and math.isnan(last.expected_error)
        assert last.revision > first_result.revision
        assert last.warnings == [
            Note(
                code="FORGOTTEN",
                text="a client had the part forgotten; send the mesh again to get "
                "results.",
                acts=True,
            )
        ]
        listener.wait(known_part(cell))
        assert [is_farewell(message) for message in listener.of(part_id)] == [
            False,
            True,
        ]
    for service in ("get_statistics", "estimate", "forget_part"):
        assert f"'{part_id}'" in cell.refused(service, part_id=part_id)
    assert part_id not in {
        message.part_id for message in cell.good("get_statistics").statistics
    }
    (event,) = recorded_of(shared_node, "job_events", part_id)
    assert event.part_forgotten and event.header.stamp == last.header.stamp
    assert event.status == JobStatus(part_id=part_id)


def test_late_joiners_hear_nothing_and_its_publisher_goes(tuned):
    kept_part = known_part(tuned)
    forgotten_part = known_part(tuned)
    until(lambda: publishers_of_parts(tuned) == 2, "a publisher each")
    tuned.good("forget_part", part_id=forgotten_part)
    until(lambda: publishers_of_parts(tuned) == 1, "the end of its publisher")
    with tuned.late_joiner() as joiner:
        joiner.wait(kept_part)
        joiner.wait(known_part(tuned))
        assert joiner.of(forgotten_part) == []


def test_a_part_that_comes_again_has_higher_numbers(cell):
    part_id = known_part(cell)
    with cell.late_joiner() as listener:
        for factor in (
            1.0,
            1.0,
            2.0,
            3.0,
        ):  # at once: its publisher may not have gone yet
            cell.good("forget_part", part_id=part_id)
            cell.good("estimate", part=flat((factor * WEDGE[0], WEDGE[1]), part_id))
        latched_statistics = latched(cell, part_id)
        listener.wait(
            part_id, lambda message: message.revision == latched_statistics.revision
        )
        numbers = [message.revision for message in listener.of(part_id)]
        assert numbers == sorted(set(numbers))
    with cell.late_joiner() as joiner:
        assert (
            joiner.wait(part_id, lambda message: message.poses).revision
            == latched_statistics.revision
        )


def test_its_simulations_go_on(cell):
    part_id = known_part(cell)
    short = start(cell, part_id, 2000)
    long = start(cell, part_id, LONG)
    cell.good("forget_part", part_id=part_id)
    assert finished(cell, short).statistics.drops == 2000
    reached(cell, long, RUNNING)
    assert cancelled(cell, long).statistics.part_id == part_id
    assert part_id not in {
        statistics.part_id for statistics in cell.good("get_statistics").statistics
    }


def size_of_a_part(client):
    """Bytes that it takes, as a refusal gives them."""
    client.set(max_part_bytes=1)
    message = client.refused("estimate", part=flat(WEDGE, new_id()))
    assert "(parameter max_part_bytes)" in message
    return int(re.search(r"got (\d+) bytes", message)[1])


@pytest.mark.parametrize("bound", ["max_parts", "max_part_bytes"])
def test_parts_that_make_room_go_with_the_reason(tuned, bound):
    """The least recently used one, where a new part comes or the bound is lowered."""
    room_for_one = 1 if bound == "max_parts" else int(1.2 * size_of_a_part(tuned))
    tuned.set(**{bound: 3 * room_for_one})
    first, used, third = (known_part(tuned) for _ in range(3))
    tuned.good("estimate", part_id=first)
    with tuned.late_joiner() as listener:
        for part_id in (first, used, third):
            listener.wait(part_id)
        fourth = known_part(tuned)
        listener.wait(fourth)
        assert bound in listener.wait(used, is_farewell).warnings[0].text
        tuned.set(**{bound: room_for_one})
        assert bound in listener.wait(third, is_farewell).warnings[0].text
        listener.wait(first, is_farewell)
        assert not is_farewell(listener.of(fourth)[-1])
    assert [
        statistics.part_id for statistics in tuned.good("get_statistics").statistics
    ] == [fourth]


def test_parts_that_leave_memory_are_known_as_before(tuned):
    """What is built of a single one takes more than the bound."""
    tuned.set(max_part_bytes=20_000)
    parts = {
        known_part(tuned, scaled(factor)): library_part(scaled(factor))
        for factor in (1.0, 1.1, 1.2, 1.3)
    }
    assert parts.keys() == {
        statistics.part_id for statistics in tuned.good("get_statistics").statistics
    }
    for part_id, part in parts.items():
        answer = tuned.good(
            "estimate", part_id=part_id, method="split", restitution=0.3
        ).statistics
        assert answer.part_digest == part.digest
        assert probabilities(answer.poses) == probabilities(
            estimate(part, "split", restitution=0.3).poses
        )
        job = finished(tuned, start(tuned, part_id, 50, seed=5)).statistics
        assert counts(job.poses) == counts(simulate(part, 50, seed=5).poses)


def test_a_subscriber_that_hangs_holds_up_nobody(domain, tuned):
    parts = [known_part(tuned) for _ in range(8)]
    with Running(
        *(sys.executable, "-W", "ignore", "-c", LISTENER),
        *(domain, f"{tuned.prefix}/pose_statistics"),
    ) as hangs:
        heard = set()
        while not heard >= set(parts):
            heard.add(hangs.says("").strip())
        hangs.process.send_signal(signal.SIGSTOP)
        with tuned.late_joiner() as listener:
            for part_id in parts:
                listener.wait(part_id)
                tuned.good("forget_part", part_id=part_id)
            for part_id in parts:
                listener.wait(part_id, is_farewell)
            until(lambda: publishers_of_parts(tuned) == 0, "the publishers to go")
