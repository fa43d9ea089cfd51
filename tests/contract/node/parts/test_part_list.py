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

"""What a planner with a queue of one message gets on ~/parts, of however many parts."""

import pytest
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros_pose_stats_msgs.msg import PartList

from ..harness.cell import MeshPublisher, cell_of
from ..harness.client import Client, until
from ..harness.parts import WEDGE, flat

NAMES = [f"part {number:02}" for number in range(12)]
FIELDS = ("part_id", "part_digest", "revision", "method", "expected_error", "final")


class Listener:
    """Keeps the lists that came to a subscription of depth 1."""

    def __init__(self, client):
        self.lists = []
        client.subscribe(
            PartList, f"{client.prefix}/parts", self.lists.append, latched=True, depth=1
        )

    def newest(self):
        return (
            [] if not self.lists else [shorten(part) for part in self.lists[-1].parts]
        )


def shorten(message):
    return tuple(getattr(message, name) for name in FIELDS)


def current(client):
    """The same of what ~/get_statistics answers."""
    results = client.good("get_statistics").statistics
    return sorted(shorten(result) for result in results)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("bags")


@pytest.fixture(scope="module")
def begin(domain, folder):
    return lambda: cell_of(domain, folder, "many", default_method="split")


@pytest.fixture(scope="module")
def early_planner(domain):
    """A planner that is there before the node."""
    with Client(domain, "/many/pose_stats") as client:
        yield client


@pytest.fixture(scope="module")
def lists(begin):
    """What came of twelve parts that were published together."""
    with begin() as (_, client):
        for topic in ("parts", "pose_statistics"):
            name = f"{client.prefix}/{topic}"
            (end,) = until(
                lambda name=name: client.node.get_publishers_info_by_topic(name), name
            )
            assert end.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
            assert end.qos_profile.reliability == ReliabilityPolicy.RELIABLE
        listener = Listener(client)
        until(lambda: listener.lists, "a list without parts")
        publisher = MeshPublisher(client).matched()
        publisher.publish(*(flat(WEDGE, name) for name in NAMES)).acknowledged()
        until(lambda: len(listener.newest()) == len(NAMES), "twelve parts in a list")
        assert listener.newest() == current(client)
        client.good("forget_part", part_id=NAMES[0])
        until(lambda: len(listener.newest()) == len(NAMES) - 1, "one part less")
        assert listener.newest() == current(client)
    return listener.lists


def test_depth_one_misses_no_part(lists):
    assert lists[0].parts == [] and lists[0].header.frame_id == "plate"
    assert [part.part_id for part in lists[-1].parts] == NAMES[1:]
    assert {part.method for part in lists[-1].parts} == {"split"}


def test_a_start_lists_all_parts_of_the_last_run_at_once(lists, early_planner, begin):
    listener = Listener(early_planner)
    with begin() as (_, client):
        until(lambda: listener.lists, "a list")
        assert listener.newest() == current(client)
    assert len(listener.lists) == 1
    assert len(listener.newest()) == len(lists[-1].parts)
